"""The wired system in Ecos: all models step at once, signals move between steps (parallel
exchange), so the command acts one communication step late.

    python examples/fmu/race_ecos.py                # FMI 2.0
    python examples/fmu/race_ecos.py --fmi 3

Needs ecospy (and its libtbb12). `make fmu` writes the system to out/fmu.
"""

import argparse
from pathlib import Path

from ecospy import EcosSimulation

STEP = 0.01


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmus", type=Path, default=Path("out/fmu"), help="folder of `make fmu`")
    parser.add_argument("--fmi", choices="23", default="2", help="FMI version")
    parser.add_argument("--laps", type=int, default=5)
    options = parser.parse_args()
    folder = options.fmus if options.fmi == "2" else options.fmus / "fmi3"

    times = []
    with EcosSimulation(ssp_path=str(folder / "lmpc-race.ssp"), step_size=STEP) as simulation:
        # Without the name, the parameters of the system description are not applied.
        simulation.init(parameter_set="initialValues")
        for _ in range(int(400 / STEP)):
            simulation.step(1)
            finished = simulation.get_real("controller::lap.finished")
            if finished > len(times):
                times.append(simulation.get_real("controller::lap.last_time"))
                print(f"lap {len(times)}: {times[-1]:.3f} s")
            if len(times) >= options.laps:
                break
        simulation.terminate()
    print(f"Ecos, FMI {options.fmi}, parallel exchange every {STEP} s: {len(times)} laps")
    if len(times) < options.laps:
        raise SystemExit(f"only {len(times)} of {options.laps} laps were finished")


if __name__ == "__main__":
    main()
