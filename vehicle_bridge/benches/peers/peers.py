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
import ctypes
import json
import os
import pathlib
import subprocess
import sys
import time

import numpy as np
import scipy.sparse as sp

TOLERANCE = 1e-8
IN_A_ROW = 5
MU0 = [1e-1, 1e0, 1e1, 1e2, 1e3]


class Problem:
    """One problem, its arrays as NumPy's; an absent bound is infinite."""

    def __init__(self, path):
        document = json.loads(path.read_text())
        if document["format"] != "lmpc-qp-1":
            sys.exit(f"{path}: the format is {document['format']}, not lmpc-qp-1")
        self.name = path.stem
        self.a = np.array([stage["a"] for stage in document["model"]])
        self.b = np.array([stage["b"] for stage in document["model"]])
        self.c = np.array([stage["c"] for stage in document["model"]])
        self.n, self.points = len(self.a), len(document["hull"])
        for key in ("front", "rear"):
            setattr(self, key, document[key])
        bounds = {"du_max", "speed_max", "front_max", "rear_max"}
        for key, value in document.items():
            if key in ("format", "model", "front", "rear"):
                continue
            if key in bounds:
                many = value if isinstance(value, list) else [value]
                value = [np.inf if v is None else v for v in many]
                value = value if isinstance(document[key], list) else value[0]
            setattr(self, key, np.array(value))
        self.b_now, self.b_before = self.b * (1.0 - self.lag), self.b * self.lag
        self.has_front, self.has_rear = int(np.isfinite(self.front_max)), int(np.isfinite(self.rear_max))
        self.has_speed = int(np.any(np.isfinite(self.speed_max)))

    def box(self, t):
        """Least and greatest inputs of a stage."""
        spared = self.reserve if t > 0 else np.zeros((2, 2))
        return self.u_min + spared[0], self.u_max - spared[1]


class Sparse:
    """min 1/2 z'Pz + q'z, Az = b, Gz <= h; stage by stage, so that block solvers see the stages."""

    def __init__(self, problem):
        self.problem = p = problem
        self.entries = {"P": [], "A": [], "G": []}
        self.q, self.right, self.limit, self.constant = {}, [], [], 0.0
        own = 3 + p.has_front + p.has_rear + p.has_speed
        self.stride = own + 6
        self.size = p.n * self.stride + p.points + 6
        self.x0, self.own = p.x_0, own
        for t in range(p.n):
            self._stage(t)
        hull, e = p.n * self.stride, p.n * self.stride + p.points
        for j in range(p.points):
            self._q(hull + j, p.hull_cost[j])
            self._row("G", [(hull + j, -1.0)], 0.0)
        for i in range(6):
            self._p(e + i, e + i, 2.0 * p.terminal_slack_weight[i])
            terms = [(hull + j, -p.hull[j, i]) for j in range(p.points)]
            self._row("A", [(self.x(p.n) + i, 1.0), (e + i, -1.0), *terms], 0.0)
        self._row("A", [(hull + j, 1.0) for j in range(p.points)], 1.0)

    def u(self, t):
        """Place of u_t."""
        return t * self.stride

    def x(self, t):
        """Place of x_t, t > 0."""
        return (t - 1) * self.stride + self.own

    def _p(self, i, j, value):
        self.entries["P"].append((i, j, value))
        if i != j:
            self.entries["P"].append((j, i, value))

    def _q(self, i, value):
        self.q[i] = self.q.get(i, 0.0) + value

    def _row(self, matrix, terms, right):
        rights = self.right if matrix == "A" else self.limit
        self.entries[matrix] += [(len(rights), i, value) for i, value in terms]
        rights.append(right)

    def _square(self, terms, constant, weight):
        """Adds weight (sum of terms + constant)^2."""
        for i, a in terms:
            self._q(i, 2.0 * weight * constant * a)
            self.entries["P"] += [(i, j, 2.0 * weight * a * b) for j, b in terms]
        self.constant += weight * constant**2

    def _velocities(self, t, gradient):
        """A linear function of x_t: its terms, and what is known of it."""
        if t == 0:
            return [], float(np.dot(gradient, self.x0[:3]))
        return [(self.x(t) + i, g) for i, g in enumerate(gradient)], 0.0

    def _soft(self, terms, known, low, high, slack, penalty):
        self._q(slack, penalty[0])
        if penalty[1]:
            self._p(slack, slack, 2.0 * penalty[1])
        if np.isfinite(high):
            self._row("G", [*terms, (slack, -1.0)], high - known)
        if np.isfinite(low):
            self._row("G", [*((i, -a) for i, a in terms), (slack, -1.0)], known - low)
        self._row("G", [(slack, -1.0)], 0.0)

    def _stage(self, t):
        p, u = self.problem, self.u(t)
        least, most = p.box(t)
        for i in range(2):
            self._row("G", [(u + i, 1.0)], most[i])
            self._row("G", [(u + i, -1.0)], -least[i])
            self._square([(u + i, 1.0)], 0.0, p.input_cost[i])
            known = -p.u_prev[i] if t == 0 else 0.0
            change = [(u + i, 1.0)] + ([(self.u(t - 1) + i, -1.0)] if t else [])
            self._square(change, known, p.rate_cost[i])
            if np.isfinite(p.du_max[i]):
                self._row("G", change, p.du_max[i] - known)
                self._row("G", [(k, -a) for k, a in change], p.du_max[i] + known)
        for i in range(6):
            terms = [(self.x(t + 1) + i, 1.0)] + [(u + j, -p.b_now[t, i, j]) for j in range(2)]
            right = p.c[t, i]
            if t == 0:
                right += p.a[0, i] @ p.x_0 + p.b_before[0, i] @ p.u_prev
            else:
                terms += [(self.x(t) + j, -p.a[t, i, j]) for j in range(6)]
                terms += [(self.u(t - 1) + j, -p.b_before[t, i, j]) for j in range(2) if p.lag]
            self._row("A", terms, right)
        slack, after = u + 2, self.x(t + 1)
        lane = (p.lane_linear, p.lane_quadratic)
        self._soft([(after + 5, 1.0)], 0.0, p.e_y_min[t], p.e_y_max[t], slack, lane)
        front, rear = p.front[t], p.rear[t]
        terms, known = self._velocities(t, front["velocity"])
        terms, known = [*terms, (u + 1, front["steering"])], known + front["offset"]
        self._square(terms, known - front["reference"], front["weight"])
        if p.has_front:
            slack += 1
            self._soft(terms, known, -p.front_max, p.front_max, slack, (p.slip_linear, 0.0))
        terms, _ = self._velocities(t + 1, rear["velocity"])
        self._square(terms, rear["offset"] - rear["reference"], rear["weight"])
        if p.has_rear:
            slack += 1
            most = p.rear_max * p.rear_share[t]
            self._soft(terms, rear["offset"], -most, most, slack, (p.slip_linear, 0.0))
        if p.has_speed:
            slack += 1
            speed = (p.speed_linear, 0.0)
            self._soft([(after, 1.0)], 0.0, -np.inf, p.speed_max[t], slack, speed)

    def matrix(self, name, rows):
        """A matrix in compressed columns."""
        i, j, value = zip(*self.entries[name])
        return sp.csc_matrix((value, (i, j)), shape=(rows, self.size))

    def arrays(self):
        """P, q, A, b, G, h."""
        q = np.zeros(self.size)
        for i, value in self.q.items():
            q[i] = value
        right, limit = np.array(self.right), np.array(self.limit)
        matrices = (self.matrix("P", self.size), self.matrix("A", len(right)), self.matrix("G", len(limit)))
        return matrices[0], q, matrices[1], right, matrices[2], limit

    def result(self, z):
        """First input and cost of a solution."""
        matrix, q, *_ = self.arrays()
        z = np.asarray(z)
        return z[:2].copy(), 0.5 * z @ (matrix @ z) + q @ z + self.constant


class Clarabel:
    """Clarabel as a reference."""

    def __init__(self, sparse, tolerance):
        import clarabel

        matrix, q, a, right, g, limit = sparse.arrays()
        settings = clarabel.DefaultSettings()
        settings.verbose, settings.presolve_enable = False, False
        settings.max_iter, settings.direct_solve_method = 200, "qdldl"
        settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = tolerance
        cones = [clarabel.ZeroConeT(len(right)), clarabel.NonnegativeConeT(len(limit))]
        rows, rights = sp.vstack([a, g]).tocsc(), np.concatenate([right, limit])
        self.sparse = sparse
        self.solver = clarabel.DefaultSolver(sp.triu(matrix).tocsc(), q, rows, rights, cones, settings)

    def solve(self):
        """Time [us], whether it is solved, first input and cost."""
        solution = self.solver.solve()
        solved = str(solution.status) in ("Solved", "AlmostSolved")
        return 1e6 * solution.solve_time, solved, *self.sparse.result(solution.x)


class Piqp:
    """PIQP's backend for problems in stages."""

    def __init__(self, sparse):
        import piqp

        matrix, q, a, right, g, limit = sparse.arrays()
        self.sparse, self.solver = sparse, piqp.SparseSolver()
        settings = self.solver.settings
        settings.kkt_solver = piqp.KKTSolver.sparse_multistage
        settings.eps_abs, settings.eps_rel, settings.compute_timings = TOLERANCE, TOLERANCE, True
        self.solver.setup(matrix, q, a, right, g, np.full(len(limit), -np.inf), limit)
        self.solved = piqp.PIQP_SOLVED

    def solve(self):
        """Time [us], whether it is solved, first input and cost."""
        status = self.solver.solve()
        result = self.solver.result
        return 1e6 * result.info.solve_time, status == self.solved, *self.sparse.result(result.x)


class Hpipm:
    """HPIPM's interior-point method for optimal control problems."""

    def __init__(self, problem, mode, mu0, classical):
        import hpipm_python as hp

        self.p = p = problem
        self.held = bool(p.lag) or np.any(p.rate_cost) or np.any(np.isfinite(p.du_max))
        nx = 8 if self.held else 6
        n, weights = p.n, p.points - 1
        dim = hp.hpipm_ocp_qp_dim(n)
        self.limited = [i for i in range(2) if np.isfinite(p.du_max[i])]
        ng = [p.has_front * (t < n) + p.has_rear * (t > 0) + len(self.limited) * (t < n) for t in range(n + 1)]
        ng[n] += weights > 0
        nbx = [0 if t == 0 else 1 + p.has_speed for t in range(n + 1)]
        soft = [nbx[t] + p.has_front * (t < n) + p.has_rear * (t > 0) for t in range(n + 1)]
        for t in range(n + 1):
            last = t == n
            dim.set("nx", 0 if t == 0 else nx, t)
            dim.set("nu", weights if last else 2, t)
            dim.set("nbu", weights if last else 2, t)
            for name, sizes in (("nbx", nbx), ("ng", ng), ("ns", soft)):
                dim.set(name, int(sizes[t]), t)
        self.qp, self.solution = hp.hpipm_ocp_qp(dim), hp.hpipm_ocp_qp_sol(dim)
        for t in range(n + 1):
            self._stage(t, nx, int(ng[t]), nbx[t], int(soft[t]))
        arg = hp.hpipm_ocp_qp_solver_arg(dim, mode)
        arg.set("mu0", mu0)
        arg.set("iter_max", 100)
        for name in ("tol_stat", "tol_eq", "tol_ineq", "tol_comp"):
            arg.set(name, TOLERANCE)
        library = ctypes.CDLL("libhpipm.so")
        if classical:
            library.d_ocp_qp_ipm_arg_set(b"ric_alg", ctypes.byref(ctypes.c_int(0)), arg.arg_struct)
        self.solver = hp.hpipm_ocp_qp_solver(dim, arg)

    def _set(self, name, value, t):
        value = np.atleast_2d(np.asarray(value, dtype=float))
        self.qp.set(name, value.T if value.shape[0] == 1 and name.islower() else value, t)

    def _cost(self, t, nx):
        """Hessian [[R, S], [S', Q]] and gradient of a stage with inputs first."""
        p, n = self.p, self.p.n
        nu, states = (p.points - 1, nx) if t == n else (2, nx)
        hessian, gradient = np.zeros((nu + states, nu + states)), np.zeros(nu + states)

        def square(row, constant, weight):
            nonlocal hessian, gradient
            hessian = hessian + 2.0 * weight * np.outer(row, row)
            gradient = gradient + 2.0 * weight * constant * row

        def unit(*places):
            row = np.zeros(nu + states)
            for place, value in places:
                row[place] = value
            return row

        if t < n:
            for i in range(2):
                square(unit((i, 1.0)), 0.0, p.input_cost[i])
                if self.held:
                    square(unit((i, 1.0), (nu + 6 + i, -1.0)), 0.0, p.rate_cost[i])
            front = p.front[t]
            row = self._slip(front, nu, states)
            square(row, front["offset"] - front["reference"], front["weight"])
        if t > 0:
            rear = p.rear[t - 1]
            row = self._slip({**rear, "steering": 0.0}, nu, states)
            square(row, rear["offset"] - rear["reference"], rear["weight"])
        if t == n:
            # x_N - x_K - sum (x_j - x_K) lambda_j
            around, last = (p.hull[:-1] - p.hull[-1]), p.hull[-1]
            for i in range(6):
                row = np.zeros(nu + states)
                row[:nu], row[nu + i] = -around[:, i], 1.0
                square(row, -last[i], p.terminal_slack_weight[i])
            gradient[:nu] += p.hull_cost[:-1] - p.hull_cost[-1]
        return hessian, gradient, nu

    def _slip(self, slip, nu, states):
        row = np.zeros(nu + states)
        row[nu : nu + 3] = slip["velocity"]
        if nu == 2:
            row[1] += slip["steering"]
        return row

    def _stage(self, t, nx, ng, nbx, soft):
        p, n = self.p, self.p.n
        start = np.concatenate([p.x_0, p.u_prev])[:nx]
        hessian, gradient, nu = self._cost(t, nx)
        if t == 0:
            gradient = gradient + hessian[:, nu:] @ start
        self._set("R", hessian[:nu, :nu], t)
        self.qp.set("r", gradient[:nu].reshape(-1, 1).copy(), t)
        if t > 0:
            self._set("Q", hessian[nu:, nu:], t)
            self._set("S", hessian[:nu, nu:], t)
            self.qp.set("q", gradient[nu:].reshape(-1, 1).copy(), t)
        if t < n:
            a, b, c = np.zeros((nx, nx)), np.zeros((nx, 2)), np.zeros(nx)
            a[:6, :6], b[:6], c[:6] = p.a[t], p.b_now[t], p.c[t]
            if self.held:
                a[:6, 6:], b[6:] = p.b_before[t], np.eye(2)
            if t == 0:
                c = c + a @ start
            else:
                self._set("A", a, t)
            self._set("B", b, t)
            self.qp.set("b", c.reshape(-1, 1).copy(), t)
        self._bounds(t, nx, nu, nbx)
        self._general(t, nx, nu, ng, start)
        if soft:
            self._softened(t, nbx, ng, soft)

    def _bounds(self, t, nx, nu, nbx):
        p, n = self.p, self.p.n
        least, most = p.box(t) if t < n else (np.zeros(nu), np.ones(nu))
        self.qp.set("Jbu", np.eye(nu), t)
        self.qp.set("lbu", least.reshape(-1, 1).astype(float), t)
        self.qp.set("ubu", most.reshape(-1, 1).astype(float), t)
        if t == n:
            # lambda_j <= 1 follows from the sum.
            self.qp.set("ubu_mask", np.zeros((nu, 1)), t)
        if nbx:
            chosen = np.zeros((nbx, nx))
            chosen[0, 5] = 1.0
            low, high = np.array([p.e_y_min[t - 1], -1e6]), np.array([p.e_y_max[t - 1], p.speed_max[t - 1]])
            if nbx == 2:
                chosen[1, 0] = 1.0
            self.qp.set("Jbx", chosen, t)
            high = np.where(np.isfinite(high), high, 1e6)
            self.qp.set("lbx", low[:nbx].reshape(-1, 1).copy(), t)
            self.qp.set("ubx", high[:nbx].reshape(-1, 1).copy(), t)
            if nbx == 2:
                self.qp.set("lbx_mask", np.array([[1.0], [0.0]]), t)

    def _general(self, t, nx, nu, ng, start):
        """Slip angles, rates, and the sum of the weights."""
        p, n = self.p, self.p.n
        rows, low, high = [], [], []
        if p.has_front and t < n:
            front = p.front[t]
            rows.append(self._slip(front, nu, nx))
            low.append(-p.front_max - front["offset"])
            high.append(p.front_max - front["offset"])
        if p.has_rear and t > 0:
            rear, most = p.rear[t - 1], p.rear_max * p.rear_share[t - 1]
            rows.append(self._slip({**rear, "steering": 0.0}, nu, nx))
            low.append(-most - rear["offset"])
            high.append(most - rear["offset"])
        if t < n:
            for i in self.limited:
                row = np.zeros(nu + nx)
                row[i], row[nu + 6 + i] = 1.0, -1.0
                rows.append(row)
                low.append(-p.du_max[i])
                high.append(p.du_max[i])
        elif nu:
            row = np.zeros(nu + nx)
            row[:nu] = 1.0
            rows.append(row)
            low.append(-1e6)
            high.append(1.0)
        if not ng:
            return
        rows, low, high = np.array(rows), np.array(low), np.array(high)
        if t == 0:
            known = rows[:, nu:] @ start
            low, high = low - known, high - known
        else:
            self._set("C", rows[:, nu:], t)
        self._set("D", rows[:, :nu], t)
        self.qp.set("lg", low.reshape(-1, 1).copy(), t)
        self.qp.set("ug", high.reshape(-1, 1).copy(), t)
        if t == n:
            mask = np.ones((ng, 1))
            mask[-1] = 0.0
            self.qp.set("lg_mask", mask, t)

    def _softened(self, t, nbx, ng, soft):
        """One slack for each softened row, states first."""
        p = self.p
        of_states = np.zeros((max(nbx, 1), soft))
        of_rows = np.zeros((max(ng, 1), soft))
        for i in range(nbx):
            of_states[i, i] = 1.0
        for i in range(soft - nbx):
            of_rows[i, nbx + i] = 1.0
        if nbx:
            self.qp.set("Jsbx", of_states, t)
        if ng:
            self.qp.set("Jsg", of_rows, t)
        linear = [p.lane_linear, p.speed_linear][:nbx] + [p.slip_linear] * (soft - nbx)
        quadratic = [2.0 * p.lane_quadratic, 0.0][:nbx] + [0.0] * (soft - nbx)
        for side in "lu":
            self.qp.set(f"Z{side}", np.array(quadratic, dtype=float).reshape(-1, 1), t)
            self.qp.set(f"z{side}", np.array(linear, dtype=float).reshape(-1, 1), t)
            self.qp.set(f"l{side}s", np.zeros((soft, 1)), t)

    def solve(self):
        """Time [us], whether it is solved, first input; the cost is not compared."""
        begun = time.perf_counter()
        self.solver.solve(self.qp, self.solution)
        elapsed = time.perf_counter() - begun
        u_0 = np.ravel(self.solution.get("u", 0))[:2].copy()
        return 1e6 * elapsed, self.solver.get("status") == 0 and np.all(np.isfinite(u_0)), u_0, np.nan


def find_hpipm():
    """Whether HPIPM can be loaded."""
    if os.environ.get("HPIPM_PYTHON"):
        sys.path.insert(0, os.environ["HPIPM_PYTHON"])
    with contextlib.suppress(ImportError, OSError):
        import hpipm_python  # noqa: F401

        ctypes.CDLL("libhpipm.so")
        return True
    return False


def tuned(problems, mode, classical):
    """The mu0 with which HPIPM's median is least, of those that leave fewest problems unsolved."""

    def tried(mu0):
        results = [Hpipm(problem, mode, mu0, classical).solve() for problem in problems[::5]]
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
        solvers["PIQP sparse_multistage"] = [Piqp(s) for s in sparse]
    if find_hpipm():
        for mode, classical in (("speed_abs", False), ("speed", True), ("balance", True)):
            mu0 = tuned(problems, mode, classical)
            name = f"HPIPM {mode}, mu0 {mu0:g}" + (", classical" if classical else "")
            solvers[name] = [Hpipm(p, mode, mu0, classical) for p in problems]
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
        print(f"{name:<36}{times.min():9.1f}{medians[name]:9.1f}{np.quantile(times, 0.99):9.1f}"
              f"{medians['lmpc'] / medians[name]:11.3f}{unsolved:10}"
              f"{np.median(errors):12.1e}{np.quantile(errors, 0.99):10.1e}{np.median(costs):10.1e}")


if __name__ == "__main__":
    main()
