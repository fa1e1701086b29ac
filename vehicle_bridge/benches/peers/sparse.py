"""A problem as a sparse quadratic program, and the solvers of such."""

import numpy as np
import scipy.sparse as sp


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
        self._soft([(after + 5, 1.0), (after + 3, p.lane_heading[t])], 0.0, p.e_y_min[t], p.e_y_max[t], slack, lane)
        front, rear = p.front[t], p.rear[t]
        terms, known = self._velocities(t, front["velocity"])
        terms, known = [*terms, (u + 1, front["steering"])], known + front["offset"]
        self._square(terms, known - front["reference"], front["weight"])
        if p.has_front:
            slack += 1
            most = p.front_max * p.front_share[t]
            self._soft(terms, known, -most, most, slack, (p.slip_linear, 0.0))
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

    def __init__(self, sparse, tolerance):
        import piqp

        matrix, q, a, right, g, limit = sparse.arrays()
        self.sparse, self.solver = sparse, piqp.SparseSolver()
        settings = self.solver.settings
        settings.kkt_solver = piqp.KKTSolver.sparse_multistage
        settings.eps_abs, settings.eps_rel, settings.compute_timings = tolerance, tolerance, True
        self.solver.setup(matrix, q, a, right, g, np.full(len(limit), -np.inf), limit)
        self.solved = piqp.PIQP_SOLVED

    def solve(self):
        """Time [us], whether it is solved, first input and cost."""
        status = self.solver.solve()
        result = self.solver.result
        return 1e6 * result.info.solve_time, status == self.solved, *self.sparse.result(result.x)
