//! The sections on how the car drives: costs, speed envelope, limits.

use super::keys::section;

section! {
    /// Weights of the optimal control problem.
    CostConfig in cost;
    /// Weight of the squared steering angle, in steps.
    input "input": f64, symbol "c_u", unit "1/rad^2", range (0.0, 1e6),
        from car_and_track "that of the preset in the car's scale of time";
    /// Weight of the squared acceleration, in steps.
    input_acceleration "input_acceleration": f64, symbol "c_u", unit "s^4/m^2", range (0.0, 1e6),
        from car_and_track "that of the preset in the car's scales of time and acceleration";
    /// Weight ("CRC") of the squared rates of the input per second.
    control_rate "control_rate": f64, symbol "c_du", unit "", range (0.0, 1e6), from preset;
    /// Factor of the acceleration rate within `control_rate`.
    acceleration_rate "acceleration_rate": f64, symbol "w_a", unit "", range (0.0, 1e6),
        from car_and_track "that of the preset in the car's scales of time, acceleration and grip";
    /// Factor of the steering rate within `control_rate`.
    steering_rate "steering_rate": f64, symbol "w_delta", unit "", range (0.0, 1e6),
        from car_and_track "that of the preset in the car's scale of time";
    /// Least product of `control_rate` and `steering_rate`: below it the car weaves.
    steering_rate_floor "steering_rate_floor": f64, symbol "", unit "", range (0.0, 1e6),
        from car_and_track "that of the preset in the car's scale of time";
    /// Gentle start: factor of the acceleration rate in the first learned lap; each later lap has 0.35 of
    /// the factor before, down to `acceleration_rate`. 0 switches it off.
    gentle_start "gentle_start": f64, symbol "", unit "", range (0.0, 1e6),
        from car_and_track "that of the preset in the car's scales of time and acceleration";
    /// Factor of the curvature of tyre dissipation; 1 is that of the equations, 0 switches it off.
    dissipation "dissipation": f64, symbol "", unit "", range (0.0, 1e3), from preset;
    /// Quadratic weights of the terminal slack in state order.
    terminal_slack "terminal_slack": [f64; 6], symbol "E", unit "", range (1e-9, 1e9),
        from car_and_track "that of the preset in the car's scales of length, speed and time";
    /// Linear weight of the lane slack of each stage.
    lane_linear "lane_linear": f64, symbol "", unit "1/m", range (0.0, 1e9),
        from car_and_track "that of the preset in the car's scales of length and time";
    /// Quadratic weight of the lane slack of each stage.
    lane_quadratic "lane_quadratic": f64, symbol "", unit "1/m^2", range (1e-9, 1e9),
        from car_and_track "that of the preset in the car's scales of length and time";
    /// Linear weight of the slip-guard slacks.
    slip "slip": f64, symbol "", unit "1/rad", range (0.0, 1e9),
        from car_and_track "that of the preset in the car's scale of time, ten times as much where the actuators lag";
    /// Linear weight of the speed-cap slack.
    speed "speed": f64, symbol "", unit "s/m", range (0.0, 1e9),
        from car_and_track "that of the preset in the car's scales of speed and time";
}

section! {
    /// Speed envelope: how fast a plan may be at each place of the track.
    EnvelopeConfig in envelope;
    /// Whether there is one.
    active "active": bool, symbol "", unit "", range (), from preset;
    /// Share of the known grip up to which speed may grow in one lap.
    grip_share "grip_share": f64, symbol "", unit "", range (1e-3, 2.0), from preset;
    /// Growth from lap to lap that is allowed even where the grip is used up, as a share of the driven speed;
    /// less in fast bends of narrow tracks.
    growth_least "growth_least": f64, symbol "", unit "", range (0.0, 1.0),
        from car_and_track "less where actuators lag by more than half a period";
    /// Greatest growth from lap to lap, as a share of the driven speed; at least `growth_least`.
    growth_most "growth_most": f64, symbol "", unit "", range (0.0, 10.0), from preset;
    /// Share of the brakes that slowing down for what comes may use.
    brake_share "brake_share": f64, symbol "", unit "", range (1e-2, 1.0), from preset;
}

section! {
    /// Constraints beside the input box, which belongs to the car.
    LimitsConfig in limits;
    /// Distance the centre of gravity of a car parallel to the track keeps from either edge.
    lane_margin "lane_margin_m": f64, symbol "", unit "m", range (0.0, 100.0),
        from car_and_track "half the car's width, a share of its width, and what a small error of heading leads astray at top speed until a correction acts";
    /// Whether the outline of the body keeps what `lane_margin_m` leaves beside half its width.
    body "body": bool, symbol "", unit "", range (), from preset;
    /// Guard on the front slip angle |alpha_f|; 0 switches it off.
    front_slip "front_slip_rad": f64, symbol "", unit "rad", range (0.0, 1.5),
        from car "a share of the front tyre's peak slip";
    /// Guard on the rear slip angle |alpha_r|; 0 switches it off.
    rear_slip "rear_slip_rad": f64, symbol "", unit "rad", range (0.0, 1.5),
        from car "a share of the rear tyre's peak slip";
    /// Share of the steering lock that plans leave free after their first stage: what a car that steers
    /// to its lock in a tight bend has left to correct its line with.
    steering_reserve "steering_reserve": f64, symbol "", unit "", range (0.0, 0.5), from preset;
    /// Share of the brakes that plans leave free after their first stage.
    brake_reserve "brake_reserve": f64, symbol "", unit "", range (0.0, 0.5), from preset;
    /// Share of the slip guards that plans leave free beyond the first third of the horizon, and less of
    /// it before: what a car that runs wide has left to correct its line with.
    slip_reserve "slip_reserve": f64, symbol "", unit "", range (0.0, 0.5), from preset;
    /// Whether a braking car has only that share of the rear guard that is left of the rear load.
    rear_load "rear_load": bool, symbol "", unit "", range (), from preset;
    /// Standard deviations of the error of predictions over one period that lane and slip guards keep free;
    /// where measurements are noisy, lane and front guard keep those of the estimated state. Unless it is 0,
    /// the first learned laps keep more free beside the body.
    uncertainty "uncertainty": f64, symbol "", unit "", range (0.0, 10.0), from preset;
    /// Speed cap; 0 switches it off.
    speed_cap "speed_cap_mps": f64, symbol "", unit "m/s", range (0.0, 1000.0), from preset;
}
