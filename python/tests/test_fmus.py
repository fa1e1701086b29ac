"""Campaigns over a pair of FMUs. They need FMPy and the FMUs of ``make fmu``, or of LMPC_FMUS."""

import os
import pathlib

import pytest

import racing_lmpc as lmpc
from racing_lmpc import engines, fmus

FOLDER = pathlib.Path(os.environ.get("LMPC_FMUS", pathlib.Path(__file__).parents[2] / "out" / "fmu"))
CONTROLLER = FOLDER / "fmi3" / "lmpc-controller.fmu"
VEHICLE = FOLDER / "fmi3" / "lmpc-vehicle.fmu"
assert CONTROLLER.exists(), f"no {CONTROLLER}: make fmu"


def pair(**more):
    return fmus.Pair(str(CONTROLLER), str(VEHICLE), duration=45.0, **more)


def test_processes_and_one_process_give_the_same_rows():
    axes = {"controller:param.warm_up.laps": [1.0, 2.0], "controller:param.seed": [0.0, 3.0]}

    def here(function, jobs):
        return ((job, function(job)) for job in list(jobs)[::-1])

    one = fmus.study(pair(), axes, here)
    assert fmus.study(pair(), axes, engines.processes(2)) == one
    assert [row["controller:param.warm_up.laps"] for row in one] == [1.0, 1.0, 2.0, 2.0]
    for row in one:
        assert not row["failure"] and len(row["lap_times_s"]) == row["controller:lap.finished"] >= 2
    # One warm-up lap less: the second lap is a learned one, and faster.
    assert one[0]["lap_times_s"][1] < one[2]["lap_times_s"][1]


def test_versions_of_fmi_mix():
    three, two = pair(), pair()
    two = fmus.Pair(str(FOLDER / "fmi2" / "lmpc-controller.fmu"), two.vehicle, duration=45.0)
    assert fmus.race(two)["lap_times_s"] == fmus.race(three)["lap_times_s"]


def test_what_does_not_fit_is_refused():
    with pytest.raises(lmpc.Error, match="no variable"):
        fmus.race(pair(), {"vehicle:param.colour": 1.0})
    with pytest.raises(lmpc.Error, match="controller:NAME"):
        fmus.race(pair(), {"param.colour": 1.0})
    with pytest.raises(lmpc.Error, match="no input"):
        fmus.race(fmus.Pair(str(CONTROLLER), str(CONTROLLER), duration=1.0))
