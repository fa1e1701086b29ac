//! The tyre of an axle as a car file gives it: by the curve, or by what data sheets say.

use serde::{Deserialize, Serialize};

use super::{ParamProblem, Tyre};

/// Shape factor where the file has none: a lateral one of passenger cars (Pacejka 2012, table 4.2).
const SHAPE: f64 = 1.3;

/// Keys of an axle's section.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TyreFile {
    b: Option<f64>,
    c: Option<f64>,
    mu: Option<f64>,
    peak_n: Option<f64>,
    cornering_stiffness_n_per_rad: Option<f64>,
    cornering_stiffness_norm_per_rad: Option<f64>,
}

impl TyreFile {
    /// The tyre under the static load `load` \[N\]; what is missing or said twice goes to `problems`.
    ///
    /// The slope of F_y = D sin(C atan(B alpha)) at 0 is B C D with D = mu F_z, so that a cornering
    /// stiffness C_alpha gives B = C_alpha / (C mu F_z), and one normalised by the peak force, C_S =
    /// C_alpha / (mu F_z), gives B = C_S / C.
    pub(super) fn tyre(
        &self,
        section: &'static str,
        load: f64,
        problems: &mut Vec<ParamProblem>,
    ) -> Tyre {
        let mut problem = |key, found: String, expected| {
            problems.push(ParamProblem { section, key, found, expected, line: None });
        };
        let mu = match (self.mu, self.peak_n) {
            (Some(mu), None) => mu,
            (None, Some(peak)) => peak / load,
            (found, _) => {
                let found = if found.is_some() { "mu and peak_n" } else { "neither" };
                problem("mu", found.to_owned(), "either mu or peak_n");
                1.0
            }
        };
        let stiffness = [
            ("b", self.b),
            ("cornering_stiffness_n_per_rad", self.cornering_stiffness_n_per_rad),
            ("cornering_stiffness_norm_per_rad", self.cornering_stiffness_norm_per_rad),
        ];
        let given: Vec<&str> =
            stiffness.iter().filter(|(_, value)| value.is_some()).map(|(key, _)| *key).collect();
        if given.len() != 1 {
            let found =
                if given.is_empty() { "none of them".to_owned() } else { given.join(" and ") };
            let expected =
                "one of b, cornering_stiffness_n_per_rad, cornering_stiffness_norm_per_rad";
            problem("b", found, expected);
        }
        for (key, value) in &stiffness[1..] {
            if let Some(value) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
                problem(key, value.to_string(), "a number above 0");
            }
        }
        let c = match (self.b, self.c) {
            (_, Some(c)) => c,
            (None, None) => SHAPE,
            (Some(_), None) => {
                problem("c", "none".to_owned(), "the shape factor C that belongs to b");
                SHAPE
            }
        };
        let b = match (self.b, stiffness[1].1, stiffness[2].1) {
            (Some(b), ..) => b,
            (None, Some(slope), _) => slope / (c * mu * load),
            (None, None, Some(norm)) => norm / c,
            _ => 1.0,
        };
        Tyre { b, c, mu, secant: super::Secant::default() }
    }
}

#[cfg(test)]
mod tests {
    use crate::{CarParams, Input, Model, ModelKind, State};

    /// The slope of the force at zero slip is the stiffness of the data sheet.
    #[test]
    fn a_cornering_stiffness_is_the_slope_of_the_force() {
        let text = include_str!("../../../cars/road.toml");
        let (body, _) = text.split_once("[tyre_front]").unwrap();
        let axles = "[tyre_front]\ncornering_stiffness_n_per_rad = 120000.0\nmu = 0.95\n\
                     [tyre_rear]\ncornering_stiffness_norm_per_rad = 20.0\nc = 1.5\npeak_n = 6000.0\n";
        let car = CarParams::from_toml(&format!("{body}{axles}")).unwrap();
        let rear_load = car.static_loads()[1];
        assert!((car.tyre_rear.mu - 6000.0 / rear_load).abs() < 1e-12);
        let model = Model::new(ModelKind::Dynamic, car.clone());
        let force = |v_y: f64| {
            let x = State { v_x: 20.0, v_y, ..State::default() };
            model.forces(&x, &Input::default()).lateral
        };
        let slip = 1e-5;
        for (axle, stiffness) in [(0, 120_000.0), (1, 20.0 * 6000.0)] {
            let slope = (force(-20.0 * slip)[axle] - force(20.0 * slip)[axle]) / (2.0 * slip);
            assert!((slope / stiffness - 1.0).abs() < 1e-6, "{slope} {stiffness}");
        }
    }

    #[test]
    fn a_stiffness_said_twice_or_not_at_all_is_named() {
        let text = include_str!("../../../cars/barc.toml");
        let twice =
            text.replacen("b = 5.0 ", "b = 5.0\ncornering_stiffness_norm_per_rad = 4.0 ", 1);
        let message = CarParams::from_toml(&twice).unwrap_err().to_string();
        assert!(message.contains("found b and cornering_stiffness_norm_per_rad"), "{message}");
        let none = text.replacen("b = 5.0 ", "", 1);
        let message = CarParams::from_toml(&none).unwrap_err().to_string();
        assert!(message.contains("expected one of b, cornering"), "{message}");
    }
}
