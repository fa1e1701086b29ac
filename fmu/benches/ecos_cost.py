"""What Ecos needs per step: for two trivial FMUs wired to each other, and for controller and car.

    cargo test -p fmu_core --test fmpy                    # packs the trivial FMU
    python fmu/benches/ecos_cost.py target/debug/fmu out/fmu

The controller solves in every tenth step; its own solve time is one of its outputs.
"""

import statistics
import sys
import time
from pathlib import Path

from ecospy import EcosSimulation, EcosSimulationStructure

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples/fmu"))
from race_ecos import STEP, wired  # noqa: E402

STEPS = 9000


def trivial(path):
    structure = EcosSimulationStructure()
    for name in "ab":
        structure.add_model(name, str(path))
    structure.make_real_connection("a::x", "b::u")
    structure.make_real_connection("b::x", "a::u")
    return structure


def run(structure, observe=lambda simulation: None):
    times = []
    with EcosSimulation(structure=structure, step_size=STEP) as simulation:
        simulation.init()
        for _ in range(STEPS):
            begin = time.perf_counter()
            simulation.step(1)
            times.append(1e6 * (time.perf_counter() - begin))
            observe(simulation)
    return times


def main():
    probes, fmus = Path(sys.argv[1]), Path(sys.argv[2])
    for version in "23":
        empty = statistics.mean(run(trivial(probes / f"fmi{version}/probe.fmu")))
        solves, steps = [], [0.0]

        def observe(simulation):
            count = simulation.get_real("controller::status.steps")
            new = count != steps[-1]
            steps.append(count)
            solves.append(1e3 * simulation.get_real("controller::status.solve_ms") if new else 0.0)

        race = run(wired(fmus / f"fmi{version}"), observe)
        held = [t for t, solve in zip(race, solves) if solve == 0.0]
        solve, mean = statistics.mean(solves), statistics.mean(race)
        print(f"FMI {version}: trivial {empty:.2f} us, our solve {solve:.2f} us, controller and car "
              f"{mean:.2f} us per step: {mean / (empty + solve):.3f} times their sum; median without "
              f"solve {statistics.median(held):.2f} us")


if __name__ == "__main__":
    main()
