//! The car file: TOML with units in its keys.

use serde::{Deserialize, Serialize};

use super::tyre_file::TyreFile;
use super::{CAR_KEYS, CarParams, GRAVITY};
use crate::error::ModelError;

/// The keys of a car file; `CarParams` holds their meaning.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CarFile {
    name: String,
    mass_kg: f64,
    inertia_z_kgm2: f64,
    l_f_m: f64,
    l_r_m: f64,
    #[serde(default)]
    h_cg_m: f64,
    length_m: f64,
    width_m: f64,
    #[serde(default)]
    cd: f64,
    #[serde(default)]
    cl_front: f64,
    #[serde(default)]
    cl_rear: f64,
    #[serde(default)]
    area_m2: f64,
    #[serde(default)]
    rho_kgpm3: f64,
    #[serde(default)]
    rolling: f64,
    #[serde(default)]
    linear_drag_per_s: f64,
    #[serde(default)]
    drive_front: f64,
    #[serde(default, alias = "brake_balance")]
    brake_front: f64,
    #[serde(default = "on")]
    front_force_yaw: bool,
    #[serde(default)]
    combined_slip: bool,
    power_max_w: Option<f64>,
    drive_force_max_n: Option<f64>,
    brake_force_max_n: Option<f64>,
    speed_max_mps: Option<f64>,
    a_min_mps2: f64,
    a_max_mps2: f64,
    delta_max_rad: f64,
    delta_rate_max_radps: Option<f64>,
    a_rate_max_mps3: Option<f64>,
    #[serde(default)]
    actuator_lag_s: f64,
    #[serde(default)]
    actuator_delay_s: f64,
    blend_speed_low_mps: Option<f64>,
    blend_speed_high_mps: Option<f64>,
    tyre_front: TyreFile,
    tyre_rear: TyreFile,
}

const fn on() -> bool {
    true
}

/// The car files that ship with the product.
const BUILTIN: [(&str, &str); 7] = [
    ("barc", include_str!("../../../cars/barc.toml")),
    ("iac", include_str!("../../../cars/iac.toml")),
    ("kart", include_str!("../../../cars/kart.toml")),
    ("mini", include_str!("../../../cars/mini.toml")),
    ("f1tenth", include_str!("../../../cars/f1tenth.toml")),
    ("formula_student", include_str!("../../../cars/formula_student.toml")),
    ("road", include_str!("../../../cars/road.toml")),
];

impl CarParams {
    /// Names that [`CarParams::builtin`] knows.
    #[must_use]
    pub fn builtin_names() -> [&'static str; 7] {
        BUILTIN.map(|(name, _)| name)
    }

    /// Reads a car that ships with the product, by one of [`CarParams::builtin_names`].
    ///
    /// # Errors
    /// [`ModelError::UnknownCar`] for any other name.
    pub fn builtin(name: &str) -> Result<Self, ModelError> {
        match BUILTIN.iter().find(|(known, _)| *known == name) {
            Some((_, text)) => Self::from_toml(text),
            None => Err(ModelError::UnknownCar {
                found: name.to_owned(),
                known: Self::builtin_names().join(", "),
            }),
        }
    }

    /// Reads a car file from its text.
    ///
    /// # Errors
    /// [`ModelError::CarSyntax`] for text that is no car file (unknown key, wrong type, missing
    /// key; the message shows the line), [`ModelError::CarInvalid`] with every value out of range.
    pub fn from_toml(text: &str) -> Result<Self, ModelError> {
        let file: CarFile = toml::from_str(text).map_err(ModelError::CarSyntax)?;
        let (mut car, mut problems) = file.into_params();
        // -0 is 0: cars that differ in no more than that have one fingerprint.
        for key in CAR_KEYS {
            if (key.get)(&car) == Some(0.0) {
                (key.set)(&mut car, Some(0.0));
            }
        }
        if problems.is_empty() {
            problems.extend(car.validate());
        } else {
            problems.extend(car.out_of_range());
        }
        for problem in &mut problems {
            problem.line = line_of_key(text, problem.section, problem.key);
        }
        if problems.is_empty() { Ok(car) } else { Err(ModelError::CarInvalid(problems)) }
    }
}

impl CarFile {
    /// The car, and what is wrong with the way the file gives its friction.
    fn into_params(self) -> (CarParams, Vec<super::ParamProblem>) {
        let weight = self.mass_kg * GRAVITY;
        let wheelbase = self.l_f_m + self.l_r_m;
        let mut problems = Vec::new();
        let front_load = weight * (self.l_r_m / wheelbase);
        let rear_load = weight * (self.l_f_m / wheelbase);
        let tyre_front = self.tyre_front.tyre("tyre_front", front_load, &mut problems);
        let tyre_rear = self.tyre_rear.tyre("tyre_rear", rear_load, &mut problems);
        let (low, high) =
            blend_speeds(self.blend_speed_low_mps, self.blend_speed_high_mps, wheelbase);
        let car = CarParams {
            name: self.name,
            mass: self.mass_kg,
            inertia_z: self.inertia_z_kgm2,
            l_f: self.l_f_m,
            l_r: self.l_r_m,
            tyre_front,
            tyre_rear,
            h_cg: self.h_cg_m,
            cd: self.cd,
            cl_front: self.cl_front,
            cl_rear: self.cl_rear,
            area: self.area_m2,
            rho: self.rho_kgpm3,
            rolling: self.rolling,
            linear_drag: self.linear_drag_per_s,
            drive_front: self.drive_front,
            brake_front: self.brake_front,
            front_force_yaw: self.front_force_yaw,
            combined_slip: self.combined_slip,
            power_max: self.power_max_w,
            drive_force_max: self.drive_force_max_n,
            brake_force_max: self.brake_force_max_n,
            speed_max: self.speed_max_mps,
            length: self.length_m,
            width: self.width_m,
            a_min: self.a_min_mps2,
            a_max: self.a_max_mps2,
            delta_max: self.delta_max_rad,
            delta_rate_max: self.delta_rate_max_radps,
            a_rate_max: self.a_rate_max_mps3,
            actuator_lag: self.actuator_lag_s,
            actuator_delay: self.actuator_delay_s,
            blend_speed_low: low,
            blend_speed_high: high,
        };
        (car, problems)
    }
}

/// The blend speeds; what the file leaves out follows from the other one or from the wheelbase: below
/// 0.2 to 0.5 sqrt(g l) the wheels of every size of car roll in all but name.
fn blend_speeds(low: Option<f64>, high: Option<f64>, wheelbase: f64) -> (f64, f64) {
    let scale = (GRAVITY * wheelbase.max(0.0)).sqrt();
    match (low, high) {
        (Some(low), Some(high)) => (low, high),
        (Some(low), None) => (low, 2.5 * low),
        (None, Some(high)) => (0.4 * high, high),
        (None, None) => (0.2 * scale, 0.5 * scale),
    }
}

/// Line (from 1) on which a key of a section stands; the section "" is the top of the file.
fn line_of_key(text: &str, section: &str, key: &str) -> Option<usize> {
    let mut current = "";
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if let Some(head) = line.strip_prefix('[').and_then(|rest| rest.split(']').next()) {
            current = head.trim();
        } else if current == section
            && line.split('=').next().is_some_and(|found| found.trim() == key)
        {
            return Some(index + 1);
        }
    }
    None
}
