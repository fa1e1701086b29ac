//! What a car file was read as, in the quantities of data sheets.

use vehicle_model::{CarParams, GRAVITY};

/// What follows from a car's parameters, in the quantities of data sheets.
#[must_use]
pub fn facts(car: &CarParams) -> Vec<String> {
    let (wheelbase, loads) = (car.wheelbase(), car.static_loads());
    let mut facts = vec![
        format!(
            "{}: {} kg, wheelbase {:.4} m, {:.1} % of the weight in front, yaw inertia {} kg m^2",
            car.name,
            car.mass,
            wheelbase,
            100.0 * loads[0] / (loads[0] + loads[1]),
            car.inertia_z
        ),
        format!(
            "body {} x {} m, turning radius {:.2} m at full lock of {} rad",
            car.length,
            car.width,
            wheelbase / car.delta_max.tan(),
            car.delta_max
        ),
    ];
    let axles = [("front", &car.tyre_front, loads[0]), ("rear", &car.tyre_rear, loads[1])];
    let stiffness = axles.map(|(_, tyre, load)| tyre.b * tyre.c * tyre.mu * load);
    for ((name, tyre, load), stiffness) in axles.into_iter().zip(stiffness) {
        let peak = tyre.peak_slip();
        let peak = if peak.is_finite() { format!("at {peak:.3} rad") } else { "never".to_owned() };
        facts.push(format!(
            "{name} axle: B {:.3}, C {:.3}, mu {:.3}; peak {:.4} N {peak}, cornering stiffness {:.5} \
             N/rad ({:.2}/rad)",
            tyre.b,
            tyre.c,
            tyre.mu,
            Significant(tyre.mu * load),
            Significant(stiffness),
            tyre.b * tyre.c
        ));
    }
    // Bicycle in a slow steady bend: delta = l/R + K a_y (Rajamani 2012, section 3.3).
    let gradient = car.mass / wheelbase * (car.l_r / stiffness[0] - car.l_f / stiffness[1]);
    facts.push(format!(
        "{} in a bend: {:+.4} rad of steering per g",
        if gradient.abs() < 1e-9 {
            "neutral"
        } else if gradient > 0.0 {
            "understeers"
        } else {
            "oversteers"
        },
        gradient * GRAVITY
    ));
    facts.push(format!(
        "drives {:.0} % and brakes {:.0} % with the front axle, {} to {} m/s^2{}",
        100.0 * car.drive_front,
        100.0 * car.brake_front,
        car.a_min,
        car.a_max,
        top_speed(car)
    ));
    facts
}

/// Top speed by power and what resists, and by the file's own limit.
fn top_speed(car: &CarParams) -> String {
    let resists = |v: f64| {
        0.5 * car.rho * car.cd * car.area * v * v
            + car.rolling * car.mass * GRAVITY
            + car.linear_drag * car.mass * v
    };
    let force = |v: f64| {
        let engine = car.drive_force_max.unwrap_or(f64::INFINITY).min(car.mass * car.a_max);
        engine.min(car.power_max.map_or(f64::INFINITY, |power| power / v))
    };
    let (mut low, mut high) = (0.1, 1000.0);
    if force(high) < resists(high) {
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if force(middle) > resists(middle) { low = middle } else { high = middle }
        }
    }
    match (car.speed_max, high < 1000.0) {
        (Some(top), true) if top < high => format!(", top speed {top} m/s"),
        (Some(top), false) => format!(", top speed {top} m/s"),
        (_, true) => format!(", top speed {high:.1} m/s by what resists"),
        (None, false) => ", no top speed".to_owned(),
    }
}

/// A number with as many significant digits as the precision says.
struct Significant(f64);

impl std::fmt::Display for Significant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = f.precision().unwrap_or(4) as i32;
        let left = digits - 1 - self.0.abs().max(f64::MIN_POSITIVE).log10().floor() as i32;
        write!(f, "{:.*}", usize::try_from(left).unwrap_or(0), self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_road_car_understeers_by_what_its_axles_say() {
        let facts = facts(&CarParams::builtin("f1tenth").unwrap()).join("\n");
        // F1TENTH gym: C_S 4.718 and 5.4562.
        assert!(facts.contains("(4.72/rad)") && facts.contains("(5.46/rad)"), "{facts}");
        assert!(facts.contains("turning radius 0.74 m"), "{facts}");
        // l (1/(B C mu) front - rear) / l in rad per g.
        let expected = (1.0 / 4.718 - 1.0 / 5.4562) / 1.0489;
        assert!(facts.contains(&format!("understeers in a bend: {expected:+.4} rad")), "{facts}");
    }
}
