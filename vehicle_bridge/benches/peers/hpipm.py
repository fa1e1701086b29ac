"""A problem for HPIPM, through its Python package."""

import contextlib
import ctypes
import os
import sys
import time

import numpy as np


class Hpipm:
    """HPIPM's interior-point method for optimal control problems."""

    def __init__(self, problem, tolerance, mode, mu0, classical):
        import hpipm_python as hp

        self.p = p = problem
        self.held = bool(p.lag) or np.any(p.rate_cost) or np.any(np.isfinite(p.du_max))
        nx = 8 if self.held else 6
        n, weights = p.n, p.points - 1
        dim = hp.hpipm_ocp_qp_dim(n)
        self.limited = [i for i in range(2) if np.isfinite(p.du_max[i])]
        soft_rows = [p.has_front * (t < n) + (p.has_rear + 1) * (t > 0) for t in range(n + 1)]
        ng = [soft_rows[t] + len(self.limited) * (t < n) for t in range(n + 1)]
        ng[n] += weights > 0
        nbx = [p.has_speed * (t > 0) for t in range(n + 1)]
        soft = [nbx[t] + soft_rows[t] for t in range(n + 1)]
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
            arg.set(name, tolerance)
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
            front, most = p.front[t], p.front_max * p.front_share[t]
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
            chosen[0, 0] = 1.0
            self.qp.set("Jbx", chosen, t)
            self.qp.set("lbx", np.array([[-1e6]]), t)
            self.qp.set("ubx", np.array([[min(p.speed_max[t - 1], 1e6)]]), t)
            self.qp.set("lbx_mask", np.array([[0.0]]), t)

    def _general(self, t, nx, nu, ng, start):
        """Lane, slip angles, rates, and the sum of the weights."""
        p, n = self.p, self.p.n
        rows, low, high = [], [], []
        if t > 0:
            row = np.zeros(nu + nx)
            row[nu + 5], row[nu + 3] = 1.0, p.lane_heading[t - 1]
            rows.append(row)
            low.append(p.e_y_min[t - 1])
            high.append(p.e_y_max[t - 1])
        if p.has_front and t < n:
            front, most = p.front[t], p.front_max * p.front_share[t]
            rows.append(self._slip(front, nu, nx))
            low.append(-most - front["offset"])
            high.append(most - front["offset"])
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
        lane = int(t > 0)
        slips = soft - nbx - lane
        linear = [p.speed_linear] * nbx + [p.lane_linear] * lane + [p.slip_linear] * slips
        quadratic = [0.0] * nbx + [2.0 * p.lane_quadratic] * lane + [0.0] * slips
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
