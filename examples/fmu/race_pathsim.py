"""The two FMUs as blocks in PathSim: at each event the controller steps first, then the car with the
new command (sequential exchange), so nothing is delayed.

    python examples/fmu/race_pathsim.py             # FMI 2.0
    python examples/fmu/race_pathsim.py --fmi 3

Needs pathsim-fmi. `make fmu` writes the FMUs to out/fmu.
"""

import argparse
from pathlib import Path

import fmpy
from pathsim import Connection, Simulation
from pathsim_fmi import CoSimulationFMU

STEP = 0.01


def names(path, causality):
    variables = fmpy.read_model_description(str(path)).modelVariables
    return [v.name for v in variables if v.causality == causality]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmus", type=Path, default=Path("out/fmu"), help="folder of `make fmu`")
    parser.add_argument("--fmi", choices="23", default="2", help="FMI version")
    parser.add_argument("--laps", type=int, default=5)
    options = parser.parse_args()
    folder = options.fmus / f"fmi{options.fmi}"
    paths = [folder / "lmpc-controller.fmu", folder / "lmpc-vehicle.fmu"]
    controller, vehicle = [CoSimulationFMU(str(path), path.stem, dt=STEP) for path in paths]

    # Equal names are connected.
    wires = []
    for source, sink, a, b in [(controller, vehicle, 0, 1), (vehicle, controller, 1, 0)]:
        outputs = names(paths[a], "output")
        wires += [Connection(source[n], sink[n]) for n in names(paths[b], "input") if n in outputs]
    simulation = Simulation([controller, vehicle], wires, dt=STEP, log=False)

    times = []
    for _ in range(4000):
        simulation.run(duration=0.1, reset=False, adaptive=False)
        outputs = dict(zip(names(paths[0], "output"), controller.outputs.to_array()))
        if outputs["lap.finished"] > len(times):
            times.append(outputs["lap.last_time"])
            print(f"lap {len(times)}: {times[-1]:.3f} s")
        if len(times) >= options.laps:
            break
    print(f"PathSim, FMI {options.fmi}, sequential exchange every {STEP} s: {len(times)} laps")
    if len(times) < options.laps:
        raise SystemExit(f"only {len(times)} of {options.laps} laps were finished")


if __name__ == "__main__":
    main()
