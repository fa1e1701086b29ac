"""The controller FMU drives a vehicle FMU made by a tool that is not ours (PythonFMU), through its
global pose, in lock-step through FMPy.

    pip install fmpy pythonfmu
    pythonfmu build -f examples/fmu/foreign_vehicle.py -d out/fmu/foreign
    python examples/fmu/race_foreign.py
"""

import argparse
import os
import sys
from pathlib import Path

from race_fmpy import PERIOD, Fmu

OUTPUTS = ["x", "y", "psi", "v_x", "v_y", "omega_z"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmus", type=Path, default=Path("out/fmu"), help="folder of `make fmu`")
    parser.add_argument("--foreign", type=Path, default=Path("out/fmu/foreign"))
    parser.add_argument("--controller", choices="23", default="2", help="FMI version")
    parser.add_argument("--laps", type=int, default=5)
    options = parser.parse_args()
    controller = Fmu(options.fmus / f"fmi{options.controller}/lmpc-controller.fmu",
                     **{"param.global_pose": True})
    vehicle = Fmu(options.foreign / "ForeignVehicle.fmu")
    inputs = [f"vehicle.{name}" for name in OUTPUTS]

    times = []
    for k in range(4000):
        time = k * PERIOD
        controller.set(inputs, vehicle.get(OUTPUTS))
        controller.step(time, PERIOD)
        vehicle.set(["a", "delta"], controller.get(["cmd.a", "cmd.delta"]))
        vehicle.step(time, PERIOD)
        finished, last, valid = controller.get(["lap.finished", "lap.last_time", "lap.last_valid"])
        if finished > len(times):
            times.append(last)
            print(f"lap {len(times)}: {last:.3f} s{'' if valid else ', not valid'}")
        if len(times) >= options.laps:
            break
    print(f"FMPy, controller FMI {options.controller}, vehicle by PythonFMU (FMI 2): "
          f"{len(times)} laps")
    if len(times) < options.laps:
        raise SystemExit(f"only {len(times)} of {options.laps} laps were finished")


if __name__ == "__main__":
    main()
    # The library PythonFMU makes reads freed memory when it is unloaded at the end of the process
    # (finalizePythonInterpreter), which may abort it: this ends before that.
    sys.stdout.flush()
    os._exit(0)
