//! The sections on what the controller predicts with, learns and solves.

use fhocp::{Backend, Solver, Termination};

use super::keys::{choice, section};

section! {
    /// Horizon and sampling.
    Horizon in horizon;
    /// Number of steps. Longer horizons learn faster and, from slow laps, less safely.
    steps "steps": usize, symbol "N", unit "", range (2, 200),
        from car_and_track "that of the preset at least, and as many periods as the car's time scale wheelbase / sqrt(mu g wheelbase) asks for";
    /// Sampling period.
    period "period_s": f64, symbol "dt", unit "s", range (1e-3, 1.0),
        from car_and_track "short enough to steer against the yaw instability of the car under braking at its top speed on the track, and to change its yaw rate there in one period by at most 4.5 times that of the sharpest bend";
    /// RK4 sub-steps of the nominal model in one period.
    substeps "substeps": usize, symbol "", unit "", range (1, 200),
        from car_and_track "as long as those of the preset";
}

choice! {
    /// Which laps the safe set takes.
    Selection;
    /// The P fastest laps (Rosolia); holds lap times better once the limit is reached.
    Fastest "fastest";
    /// The P most recent laps (the paper).
    Recent "recent";
}

choice! {
    /// What the cost-to-go of a safe-set point counts.
    CostToGo;
    /// The periods to the end of its lap (the paper).
    Line "line";
    /// The periods to the place of the plan's end one lap later, as driven: nothing changes at the line.
    Round "round";
}

section! {
    /// Safe set and cost-to-go (paper, eqs. for SS and Q).
    SafeSetConfig in safe_set;
    /// Samples taken from each lap. With the horizon it sets the learning rate.
    neighbors "neighbors": usize, symbol "K", unit "", range (2, 200), from preset;
    /// Laps taken.
    laps "laps": usize, symbol "P", unit "", range (1, 20), from preset;
    /// Which P laps.
    selection "selection": Selection, symbol "", unit "", range (), from preset;
    /// What the cost-to-go counts.
    cost_to_go "cost_to_go": CostToGo, symbol "J", unit "", range (), from preset;
}

choice! {
    /// What the regression learns.
    RegressionMode;
    /// The error of the nominal model, x_plus - f(x, u) (the paper's method).
    Error "error";
    /// The velocity rows themselves, x_plus, without a nominal model (Rosolia).
    Full "full";
    /// Nothing: the nominal model alone.
    Nominal "nominal";
}

choice! {
    /// Which inputs are features of which velocity row.
    Features;
    /// v_x from a; v_y and omega_z from delta (the paper).
    Own "own";
    /// Both inputs in all three rows.
    Both "both";
}

section! {
    /// Error dynamics regression: local weighted ridge regression of the velocity rows.
    RegressionConfig in regression;
    /// What is learned.
    mode "mode": RegressionMode, symbol "", unit "", range (), from preset;
    /// Nearest samples used for each point of the horizon.
    neighbors "neighbors": usize, symbol "M", unit "", range (1, 500), from preset;
    /// Most recent laps searched for neighbours; 0 searches all.
    laps "laps": usize, symbol "", unit "", range (0, 100000), from preset;
    /// Kernel bandwidth; compared with the squared metric distance u.
    bandwidth "bandwidth": f64, symbol "h", unit "", range (1e-9, 1e9), from preset;
    /// Ridge weight.
    ridge "ridge": f64, symbol "eps", unit "", range (1e-12, 1e6),
        from car_and_track "greater where actuators lag by more than half a period";
    /// Diagonal of Q, the metric on (v_x, v_y, omega_z, a, delta): u = (z - z_bar)' Q (z - z_bar).
    metric "metric": [f64; 5], symbol "Q", unit "", range (0.0, 1e9),
        from car "that of the preset in the car's scales of speed, yaw rate and acceleration";
    /// Input features of each row.
    features "features": Features, symbol "", unit "", range (), from preset;
}

choice! {
    /// Nominal vehicle model of the controller.
    NominalModel;
    /// Dynamic bicycle with the car's tyres.
    Dynamic "dynamic";
    /// Kinematic bicycle.
    Kinematic "kinematic";
}

section! {
    /// Nominal model.
    NominalConfig in nominal;
    /// Which equations.
    model "model": NominalModel, symbol "f", unit "", range (), from preset;
    /// Whether front and rear grip are fitted by least squares after each lap.
    adapt_grip "adapt_grip": bool, symbol "", unit "", range (),
        from car_and_track "off where actuators lag by more than half a period";
    /// Length of the secants that stand for tangents of the tyre curves near their peaks, as a
    /// share of the peak slip; 0: tangents.
    secant "secant": f64, symbol "", unit "", range (0.0, 0.4),
        from car_and_track "longer where actuators lag by more than half a period";
    /// Whether the first steering angle gives the front tyre the force that its linearisation promised.
    inverse_tyre "inverse_tyre": bool, symbol "", unit "", range (),
        from car_and_track "off where actuators lag by more than half a period";
}

section! {
    /// Initial laps by centre-line tracking.
    WarmUpConfig in warm_up;
    /// Number of initial laps.
    laps "laps": usize, symbol "", unit "", range (1, 1000), from preset;
    /// Their speed.
    speed "speed_mps": f64, symbol "", unit "m/s", range (0.1, 100.0),
        from car_and_track "a share of the mean speed that grip, drive and brakes allow on the track";
    /// Standard deviation of the noise on the acceleration: without excitation nothing can be
    /// regressed.
    noise_a "noise_a_mps2": f64, symbol "", unit "m/s^2", range (0.0, 10.0),
        from car "that of the preset in the car's scale of acceleration";
    /// Standard deviation of the noise on the steering angle.
    noise_delta "noise_delta_rad": f64, symbol "", unit "rad", range (0.0, 0.5),
        from car_and_track "a share of the steering lock, less where the track leaves little room beside the body";
    /// Seed of that noise.
    seed "seed": u64, symbol "", unit "", range (), from preset;
}

choice! {
    /// Which method solves the QP.
    SolverMethod;
    /// The structured interior-point method; with `fallback`, Clarabel takes what it misses.
    Structured "structured";
    /// Clarabel alone.
    Clarabel "clarabel";
}

section! {
    /// QP solver.
    SolverConfig in solver;
    /// Which method.
    method "method": SolverMethod, symbol "", unit "", range (), from preset;
    /// Whether Clarabel takes over, within the same step, what the structured method does not
    /// solve to tolerance. Without it such a step drives the shifted plan, sooner.
    fallback "fallback": bool, symbol "", unit "", range (), from preset;
    /// Tolerance of gap and feasibility.
    tolerance "tolerance": f64, symbol "", unit "", range (1e-12, 1e-2), from preset;
    /// Most iterations of one solve.
    max_iterations "max_iterations": u32, symbol "", unit "", range (5, 1000), from preset;
}

impl SolverConfig {
    /// When one of its solvers ends.
    #[must_use]
    pub fn termination(&self) -> Termination {
        Termination { tolerance: self.tolerance, max_iterations: self.max_iterations }
    }

    /// The solver it asks for.
    #[must_use]
    pub fn solver(&self) -> Solver {
        let first = match self.method {
            SolverMethod::Structured => Backend::Structured,
            SolverMethod::Clarabel => Backend::Clarabel,
        };
        Solver::new(first, self.fallback, self.termination())
    }
}
