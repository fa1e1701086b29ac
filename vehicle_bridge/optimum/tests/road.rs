//! Time-optimal laps on banked and sloped roads, and under speed limits, against point masses.
#![allow(clippy::unwrap_used, reason = "a test that has no lap has failed")]

use std::f64::consts::PI;
use std::sync::Arc;

use optimum::{Optimum, Options, solve};
use vehicle_model::track::{Station, wrap_angle};
use vehicle_model::{CarParams, GRAVITY, RoadPoint, Segment, Track};

const RADIUS: f64 = 3.0;
const STRAIGHT: f64 = 8.0;

fn oval() -> Track {
    let straight = Segment::straight(STRAIGHT);
    let bend = Segment::arc(RADIUS, PI);
    Track::from_segments("oval", &[straight, bend, straight, bend], 0.5, 0.5).unwrap()
}

/// 9 degrees in the bends, the outer edge the higher one, over ramps of 1 m.
fn banked() -> Track {
    let bank = -9.0_f64.to_radians();
    let turn = STRAIGHT + PI * RADIUS;
    let knots = [
        (0.0, 0.0),
        (STRAIGHT - 1.0, 0.0),
        (STRAIGHT, bank),
        (turn, bank),
        (turn + 1.0, 0.0),
        (turn + STRAIGHT - 1.0, 0.0),
        (turn + STRAIGHT, bank),
        (2.0 * turn - 1e-6, bank),
    ];
    // The ramp behind the second bend lies behind the line.
    let ramp = Station { s: 1.0, bank: Some(0.0), ..Station::default() };
    let mut stations: Vec<Station> = knots[1..]
        .iter()
        .map(|&(s, bank)| Station { s, bank: Some(bank), ..Station::default() })
        .collect();
    stations.push(ramp);
    oval().with_stations(&stations).unwrap()
}

fn lap(car: &CarParams, track: &Track) -> Optimum {
    let options = Options { starts: 2, ..Options::new(0.1) };
    let lap = solve(car, &Arc::new(track.clone()), &options).unwrap();
    assert!(lap.quality.scaled_defect < 1e-4, "{:?}", lap.quality);
    lap
}

/// Lap time of a point mass on the line of a lap: bends at the limit of grip, between them full drive
/// and brakes.
fn point_mass(car: &CarParams, track: &Track, lap: &Optimum) -> f64 {
    // The last point is the first one lap later.
    let points = &lap.points[..lap.points.len() - 1];
    let n = points.len();
    let poses: Vec<_> = points.iter().map(|p| track.to_global(&p.x)).collect();
    let course = |i: usize| poses[i].psi + (points[i].x.v_y / points[i].x.v_x).atan();
    let length: Vec<f64> = (0..n)
        .map(|i| {
            let (a, b) = (&poses[i], &poses[(i + 1) % n]);
            (b.x - a.x).hypot(b.y - a.y)
        })
        .collect();
    let mut v: Vec<f64> = (0..n)
        .map(|i| {
            let before = (i + n - 1) % n;
            let turned = wrap_angle(course((i + 1) % n) - course(before));
            let kappa = turned / (length[before] + length[i]);
            RoadPoint::of(&track.road(), points[i].x.s).corner_speed(kappa, car.tyre_front.mu, 0.0)
        })
        .collect();
    for i in 0..2 * n {
        let next = (i + 1) % n;
        v[next] = v[next].min((v[i % n].powi(2) + 2.0 * car.a_max * length[i % n]).sqrt());
    }
    for i in (0..2 * n).rev() {
        let next = (i + 1) % n;
        v[i % n] = v[i % n].min((v[next].powi(2) - 2.0 * car.a_min * length[i % n]).sqrt());
    }
    (0..n).map(|i| 2.0 * length[i] / (v[i] + v[(i + 1) % n])).sum()
}

#[test]
fn a_banked_oval_is_faster_by_what_a_point_mass_says() {
    let car = CarParams::builtin("barc").unwrap();
    let (flat, steep) = (lap(&car, &oval()), lap(&car, &banked()));
    let expected = point_mass(&car, &banked(), &steep) / point_mass(&car, &oval(), &flat);
    let (flat, steep) = (flat.lap_time, steep.lap_time);
    let found = steep / flat;
    println!("flat {flat:.4} s, banked {steep:.4} s, ratio {found:.4}, point mass {expected:.4}");
    assert!(expected < 0.95);
    assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
}

/// Power, drag and weight: at the end of a long straight the car drives the speed at which they
/// balance.
#[test]
fn a_climb_costs_what_power_and_mass_say() {
    let car =
        CarParams { power_max: Some(8.0), linear_drag: 0.5, ..CarParams::builtin("barc").unwrap() };
    let turn = STRAIGHT + PI * RADIUS;
    let slope = 0.05;
    let hill = |s, slope| Station { s, slope: Some(slope), ..Station::default() };
    let stations = [
        hill(0.0, slope),
        hill(STRAIGHT, slope),
        hill(turn, -slope),
        hill(turn + STRAIGHT, -slope),
        hill(2.0 * turn - 1e-6, slope),
    ];
    let hills = oval().with_stations(&stations).unwrap();
    let (level, hilly) = (lap(&car, &oval()), lap(&car, &hills));
    // P/(m v) = drag v + g sin(slope)
    let balance = |slope: f64| {
        let climb = GRAVITY * slope.sin();
        let power = 8.0 / car.mass;
        (-climb + (climb * climb + 4.0 * car.linear_drag * power).sqrt()) / (2.0 * car.linear_drag)
    };
    // Speeds approach the balance along the straight as d(v)/ds = (P/(m v) - drag v - climb)/v.
    let driven = |lap: &Optimum, from: f64, to: f64, slope: f64| {
        let at = |s: f64| {
            lap.points
                .iter()
                .min_by(|a, b| (a.x.s - s).abs().total_cmp(&(b.x.s - s).abs()))
                .unwrap()
        };
        let (begin, end) = (at(from), at(to));
        let mut v = begin.x.v_x;
        let n = 20_000;
        let ds = (end.x.s - begin.x.s) / f64::from(n);
        for _ in 0..n {
            v += ds * (8.0 / car.mass / v - car.linear_drag * v - GRAVITY * slope.sin()) / v;
        }
        (end.x.v_x, v)
    };
    for (lap, from, slope) in
        [(&level, 1.0, 0.0), (&hilly, 1.0, slope), (&hilly, turn + 1.0, -slope)]
    {
        let (found, expected) = driven(lap, from, from + 5.0, slope);
        println!(
            "slope {slope}: {found:.4} m/s, power and weight {expected:.4}, balance {:.3}",
            balance(slope)
        );
        assert!((found / expected - 1.0).abs() < 0.01, "slope {slope}: {found} {expected}");
    }
    assert!(hilly.lap_time > level.lap_time, "{} {}", hilly.lap_time, level.lap_time);
}

#[test]
fn speed_limits_are_kept() {
    let car = CarParams::builtin("barc").unwrap();
    let limit = |s, v| Station { s, speed_limit: Some(v), ..Station::default() };
    let track = oval().with_stations(&[limit(2.0, 1.5), limit(5.0, f64::INFINITY)]).unwrap();
    let (free, limited) = (lap(&car, &oval()), lap(&car, &track));
    for point in limited.points.iter().filter(|p| (2.0..=5.0).contains(&p.x.s)) {
        assert!(point.x.v_x < 1.5 + 1e-4, "{point:?}");
    }
    assert!(limited.lap_time > free.lap_time + 0.3, "{} {}", limited.lap_time, free.lap_time);
    let slow = CarParams { speed_max: Some(2.5), ..car };
    let governed = lap(&slow, &oval());
    let fastest = governed.points.iter().map(|p| p.x.v_x).fold(0.0, f64::max);
    assert!(fastest < 2.5 + 1e-4 && fastest > 2.4, "{fastest}");
}
