"""Controller FMU and vehicle FMU in Ecos: all models step at once, signals move between steps (parallel
exchange), so the command acts one communication step late.

    python examples/fmu/race_ecos.py                # FMI 2.0, wired here
    python examples/fmu/race_ecos.py --fmi 3
    python examples/fmu/race_ecos.py --ssp          # the wired system

Needs ecospy (and its libtbb12). `make fmu` writes FMUs and system to out/fmu.
"""

import argparse
from pathlib import Path

from ecospy import EcosSimulation, EcosSimulationStructure

STEP = 0.01
COMMAND = ["cmd.a", "cmd.delta"]
STATE = [f"vehicle.{n}" for n in ("v_x", "v_y", "omega_z", "e_psi", "s", "e_y", "x", "y", "psi")]


def wired(folder):
    """Both FMUs, every signal from a name to itself."""
    structure = EcosSimulationStructure()
    for name in ("controller", "vehicle"):
        structure.add_model(name, str(folder / f"lmpc-{name}.fmu"))
    for source, sink, names in [("controller", "vehicle", COMMAND), ("vehicle", "controller", STATE)]:
        for name in names:
            structure.make_real_connection(f"{source}::{name}", f"{sink}::{name}")
    return structure


def simulation_of(fmus, fmi, ssp):
    if not ssp:
        simulation = EcosSimulation(structure=wired(fmus / f"fmi{fmi}"), step_size=STEP)
        simulation.init()
        return simulation
    folder = fmus if fmi == "2" else fmus / "fmi3"
    simulation = EcosSimulation(ssp_path=str(folder / "lmpc-race.ssp"), step_size=STEP)
    # Without the name, the parameters of the system description are not applied.
    simulation.init(parameter_set="initialValues")
    return simulation


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmus", type=Path, default=Path("out/fmu"), help="folder of `make fmu`")
    parser.add_argument("--fmi", choices="23", default="2", help="FMI version")
    parser.add_argument("--ssp", action="store_true", help="read lmpc-race.ssp")
    parser.add_argument("--laps", type=int, default=5)
    options = parser.parse_args()
    times = []
    with simulation_of(options.fmus, options.fmi, options.ssp) as simulation:
        for _ in range(int(400 / STEP)):
            simulation.step(1)
            finished = simulation.get_real("controller::lap.finished")
            if finished > len(times):
                times.append(simulation.get_real("controller::lap.last_time"))
                print(f"lap {len(times)}: {times[-1]:.3f} s")
            if len(times) >= options.laps:
                break
        simulation.terminate()
    print(f"Ecos, FMI {options.fmi}{', SSP' if options.ssp else ''}, parallel exchange every {STEP} s: {len(times)} laps")
    if len(times) < options.laps:
        raise SystemExit(f"only {len(times)} of {options.laps} laps were finished")


if __name__ == "__main__":
    main()
