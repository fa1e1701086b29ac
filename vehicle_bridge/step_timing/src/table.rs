//! What was measured, for people.

use std::fmt::Write as _;

use super::CaseTimes;

/// The tables of one case.
#[must_use]
pub fn text(case: &CaseTimes) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_case(case, &mut out);
    out
}

fn write_case(case: &CaseTimes, out: &mut String) -> std::fmt::Result {
    let CaseTimes { name, horizon, points, track, initial, .. } = case;
    writeln!(
        out,
        "{name}, track {track}, N {horizon}, {points} points; of the laps stored at most {initial} are \
         initial ones"
    )?;
    write!(out, "  {:<16}", "us: median, p99")?;
    for step in &case.steps {
        write!(out, "{:>20}", format!("{} laps", step.laps))?;
    }
    writeln!(out, "{:>9}", "growth")?;
    let Some(first) = case.steps.first() else { return Ok(()) };
    for (i, phase) in first.phases.iter().enumerate() {
        write!(out, "  {:<16}", phase.name)?;
        for step in &case.steps {
            let times = step.phases[i].times;
            write!(out, "{:>11.1}{:>9.1}", times.median_us, times.p99_us)?;
        }
        let most = case.steps.last().map_or(f64::NAN, |step| step.phases[i].times.median_us);
        writeln!(out, "{:>8.2}x", most / phase.times.median_us)?;
    }
    let left_out: Vec<String> =
        case.steps.iter().map(|step| format!("{} of {}", step.preempted, step.steps)).collect();
    writeln!(
        out,
        "  feedback part {:.2} of the whole step, whole step {:.2} of one with tuned Clarabel; left \
         out as preempted: {}",
        case.feedback_share,
        case.step_to_clarabel,
        left_out.join(", ")
    )?;
    writeln!(
        out,
        "  {:<26}{:>9}{:>9}{:>9}{:>13}",
        "QP alone", "min", "median", "p99", "structured /"
    )?;
    for qp in &case.qp {
        let times = qp.times;
        writeln!(
            out,
            "  {:<26}{:>9.1}{:>9.1}{:>9.1}{:>13.3}   unsolved {}",
            qp.solver,
            times.min_us,
            times.median_us,
            times.p99_us,
            qp.structured_to_this,
            qp.unsolved
        )?;
    }
    if let Some(structured) = case.qp.first() {
        let tail = structured.times.p99_us / structured.times.median_us;
        writeln!(out, "  structured p99 / median {tail:.2}")?;
    }
    Ok(())
}
