//! The time-optimal lap against other ways to the same numbers.

#![allow(clippy::unwrap_used, reason = "a test that has no lap has failed")]

use std::sync::Arc;

use optimum::{Error, Optimum, Options, solve};
use vehicle_model::{CarParams, Segment, Track};

fn car(name: &str) -> CarParams {
    CarParams::builtin(name).unwrap()
}

fn l() -> Arc<Track> {
    Arc::new(Track::builtin("l").unwrap())
}

fn on_l(name: &str) -> Optimum {
    solve(&car(name), &l(), &Options::new(0.1)).unwrap()
}

/// An independent solver (direct collocation of the same equations with another discretisation
/// and another optimiser) found 3.823 to 3.831 s, each a local optimum.
#[test]
fn the_small_car_on_the_l_track() {
    let lap = on_l("barc");
    assert!((3.79..=3.835).contains(&lap.lap_time), "{}", lap.lap_time);
    assert!(lap.quality.scaled_defect < 1e-4, "{:?}", lap.quality);
    assert_eq!(lap.quality.converged, lap.quality.starts);
    let (first, last) = (lap.points.first().unwrap(), lap.points.last().unwrap());
    assert_eq!((first.time, first.x.s), (0.0, 0.0));
    assert_eq!((last.time, last.x.s), (lap.lap_time, l().length()));
    assert_eq!((last.x.v_x, last.x.e_y, last.u), (first.x.v_x, first.x.e_y, first.u));
    for pair in lap.points.windows(2) {
        assert!(pair[0].x.s < pair[1].x.s && pair[0].time < pair[1].time);
    }
    for point in &lap.points {
        assert!(point.x.e_y.abs() < 0.45 + 1e-6, "{point:?}");
        assert!(point.u.a.abs() < 2.0 + 1e-6 && point.u.delta.abs() < 0.436 + 1e-6, "{point:?}");
    }
    // The speeds along the line give the lap time once more, by the trapezoidal rule.
    let track = l();
    let pace = |p: &optimum::LapPoint, s: f64| {
        let forward = p.x.v_x * p.x.e_psi.cos() - p.x.v_y * p.x.e_psi.sin();
        (1.0 - track.kappa(s) * p.x.e_y) / forward
    };
    let time: f64 = lap
        .points
        .windows(2)
        .map(|p| {
            let (begin, end) = (p[0].x.s, p[1].x.s);
            0.5 * (end - begin) * (pace(&p[0], begin + 1e-9) + pace(&p[1], end - 1e-9))
        })
        .sum();
    assert!((time / lap.lap_time - 1.0).abs() < 2e-3, "{time} {}", lap.lap_time);
}

/// The independent solver found 3.974 s.
#[test]
fn the_smallest_car_on_the_l_track() {
    let lap = on_l("mini");
    assert!((lap.lap_time / 3.974 - 1.0).abs() < 5e-3, "{}", lap.lap_time);
    assert!(lap.quality.scaled_defect < 1e-4, "{:?}", lap.quality);
}

/// Steering at a limited rate: no actuator moves faster, and the plant, which has the limit too,
/// follows.
#[test]
fn actuators_keep_their_rates() {
    let slow = CarParams { delta_rate_max: Some(1.2), actuator_lag: 0.03, ..car("barc") };
    let lap = solve(&slow, &l(), &Options::new(0.1)).unwrap();
    let free = on_l("barc").lap_time;
    assert!(lap.lap_time > free + 0.002, "{} {free}", lap.lap_time);
    assert!(lap.quality.scaled_defect < 1e-4, "{:?}", lap.quality);
    for pair in lap.points.windows(2) {
        let dt = pair[1].time - pair[0].time;
        let rate = (pair[1].u.delta - pair[0].u.delta) / dt;
        assert!(rate.abs() < 1.2 * (1.0 + 1e-3), "{rate} {pair:?}");
        // What commands the lagging drive lies between its stops.
        let command = pair[1].u.a + slow.actuator_lag * (pair[1].u.a - pair[0].u.a) / dt;
        assert!(command.abs() < 2.0 * (1.0 + 2e-2), "{command} {pair:?}");
    }
}

/// On a circle a point mass drives v = sqrt(mu g r) on the radius r, lap time 2 pi sqrt(r/(mu g)):
/// fastest on the inside. With the friction ellipse no axle gives more force in any direction; the
/// car is slower by what its tyres' slip costs.
#[test]
fn a_circle_is_driven_at_the_limit_of_grip() {
    let (radius, half, margin) = (3.0, 0.5, 0.1);
    let circle = [Segment::arc(radius, std::f64::consts::PI); 2];
    let track = Arc::new(Track::from_segments("circle", &circle, half, half).unwrap());
    let strong = CarParams { combined_slip: true, ..car("barc") };
    let lap = solve(&strong, &track, &Options::new(margin)).unwrap();
    let inside = radius - half + margin;
    let bound = std::f64::consts::TAU * (inside / (0.9 * 9.81)).sqrt();
    let ratio = lap.lap_time / bound;
    assert!((1.0 - 1e-5..1.02).contains(&ratio), "{ratio}");
}

/// The same input gives the same bits.
#[test]
fn solving_twice_gives_the_same_bits() {
    let (one, other) = (on_l("mini"), on_l("mini"));
    assert_eq!(one, other);
    assert_eq!(one.lap_time.to_bits(), other.lap_time.to_bits());
}

#[test]
fn what_cannot_be_driven_is_refused_with_the_reason() {
    let error = solve(&car("barc"), &l(), &Options::new(0.6)).unwrap_err();
    assert!(matches!(error, Error::TooNarrow { .. }), "{error}");
    assert!(error.to_string().contains("1.100 m wide"), "{error}");
    let error = solve(&car("barc"), &l(), &Options::new(f64::NAN)).unwrap_err();
    assert!(error.to_string().contains("margin is NaN"), "{error}");
    let broken = CarParams { mass: -1.0, ..car("barc") };
    assert!(matches!(solve(&broken, &l(), &Options::new(0.1)), Err(Error::Car(_))));
    // A car that cannot steer round the bends of the track.
    let stiff = CarParams { delta_max: 0.02, ..car("barc") };
    let options = Options { starts: 1, ..Options::new(0.1) };
    let error = solve(&stiff, &l(), &options).unwrap_err();
    assert!(matches!(error, Error::NotConverged { .. }), "{error}");
}
