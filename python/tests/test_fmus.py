"""The FMUs of the wheel, and campaigns over a pair of them. They need FMPy."""

import zipfile

import pytest

import racing_lmpc as lmpc
from racing_lmpc import engines, fmus

CONTROLLER = lmpc.fmu_path("controller")
VEHICLE = lmpc.fmu_path("vehicle")


def pair(**more):
    return fmus.Pair(str(CONTROLLER), str(VEHICLE), duration=45.0, **more)


@pytest.mark.parametrize("name", ["controller", "vehicle"])
@pytest.mark.parametrize("fmi", [2, 3])
def test_the_wheel_brings_fmus(name, fmi):
    path = lmpc.fmu_path(name, fmi)
    text = zipfile.ZipFile(path).read("modelDescription.xml").decode()
    assert f'fmiVersion="{fmi}.0"' in text and f'modelIdentifier="lmpc_{name}"' in text


def test_other_fmus_are_refused():
    with pytest.raises(ValueError, match="'controller' or 'vehicle'"):
        lmpc.fmu_path("car")
    with pytest.raises(ValueError, match="expected 2 or 3"):
        lmpc.fmu_path("vehicle", 1)


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
    two = fmus.Pair(str(lmpc.fmu_path("controller", 2)), two.vehicle, duration=45.0)
    assert fmus.race(two)["lap_times_s"] == fmus.race(three)["lap_times_s"]


def test_what_does_not_fit_is_refused():
    with pytest.raises(lmpc.Error, match="no variable"):
        fmus.race(pair(), {"vehicle:param.colour": 1.0})
    with pytest.raises(lmpc.Error, match="controller:NAME"):
        fmus.race(pair(), {"param.colour": 1.0})
    with pytest.raises(lmpc.Error, match="no input"):
        fmus.race(fmus.Pair(str(CONTROLLER), str(CONTROLLER), duration=1.0))
