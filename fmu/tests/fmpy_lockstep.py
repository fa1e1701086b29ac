"""Holds the FMUs to the native race, bit for bit, through FMPy.

    lmpc race --seed 0 --laps 5 --out race
    python fmu/tests/fmpy_lockstep.py race/trajectory.csv out/fmu

All four mixes of FMI 2.0 and 3.0; then, for each version, back to a saved state half way, and in
a new process from the serialized bytes of that state.
"""

import csv
import struct
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples/fmu"))
from race_fmpy import PERIOD, STATE, Fmu  # noqa: E402

INPUTS = [f"vehicle.{name}" for name in STATE]
COMMAND = ["cmd.a", "cmd.delta"]


# What `lmpc race` tells the controller of the small car, whose grip is 0.9.
NOMINAL_MU = 1.2
LEAST = 500
# How the car starts: at the speed of the initial laps, which follows from car and track.
START = {}


def bits(numbers):
    return "%016x %016x" % struct.unpack("<2Q", struct.pack("<2d", *numbers))


def native(path):
    """The commands of a race; its numbers are printed so that reading them gives the same bits."""
    with Path(path).open(newline="") as file:
        rows = list(csv.DictReader(file))
    START["initial.v_x"] = float(rows[0]["v_x_mps"])
    learned = sum(row["action"] == "learned" for row in rows)
    assert len(rows) >= LEAST and learned > 100, f"{len(rows)} steps, {learned} learned: too few"
    return [bits([float(row["a_mps2"]), float(row["delta_rad"])]) for row in rows]


def make(fmus, controller, vehicle):
    return (Fmu(fmus / f"fmi{controller}/lmpc-controller.fmu", **{"param.nominal_mu": NOMINAL_MU}),
            Fmu(fmus / f"fmi{vehicle}/lmpc-vehicle.fmu", **START))


def drive(pair, begin, end):
    controller, vehicle = pair
    commands = []
    for k in range(begin, end):
        controller.set(INPUTS, vehicle.get(INPUTS))
        controller.step(k * PERIOD, PERIOD)
        command = controller.get(COMMAND)
        vehicle.set(COMMAND, command)
        vehicle.step(k * PERIOD, PERIOD)
        commands.append(bits(command))
    return commands


def state(fmu, verb, *arguments):
    """FMPy's name for one of the FMU state functions of this version."""
    name = f"{verb}FMUState"
    if not fmu.three:
        name = name.replace("State", "state").replace("deserialize", "deSerialize")
    return getattr(fmu.fmu, name)(*arguments)


def revive(fmus, version, files, half, expected):
    """In a new process: from bytes only."""
    pair = make(fmus, version, version)
    for fmu, file in zip(pair, files):
        state(fmu, "set", state(fmu, "deserialize", Path(file).read_bytes()))
    same(drive(pair, half, len(expected)), expected[half:], f"FMI {version}, new process")


def same(found, expected, what):
    for k, (a, b) in enumerate(zip(found, expected, strict=True)):
        assert a == b, f"{what}: step {k}: {a}, expected {b}"
    print(f"{what}: {len(found)} steps, equal bit for bit")


def main():
    if sys.argv[1] == "revive":
        race, fmus, version, half, *files = sys.argv[2:]
        revive(Path(fmus), version, files, int(half), native(race))
        return
    race, fmus = sys.argv[1], Path(sys.argv[2])
    expected = native(race)
    # In the middle of the learned steps.
    half = len(expected) - 100
    for controller in "23":
        for vehicle in "23":
            what = f"controller FMI {controller}, vehicle FMI {vehicle}"
            same(drive(make(fmus, controller, vehicle), 0, len(expected)), expected, what)
    for version in "23":
        pair = make(fmus, version, version)
        drive(pair, 0, half)
        saved = [state(fmu, "get") for fmu in pair]
        files = []
        for fmu, kept in zip(pair, saved):
            files.append(f"{fmu.folder.name}/state.bin")
            Path(files[-1]).write_bytes(bytes(state(fmu, "serialize", kept)))
        drive(pair, half, half + 50)
        for fmu, kept in zip(pair, saved):
            state(fmu, "set", kept)
        same(drive(pair, half, len(expected)), expected[half:], f"FMI {version}, rolled back")
        for fmu, kept in zip(pair, saved):
            state(fmu, "free", kept)
            fmu.fmu.terminate()
            fmu.fmu.freeInstance()
        command = [sys.executable, __file__, "revive", race, str(fmus), version, str(half)]
        subprocess.run([*command, *files], check=True)


if __name__ == "__main__":
    main()
