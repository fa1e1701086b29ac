//! Tables of a time-optimal lap.

use std::fmt::Write as _;

use optimum::Optimum;
use vehicle_model::{CarParams, Model, ModelKind, Track};

const TRAJECTORY: &str = "time_s,v_x_mps,v_y_mps,omega_z_radps,e_psi_rad,s_m,e_y_m,a_mps2,\
delta_rad,x_m,y_m,psi_rad";

/// The lap as CSV: state, inputs that act, and pose at every point of the mesh.
#[must_use]
pub fn trajectory(track: &Track, lap: &Optimum) -> String {
    let mut out = format!("{TRAJECTORY}\n");
    for point in &lap.points {
        let (x, u) = (&point.x, &point.u);
        let pose = track.to_global(x);
        let _ = writeln!(
            out,
            "{},{},{},{},{},{},{},{},{},{},{},{}",
            point.time,
            x.v_x,
            x.v_y,
            x.omega_z,
            x.e_psi,
            x.s,
            x.e_y,
            u.a,
            u.delta,
            pose.x,
            pose.y,
            pose.psi
        );
    }
    out
}

/// The lap as a raceline in the format of TUM's tools: along its own arc length, with the course
/// of the line (0 along +x), its curvature, speed and acceleration along it.
#[must_use]
pub fn raceline(car: &CarParams, track: &Track, lap: &Optimum) -> String {
    let model = Model::new(ModelKind::Dynamic, car.clone());
    let mut out = format!(
        "# {} on {}, lap time {:.6} s\n# s_m; x_m; y_m; psi_rad; kappa_radpm; vx_mps; ax_mps2\n",
        car.name,
        track.name(),
        lap.lap_time
    );
    let mut way = 0.0;
    let mut last: Option<(f64, f64)> = None;
    for point in &lap.points {
        let (x, u) = (&point.x, &point.u);
        let pose = track.to_global(x);
        if let Some((x_before, y_before)) = last {
            way += (pose.x - x_before).hypot(pose.y - y_before);
        }
        last = Some((pose.x, pose.y));
        // The point moves along v, whose direction turns with the yaw rate and the slip angle.
        let rates = model.derivative(x, u, track.kappa(x.s));
        let speed = x.v_x.hypot(x.v_y);
        let along = (x.v_x * rates[0] + x.v_y * rates[1]) / speed;
        let turn = x.omega_z + (x.v_x * rates[1] - x.v_y * rates[0]) / (speed * speed);
        let course = pose.psi + x.v_y.atan2(x.v_x);
        let _ = writeln!(
            out,
            "{way:.7}; {:.7}; {:.7}; {course:.7}; {:.7}; {speed:.7}; {along:.7}",
            pose.x,
            pose.y,
            turn / speed
        );
    }
    out
}
