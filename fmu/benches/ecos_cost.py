"""What Ecos needs per step: for two trivial FMUs wired to each other, and for controller and car.

    cargo build --release -p fmu_core --examples          # the trivial and the hollow libraries
    cargo test --release -p fmu_core --test fmpy          # packs the trivial FMU
    python fmu/benches/ecos_cost.py target/release out/fmu

The controller solves in every tenth step. Its own time is one of its outputs and holds all of the
solve: lap-end learning, preparation, optimisation. Ecos walks all variables of a model twice per step,
so beside the two trivial FMUs stand two hollow ones, with the variables of controller and car and
nothing behind them. The car's step is what a car adds to its hollow self.
Steps in which the system took a processor away are left out; the rest is weighed one to nine again.
"""

import resource
import statistics
import sys
import tempfile
import time
import zipfile
from pathlib import Path

from ecospy import EcosSimulation, EcosSimulationStructure

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples/fmu"))
from race_ecos import STEP, wired  # noqa: E402

STEPS = 9000
PERIOD = 10  # steps from solve to solve


def trivial(path):
    structure = EcosSimulationStructure()
    for name in "ab":
        structure.add_model(name, str(path))
    structure.make_real_connection("a::x", "b::u")
    structure.make_real_connection("b::x", "a::u")
    return structure


def hollow(name, packed, libraries, to):
    """A packed FMU with another library: the same description, nothing behind it."""
    library = (libraries / f"libhollow_{name}.so").read_bytes()
    with zipfile.ZipFile(packed) as source, zipfile.ZipFile(to, "w") as target:
        for member in source.namelist():
            linux = member.endswith(f"lmpc_{name}.so")
            target.writestr(member, library if linux else source.read(member))


def disturbances():
    return resource.getrusage(resource.RUSAGE_SELF).ru_nivcsw


def run(structure, observe=lambda simulation: None):
    """Of each undisturbed step: its time [us] and what was observed after it."""
    kept = []
    with EcosSimulation(structure=structure, step_size=STEP) as simulation:
        simulation.init()
        observe(simulation)
        for _ in range(STEPS):
            before, begin = disturbances(), time.perf_counter()
            simulation.step(1)
            spent = 1e6 * (time.perf_counter() - begin)
            seen = observe(simulation)
            if disturbances() == before:
                kept.append((spent, seen))
    return kept


def race(folder):
    """Mean time of a step and of solving per step [us], and of a step without a solve."""
    steps = [0.0]

    def observe(simulation):
        count = simulation.get_real("controller::status.steps")
        new, steps[0] = count != steps[0], count
        return 1e3 * simulation.get_real("controller::status.solve_ms") if new else None

    kept = run(wired(folder), observe)
    solving = [(t, solve) for t, solve in kept if solve is not None]
    held = statistics.mean(t for t, solve in kept if solve is None)
    busy, solve = (statistics.mean(column) for column in zip(*solving))
    share = 1 / PERIOD
    return share * busy + (1 - share) * held, share * solve, held, len(kept)


def mean_step(structure):
    return statistics.mean(spent for spent, _ in run(structure))


def compare(version, built, packed, folder):
    """One line for an FMI version; `folder` gets the hollow FMUs, then the car beside a hollow one."""
    for name in ("controller", "vehicle"):
        file = f"lmpc-{name}.fmu"
        hollow(name, packed / file, built / "examples", folder / file)
    nothing = mean_step(wired(folder))
    (folder / "lmpc-vehicle.fmu").write_bytes((packed / "lmpc-vehicle.fmu").read_bytes())
    car = mean_step(wired(folder)) - nothing
    empty = mean_step(trivial(built / f"fmu/fmi{version}/probe.fmu"))
    mean, solve, held, kept = race(packed)
    print(f"FMI {version}, us per step: trivial {empty:.2f}, hollow {nothing:.2f}, our solve {solve:.2f}, our car "
          f"{car:.2f}, controller and car {mean:.2f} ({held:.2f} without a solve; {kept} of {STEPS} undisturbed)")
    print(f"  {mean / (empty + solve):.3f} x (trivial + solve), {mean / (empty + solve + car):.3f} x (trivial + "
          f"solve + car), {mean / (nothing + solve + car):.3f} x (hollow + solve + car)")


def main():
    built, fmus = Path(sys.argv[1]), Path(sys.argv[2])
    for version in "23":
        with tempfile.TemporaryDirectory() as folder:
            compare(version, built, fmus / f"fmi{version}", Path(folder))


if __name__ == "__main__":
    main()
