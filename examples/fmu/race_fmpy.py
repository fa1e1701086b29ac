"""Controller FMU and vehicle FMU in lock-step through FMPy: the controller first, then the car
with the new command, both with the controller's period as step. Nothing is delayed.

    python examples/fmu/race_fmpy.py                      # FMI 3.0, five laps
    python examples/fmu/race_fmpy.py --controller 2 --vehicle 3 --laps 10 --csv race.csv --plot race.png

Needs fmpy, and matplotlib for --plot. `make fmu` writes the FMUs to out/fmu.
"""

import argparse
import csv
import hashlib
import struct
import sys
import tempfile
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

STATE = ["v_x", "v_y", "omega_z", "e_psi", "s", "e_y", "x", "y", "psi"]
PERIOD = 0.1


class Fmu:
    """One FMU of either version with names instead of value references."""

    def __init__(self, path, **parameters):
        self.description = fmpy.read_model_description(str(path))
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.three = self.description.fmiVersion.startswith("3")
        self.folder = tempfile.TemporaryDirectory()
        fmpy.extract(str(path), self.folder.name)
        self.fmu = (FMU3Slave if self.three else FMU2Slave)(
            guid=self.description.guid or self.description.instantiationToken,
            unzipDirectory=self.folder.name,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName=self.description.modelName,
        )
        self.fmu.instantiate(loggingOn=False)
        if not self.three:
            self.fmu.setupExperiment(startTime=0.0)
        for name, value in parameters.items():
            self.set_parameter(name, value)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def set_parameter(self, name, value):
        variable = self.variables[name]
        kind = {"Float64": "Real", "Int32": "Integer"}.get(variable.type, variable.type)
        names = {"Real": ("setReal", "setFloat64"), "Integer": ("setInteger", "setInt32"),
                 "Boolean": ("setBoolean", "setBoolean"), "String": ("setString", "setString")}
        getattr(self.fmu, names[kind][self.three])([variable.valueReference], [value])

    def references(self, names):
        return [self.variables[name].valueReference for name in names]

    def get(self, names):
        get = self.fmu.getFloat64 if self.three else self.fmu.getReal
        return list(get(self.references(names)))

    def set(self, names, values):
        put = self.fmu.setFloat64 if self.three else self.fmu.setReal
        put(self.references(names), values)

    def step(self, time, size):
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=size)


def race(controller, vehicle, laps, on_step=None, longest=4000):
    """Drives until `laps` laps are finished; calls `on_step(k, time, state, command)`."""
    inputs = [f"vehicle.{name}" for name in STATE]
    times = []
    for k in range(longest):
        time = k * PERIOD
        state = vehicle.get(inputs)
        controller.set(inputs, state)
        controller.step(time, PERIOD)
        command = controller.get(["cmd.a", "cmd.delta"])
        vehicle.set(["cmd.a", "cmd.delta"], command)
        vehicle.step(time, PERIOD)
        if on_step:
            on_step(k, time, state, command)
        finished, last = controller.get(["lap.finished", "lap.last_time"])
        if finished > len(times):
            times.append(last)
        if len(times) >= laps:
            break
    return times


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmus", type=Path, default=Path("out/fmu"), help="folder of `make fmu`")
    parser.add_argument("--controller", choices="23", default="3", help="FMI version")
    parser.add_argument("--vehicle", choices="23", default="3", help="FMI version")
    parser.add_argument("--laps", type=int, default=5)
    parser.add_argument("--warm-up", type=float, default=None, help="initial laps, default 4")
    parser.add_argument("--track", default="l")
    parser.add_argument("--csv", type=Path, help="write every step here")
    parser.add_argument("--plot", type=Path, help="draw lap times and the line here")
    options = parser.parse_args()

    settings = {"param.track": options.track}
    if options.warm_up is not None:
        settings["param.warm_up.laps"] = options.warm_up
    controller = Fmu(options.fmus / f"fmi{options.controller}/lmpc-controller.fmu", **settings)
    vehicle = Fmu(options.fmus / f"fmi{options.vehicle}/lmpc-vehicle.fmu",
                  **{"param.track": options.track})
    rows, trace = [], hashlib.sha256()

    def on_step(k, time, state, command):
        rows.append([time, *state, *command])
        trace.update(struct.pack("<2d", *command))

    times = race(controller, vehicle, options.laps, on_step)
    for lap, lap_time in enumerate(times, 1):
        print(f"lap {lap}: {lap_time:.3f} s")
    print(f"FMPy, controller FMI {options.controller}, vehicle FMI {options.vehicle}: "
          f"{len(rows)} steps, trace of commands {trace.hexdigest()[:12]}")
    if options.csv:
        with options.csv.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["time", *STATE, "a", "delta"])
            writer.writerows(rows)
    if options.plot:
        plot(options.plot, times, rows)
    if len(times) < options.laps:
        sys.exit(f"only {len(times)} of {options.laps} laps were finished")


def plot(path, times, rows):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5))
    left.plot(range(1, len(times) + 1), times, "o-")
    left.set_xlabel("lap")
    left.set_ylabel("lap time [s]")
    left.grid(alpha=0.3)
    points = right.scatter([r[7] for r in rows], [r[8] for r in rows], c=[r[1] for r in rows], s=4)
    right.set_aspect("equal")
    right.set_xlabel("x [m]")
    right.set_ylabel("y [m]")
    figure.colorbar(points, label="v_x [m/s]")
    figure.tight_layout()
    figure.savefig(path, dpi=120)


if __name__ == "__main__":
    main()
