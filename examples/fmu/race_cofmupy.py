"""Both FMUs in CoFMUPy, all stepped at once every 0.01 s, then their signals exchanged.

    python examples/fmu/race_cofmupy.py --fmi 3

Needs cofmupy. `make fmu` writes the FMUs to out/fmu.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

from cofmupy import Coordinator

STATE = ["v_x", "v_y", "omega_z", "e_psi", "s", "e_y"]
STEP = 0.01


def configuration(folder):
    fmus = [{"id": name, "name": name, "path": str((folder / f"lmpc-{name}.fmu").resolve())}
            for name in ("controller", "vehicle")]
    wires = [("controller", "vehicle", f"cmd.{name}") for name in ("a", "delta")]
    wires += [("vehicle", "controller", f"vehicle.{name}") for name in STATE]
    connections = [{"source": {"id": source, "variable": name, "type": "fmu"},
                    "target": [{"id": target, "variable": name, "type": "fmu"}]}
                   for source, target, name in wires]
    return {"fmus": fmus, "connections": connections, "cosim_method": "jacobi", "iterative": False}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmus", type=Path, default=Path("out/fmu"), help="folder of `make fmu`")
    parser.add_argument("--fmi", choices="23", default="3", help="FMI version")
    parser.add_argument("--laps", type=int, default=5)
    options = parser.parse_args()

    coordinator = Coordinator()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "system.json"
        path.write_text(json.dumps(configuration(options.fmus / f"fmi{options.fmi}")))
        coordinator.start(str(path))
        times = []
        for _ in range(40_000):
            coordinator.do_step(STEP)
            finished = coordinator.get_variable(("controller", "lap.finished"))[0]
            if finished > len(times):
                times.append(coordinator.get_variable(("controller", "lap.last_time"))[0])
                print(f"lap {len(times)}: {times[-1]:.3f} s", flush=True)
            if len(times) >= options.laps:
                return
    sys.exit(f"only {len(times)} of {options.laps} laps were finished")


if __name__ == "__main__":
    main()
