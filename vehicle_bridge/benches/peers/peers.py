#!/usr/bin/env python3
"""The optimal control problems of a race, solved by lmpc and by the field's best QP solvers, in one run.

    lmpc bench --case 1 --laps 4 --dump-qp out/qp
    pip install piqp clarabel scipy
    vehicle_bridge/benches/peers/peers.py target/release/lmpc out/qp

Every solver gets the same problems in turn, several rounds of them; the least time of each problem counts,
so that what a busy machine adds is left out. Printed are quantiles over the problems, the ratio of
our median to each, and the error of the first input against Clarabel at 1e-10.

PIQP reports its own times, without set-up and Python; Clarabel is timed inside lmpc, with the controller's
settings and memory, while the errors in its row are those of its solution at 1e-10. HPIPM is used where its Python package
`hpipm_python` and `libhpipm.so` are found (`HPIPM_PYTHON`: folder of the package; `LD_LIBRARY_PATH`: folder
of the library). It is tuned: the hull without one weight and centred on that point, previous input as
state only where a stage needs it, and the best mu0 of several, found on the problems themselves. Its time
is that of the solve alone, without filling its structures. Problems of one folder have one size.

The format of the problems is described in docs/qp_files.md.
"""

import argparse
import contextlib
import json
import pathlib
import subprocess
import sys

import numpy as np
from hpipm import Hpipm, find_hpipm
from problem import Problem
from sparse import Clarabel, Piqp, Sparse

TOLERANCE = 1e-8
IN_A_ROW = 5
MU0 = [1e-1, 1e0, 1e1, 1e2, 1e3]


def tuned(problems, mode, classical):
    """The mu0 with which HPIPM's median is least, of those that leave fewest problems unsolved."""

    def tried(mu0):
        results = [Hpipm(problem, TOLERANCE, mode, mu0, classical).solve() for problem in problems[::5]]
        return sum(not solved for _, solved, *_ in results), np.median([spent for spent, *_ in results])

    return min(MU0, key=tried)


def ours(lmpc, folder):
    """Our results and those of Clarabel inside lmpc, by name of the problem."""
    command = [lmpc, "bench", "--read-qp", folder, "--json"]
    rows = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
    solved = ("Solved", "AlmostSolved")

    def results(prefix):
        names = (f"{prefix}time_us", f"{prefix}status", f"{prefix}u_0", f"{prefix}cost")
        for row in rows:
            spent, status, u_0, cost = (row[name] for name in names)
            yield row["name"], (spent, status in solved, np.array(u_0), cost)

    return dict(results("")), dict(results("clarabel_"))


def main():
    """Solves and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("lmpc", help="the program lmpc")
    parser.add_argument("folder", help="problems, as `lmpc bench --dump-qp` writes them")
    parser.add_argument("--rounds", type=int, default=5, help="solves of each problem with each solver")
    parser.add_argument("--most", type=int, default=300, help="problems, evenly chosen if there are more")
    arguments = parser.parse_args()
    paths = sorted(pathlib.Path(arguments.folder).glob("*.json"))
    if not paths:
        sys.exit(f"{arguments.folder} holds no problems; `lmpc bench --dump-qp DIR` writes some")
    problems = [Problem(path) for path in paths[:: -(-len(paths) // arguments.most)]]
    sparse = [Sparse(problem) for problem in problems]
    solvers = {}
    with contextlib.suppress(ImportError):
        solvers["PIQP sparse_multistage"] = [Piqp(s, TOLERANCE) for s in sparse]
    if find_hpipm():
        for mode, classical in (("speed_abs", False), ("speed", True), ("balance", True)):
            mu0 = tuned(problems, mode, classical)
            name = f"HPIPM {mode}, mu0 {mu0:g}" + (", classical" if classical else "")
            solvers[name] = [Hpipm(p, TOLERANCE, mode, mu0, classical) for p in problems]
    inside = "Clarabel, tuned, inside lmpc"
    results = {name: {} for name in ("lmpc", inside, *solvers)}
    for _ in range(arguments.rounds):
        found, clarabel = ours(arguments.lmpc, arguments.folder)
        for k, problem in enumerate(problems):
            results["lmpc"].setdefault(problem.name, []).append(found[problem.name])
            results[inside].setdefault(problem.name, []).append(clarabel[problem.name])
            for name, instances in solvers.items():
                # In a row, as lmpc does: its memory is warm.
                runs = [instances[k].solve() for _ in range(IN_A_ROW)]
                results[name].setdefault(problem.name, []).append(min(runs, key=lambda run: run[0]))
    exact = {s.problem.name: Clarabel(s, 1e-10).solve() for s in sparse}
    print(f"{len(problems)} problems, N {problems[0].n}, {problems[0].points} points, {arguments.rounds} rounds")
    head = ("solver", "min", "median", "p99", "ours / it", "unsolved", "u_0 median", "u_0 99 %", "cost")
    print("{:<36}{:>9}{:>9}{:>9}{:>11}{:>10}{:>12}{:>10}{:>10}".format(*head))
    medians = {}
    for name, rows in results.items():
        times = np.array([min(row[0] for row in runs) for runs in rows.values()])
        unsolved = sum(not runs[-1][1] for runs in rows.values())
        known = [(runs[-1], exact[key]) for key, runs in rows.items() if runs[-1][1] and exact[key][1]]
        errors = [np.max(np.abs(run[2] - best[2])) for run, best in known]
        costs = [abs(run[3] - best[3]) / max(1.0, abs(best[3])) for run, best in known]
        medians[name] = np.median(times)
        print(
            f"{name:<36}{times.min():9.1f}{medians[name]:9.1f}{np.quantile(times, 0.99):9.1f}"
            f"{medians['lmpc'] / medians[name]:11.3f}{unsolved:10}"
            f"{np.median(errors):12.1e}{np.quantile(errors, 0.99):10.1e}{np.median(costs):10.1e}"
        )


if __name__ == "__main__":
    main()
