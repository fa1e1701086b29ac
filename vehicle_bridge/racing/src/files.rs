//! The tables a race writes: names carry the unit, numbers are printed so that reading them
//! gives the same bits again.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::record::{LapRow, StepRow};
use super::words::{action_word, kind_word, reason_word, solver_word};
use hosting::timing::StepTime;

const LAPS: &str = "lap,kind,iteration,lap_time_s,valid,v_max_mps,v_mean_mps,e_y_max_m,\
alpha_f_max_rad,alpha_r_max_rad,steps,fallbacks,clipped,data_support_min,data_support_mean,\
model_error_median,model_error_mean,iterations_mean,iterations_max,grip_f,grip_r,\
overhang_max_m";

const TRAJECTORY: &str = "time_s,lap,v_x_mps,v_y_mps,omega_z_radps,e_psi_rad,s_m,e_y_m,a_mps2,\
delta_rad,x_m,y_m,psi_rad,alpha_f_rad,alpha_r_rad,tyre_use_f,tyre_use_r,action,reason,solve,\
solver,iterations,cost,lane_slack_m,front_slip_slack_rad,rear_slip_slack_rad,speed_slack_mps,\
terminal_slack,data_support_min,data_support_mean,model_error,clipped,\
overhang_m";

const TIMINGS: &str = "time_s,lap,project_us,linearize_us,regress_us,safe_set_us,solve_us,step_us";

/// Writes `laps.csv`.
///
/// # Errors
/// If the file cannot be written.
pub fn write_laps(path: &Path, laps: &[LapRow]) -> io::Result<()> {
    let mut out = create(path, LAPS)?;
    for lap in laps {
        let r = &lap.result;
        let iteration = lap.iteration.map(|i| i.to_string()).unwrap_or_default();
        writeln!(
            out,
            "{},{},{iteration},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
            r.lap,
            kind_word(r.kind),
            r.lap_time,
            r.valid,
            lap.v_max,
            lap.v_mean,
            lap.e_y_max,
            lap.alpha_f_max,
            lap.alpha_r_max,
            lap.steps,
            lap.fallbacks,
            lap.clipped,
            number(lap.support_min),
            number(lap.support_mean),
            number(lap.model_error_median),
            number(lap.model_error_mean),
            number(lap.iterations_mean),
            lap.iterations_max,
            lap.grip[0],
            lap.grip[1],
            lap.overhang_max,
        )?;
    }
    out.flush()
}

/// Writes `trajectory.csv`.
///
/// # Errors
/// If the file cannot be written.
pub fn write_trajectory(path: &Path, steps: &[StepRow]) -> io::Result<()> {
    let mut out = create(path, TRAJECTORY)?;
    for row in steps {
        let (x, s, status) = (&row.x, &row.pose, &row.status);
        write!(out, "{},{},", row.time, status.lap)?;
        write!(out, "{},{},{},{},{},{},", x.v_x, x.v_y, x.omega_z, x.e_psi, x.s, x.e_y)?;
        write!(out, "{},{},{},{},{},", row.u.a, row.u.delta, s.x, s.y, s.psi)?;
        write!(out, "{},{},{},{},", row.alpha_f, row.alpha_r, row.use_f, row.use_r)?;
        write!(out, "{},{},", action_word(status.action), reason_word(status.reason))?;
        write!(out, "{:?},{},", status.solve, solver_word(status.solver))?;
        write!(out, "{},{},", status.iterations, status.cost)?;
        write!(
            out,
            "{},{},{},{},{},",
            status.lane_slack,
            status.front_slip_slack,
            status.rear_slip_slack,
            status.speed_slack,
            status.terminal_slack
        )?;
        writeln!(
            out,
            "{},{},{},{},{}",
            status.data_support_min,
            status.data_support_mean,
            number(row.model_error.median),
            status.clipped,
            row.overhang
        )?;
    }
    out.flush()
}

/// Writes `timings.csv`: apart from the others because no two runs have the same times.
///
/// # Errors
/// If the file cannot be written.
pub fn write_timings(path: &Path, steps: &[StepRow], times: &[StepTime]) -> io::Result<()> {
    let mut out = create(path, TIMINGS)?;
    for (row, time) in steps.iter().zip(times) {
        write!(out, "{},{}", row.time, row.status.lap)?;
        for phase in time.phases {
            write!(out, ",{:.1}", phase * 1e6)?;
        }
        writeln!(out, ",{:.1}", time.total * 1e6)?;
    }
    out.flush()
}

fn create(path: &Path, header: &str) -> io::Result<BufWriter<File>> {
    let mut out = BufWriter::new(File::create(path)?);
    writeln!(out, "{header}")?;
    Ok(out)
}

/// A number, or nothing where there is none.
fn number(value: f64) -> String {
    if value.is_nan() { String::new() } else { value.to_string() }
}
