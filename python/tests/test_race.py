"""A race from Python is that of the command line, bit for bit."""

import csv
import os
import subprocess

import numpy as np
import pytest

import racing_lmpc as lmpc


def table(path):
    """The columns of a CSV file as text."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: [row[name] for row in rows] for name in rows[0]}


def same(column, texts):
    """Whether an array has the values of a column of text, to the last bit."""
    if column.dtype.kind == "U":
        return column.tolist() == texts
    if column.dtype.kind == "b":
        return column.tolist() == [text == "true" for text in texts]
    numbers = np.array([float(text) if text else np.nan for text in texts])
    return np.array_equal(numbers, column.astype(float), equal_nan=True)


@pytest.mark.parametrize(
    "arguments, keywords",
    [
        ([], {}),
        (["--seed", "7", "--laps", "3", "--plant", "noise=0.001,mu=0.85"],
         {"seed": 7, "laps": 3, "plant": {"noise": 0.001, "mu": 0.85}}),
        (["--car", "mini", "--laps", "2", "--preset", "paper", "--set", "horizon.steps=11"],
         {"car": "mini", "laps": 2, "config": {"preset": "paper", "horizon.steps": 11}}),
    ],
)
def test_race_is_that_of_the_command_line(tmp_path, arguments, keywords):
    out = tmp_path / "lmpc"
    run = subprocess.run(
        [os.environ["LMPC"], "race", "--out", out, *arguments], capture_output=True, text=True
    )
    assert run.returncode in (0, 3), run.stderr
    race = lmpc.race(**keywords)
    for name, columns in (("laps", race.laps), ("trajectory", race.trajectory)):
        texts = table(out / f"{name}.csv")
        assert list(columns) == list(texts)
        for column, values in columns.items():
            assert same(values, texts[column]), f"{name}: {column}"
    race.write(tmp_path / "python")
    for name in ("laps.csv", "trajectory.csv"):
        assert (tmp_path / "python" / name).read_bytes() == (out / name).read_bytes()
    steps = race.trajectory
    assert np.array_equal(race.x[:, 0], steps["v_x_mps"]) and race.u.shape == (len(race.x), 2)
    assert race.x.shape[1] == 6 and np.array_equal(race.u[:, 1], steps["delta_rad"])


def test_laps_are_seen_as_they_end_and_an_exception_ends_the_race():
    seen = []
    race = lmpc.race(laps=1, on_lap=seen.append)
    assert [lap["lap"] for lap in seen] == race.laps["lap"].tolist()
    assert seen[0]["kind"] == "warmup" and seen[0]["model_error_median"] is None

    class Enough(Exception):
        pass

    def stop(lap):
        raise Enough

    with pytest.raises(Enough):
        lmpc.race(on_lap=stop)


def test_a_failure_is_a_result_and_not_an_exception():
    race = lmpc.race(plant="mu=0.02", laps=1)
    assert race.failure["reason"] in ("off_track", "spin")
    assert race.failure["iteration"] == 0 and race.best_lap is None
    assert race.failure["x"].shape == (6,) and "m/s" in race.failure["message"]
