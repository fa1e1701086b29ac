"""Campaigns on engines: whatever drives them, whatever is lost on the way, the table is that of
``lmpc study``."""

import os
import pathlib
import signal
import subprocess
import sys

import pytest

import racing_lmpc as lmpc
from racing_lmpc import engines

LMPC = os.environ.get("LMPC", "lmpc")
CAMPAIGN = """
title = "Grip and horizon"
laps = 2
seeds = 2
[set]
plant.noise = 0.0005
[[axis]]
key = "plant.mu"
values = [0.1, 0.8, 0.9, 1.0]
[[axis]]
key = "config.horizon.steps"
values = [10, 13]
[limits]
failed_runs = 16
"""


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """File of the campaign, and the table that ``lmpc study`` makes of it."""
    folder = tmp_path_factory.mktemp("campaign")
    file = folder / "grip.toml"
    file.write_text(CAMPAIGN)
    subprocess.run([LMPC, "study", file, "--out", folder / "rust", "--quiet"], check=True, capture_output=True)
    return file, (folder / "rust" / "runs.csv").read_bytes()


def table(folder: pathlib.Path) -> bytes:
    return (folder / "runs.csv").read_bytes()


def test_processes_give_the_table_of_the_program(campaign, tmp_path):
    file, expected = campaign
    rows = []
    assert engines.study(file, tmp_path, engines.processes(2), on_row=rows.append) == 16
    assert table(tmp_path) == expected
    assert len(rows) == 16 and sum(bool(row["failure"]) for row in rows) == 4
    # Nothing is left to do.
    assert engines.study(file, tmp_path, engines.processes(1)) == 0
    assert table(tmp_path) == expected


def test_an_interrupted_campaign_goes_on_where_it_stopped(campaign, tmp_path):
    file, expected = campaign

    def breaks(function, jobs):
        for i, job in enumerate(jobs):
            if i == 5:
                raise KeyboardInterrupt
            # Twice, as two workers may have driven it.
            yield job, function(job)
            yield job, function(job)

    with pytest.raises(KeyboardInterrupt):
        engines.study(file, tmp_path, breaks)
    assert table(tmp_path).count(b"\n") == 6
    assert engines.study(file, tmp_path, engines.processes(1)) == 11
    assert table(tmp_path) == expected


def test_a_worker_with_other_settings_is_refused(campaign, tmp_path):
    file, _ = campaign
    with pytest.raises(lmpc.CampaignError, match="same version"):
        engines.drive((str(file), 0, "0123"))
    opened = lmpc.Campaign(file)
    rows = opened.open(tmp_path)
    fields = opened.drive(0)
    with pytest.raises(lmpc.CampaignError, match="another campaign"):
        rows.add([*fields[:-1], "0123"])
    with pytest.raises(lmpc.CampaignError, match="fields"):
        rows.add(fields[:-1])
    rows.close()
    with pytest.raises(lmpc.CampaignError, match="closed"):
        rows.add(fields)


def test_dask_gives_the_same_table_with_a_worker_killed_half_way(campaign, tmp_path):
    import distributed

    file, expected = campaign
    with distributed.LocalCluster(
        n_workers=3, threads_per_worker=1, dashboard_address=None, local_directory=str(tmp_path / "dask")
    ) as cluster, distributed.Client(cluster) as client:
        arrived, killed = [], []

        def kill_one(row):
            arrived.append(row["run"])
            if len(arrived) == 6:
                # One that is driving a run now.
                busy = [worker for worker, keys in client.processing().items() if keys]
                pids = client.run(os.getpid)
                killed.append(pids[busy[0] if busy else next(iter(pids))])
                os.kill(killed[0], signal.SIGKILL)

        out = tmp_path / "out"
        assert engines.study(file, out, engines.dask(client), on_row=kill_one) == 16
        assert len(killed) == 1
        assert killed[0] not in client.run(os.getpid).values()
    assert sorted(arrived, key=int) == [str(i) for i in range(16)]
    assert table(out) == expected


def test_ray_gives_the_same_table(campaign, tmp_path, monkeypatch):
    import ray

    # Workers look into the current folder first, and the package there is not built.
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [p for p in sys.path if not (pathlib.Path(p) / "pyproject.toml").exists()])
    file, expected = campaign
    ray.init(num_cpus=2, include_dashboard=False, logging_level="error")
    try:
        engines.study(file, tmp_path, engines.ray())
    finally:
        ray.shutdown()
    assert table(tmp_path) == expected
