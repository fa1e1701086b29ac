"""The wired system in libcosim (FMI 2.0): fixed-step algorithm, parallel exchange, so the command
acts one communication step late.

    python examples/fmu/race_libcosim.py            # from the OSP system structure
    python examples/fmu/race_libcosim.py --ssp      # from the SSP file

Needs libcosimpy. `make fmu` writes the systems to out/fmu.
"""

import argparse
from pathlib import Path

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver

# Nanoseconds, as libcosim counts.
STEP = 10_000_000


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fmus", type=Path, default=Path("out/fmu"), help="folder of `make fmu`")
    parser.add_argument("--ssp", action="store_true", help="read lmpc-race.ssp")
    parser.add_argument("--laps", type=int, default=5)
    options = parser.parse_args()
    if options.ssp:
        path = options.fmus / "lmpc-race.ssp"
        execution = CosimExecution.from_ssp_file(str(path), step_size=STEP)
    else:
        execution = CosimExecution.from_osp_config_file(str(options.fmus / "osp"))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer)
    controller = execution.slave_index_from_instance_name("controller")
    variables = {v.name.decode(): v.reference for v in execution.slave_variables(controller)}
    names = [variables["lap.finished"], variables["lap.last_time"]]

    times = []
    for _ in range(40_000):
        execution.step(1)
        finished, last = observer.last_real_values(controller, names)
        if finished > len(times):
            times.append(last)
            print(f"lap {len(times)}: {last:.3f} s")
        if len(times) >= options.laps:
            break
    kind = "SSP" if options.ssp else "OSP"
    print(f"libcosim, FMI 2, {kind}, parallel exchange every {STEP / 1e9} s: {len(times)} laps")
    if len(times) < options.laps:
        raise SystemExit(f"only {len(times)} of {options.laps} laps were finished")


if __name__ == "__main__":
    main()
