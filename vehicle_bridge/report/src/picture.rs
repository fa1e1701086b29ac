//! A time-optimal lap as a page: line, speed, inputs, slip.

use optimum::{LapPoint, Optimum};
use vehicle_model::{CarParams, SlipAngles, Track};

use crate::map::speed_map;
use svg_page::{Chart, Mark, ReferenceLine, Series, card};

/// The page as HTML.
#[must_use]
pub fn page(car: &CarParams, track: &Track, margin: f64, lap: &Optimum) -> String {
    let lead = format!(
        "Time-optimal lap, {:.3} s, {margin} m from the edges. Driven by the simulated car it \
         deviates by {:.1e} (scaled) over {} intervals; {} of {} starts converged.",
        lap.lap_time,
        lap.quality.scaled_defect,
        lap.quality.intervals,
        lap.quality.converged,
        lap.quality.starts
    );
    let line: Vec<(f64, f64, f64)> = lap
        .points
        .iter()
        .map(|point| {
            let pose = track.to_global(&point.x);
            (pose.x, pose.y, point.x.v_x)
        })
        .collect();
    let title = format!("time-optimal lap, {:.3} s", lap.lap_time);
    let mut body = card("Line", "Colour is speed.", &speed_map(track, &line, &title));
    let along = |label: &str, value: &dyn Fn(&LapPoint) -> f64, limits: &[(f64, &str)]| {
        let mut chart = Chart::new("s [m]", label);
        chart.x_range = Some((0.0, track.length()));
        let points = lap.points.iter().map(|point| (point.x.s, value(point))).collect();
        chart.series.push(Series::new("time-optimal lap", "s0", Mark::Line, points));
        for (y, label) in limits {
            chart.references.push(ReferenceLine { y: *y, label: (*label).to_owned() });
        }
        chart.html()
    };
    body.push_str("<div class=\"columns\">\n");
    let mut speed = along("v_x [m/s]", &|p| p.x.v_x, &[]);
    speed.push_str(&along("e_y [m]", &|p| p.x.e_y, &[]));
    body.push_str(&card("Speed and line over the lap", "", &speed));
    let stops = [(car.a_min, "least"), (car.a_max, "most")];
    let mut inputs = along("a [m/s²]", &|p| p.u.a, &stops);
    inputs.push_str(&along("delta [rad]", &|p| p.u.delta, &[]));
    body.push_str(&card("Inputs over the lap", "Positions of the actuators.", &inputs));
    let slip = |p: &LapPoint| SlipAngles::new(&p.x, &p.u, car);
    let peak = |slip: f64| if slip.is_finite() { vec![(slip, "peak of the tyre")] } else { vec![] };
    let mut tyres =
        along("|alpha_f| [rad]", &|p| slip(p).front.abs(), &peak(car.tyre_front.peak_slip()));
    tyres.push_str(&along(
        "|alpha_r| [rad]",
        &|p| slip(p).rear.abs(),
        &peak(car.tyre_rear.peak_slip()),
    ));
    body.push_str(&card("Slip angles over the lap", "", &tyres));
    body.push_str("</div>\n");
    svg_page::page(&format!("{} on {}", car.name, track.name()), &lead, &body, "")
}
