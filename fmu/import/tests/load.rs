//! Our FMUs in the `fmi` crate, FMI 2.0 as they are, FMI 3.0 with the attributes taken out that its
//! reader refuses though they are legal: `unit` and `nominal` of a Float64. Controller and car race
//! in lock-step; both versions must command the same.
//!
//! The folder of `make fmu` stands in `LMPC_FMUS`.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs::File;
use std::io::{Cursor, Read};
use std::path::PathBuf;

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation as _, Common as _, InstanceCS as Fmi2};
use fmi::fmi3::import::Fmi3Import;
use fmi::fmi3::{CoSimulation as _, Common as _, Fmi3Model as _, GetSet as _};
use fmi::fmi3::instance::InstanceCS as Fmi3;
use fmi::import;
use fmi::traits::FmiImport;

const PERIOD: f64 = 0.1;
const STEPS: usize = 200;
const STATE: [&str; 6] = ["v_x", "v_y", "omega_z", "e_psi", "s", "e_y"];
const COMMAND: [&str; 2] = ["cmd.a", "cmd.delta"];

/// One API over both versions, as every user of the crate needs it.
trait Slave {
    fn get(&mut self, references: &[u32]) -> Vec<f64>;
    fn set(&mut self, references: &[u32], values: &[f64]);
    fn step(&mut self, time: f64);
}

impl Slave for Fmi2 {
    fn get(&mut self, references: &[u32]) -> Vec<f64> {
        let mut values = vec![0.0; references.len()];
        self.get_real(references, &mut values).unwrap();
        values
    }
    fn set(&mut self, references: &[u32], values: &[f64]) {
        self.set_real(references, values).unwrap();
    }
    fn step(&mut self, time: f64) {
        self.do_step(time, PERIOD, true).unwrap();
    }
}

impl Slave for Fmi3<'_> {
    fn get(&mut self, references: &[u32]) -> Vec<f64> {
        let mut values = vec![0.0; references.len()];
        self.get_float64(references, &mut values).unwrap();
        values
    }
    fn set(&mut self, references: &[u32], values: &[f64]) {
        self.set_float64(references, values).unwrap();
    }
    fn step(&mut self, time: f64) {
        let (mut event, mut stop, mut early, mut last) = (false, false, false, 0.0);
        self.do_step(time, PERIOD, true, &mut event, &mut stop, &mut early, &mut last).unwrap();
        assert!(!stop && !early);
    }
}

fn fmu(version: u32, name: &str) -> PathBuf {
    let folder = std::env::var_os("LMPC_FMUS").map_or("../../out/fmu".into(), PathBuf::from);
    folder.join(format!("fmi{version}/lmpc-{name}.fmu"))
}

fn description(path: &PathBuf) -> String {
    let mut archive = zip::ZipArchive::new(File::open(path).unwrap()).unwrap();
    let mut text = String::new();
    archive.by_name("modelDescription.xml").unwrap().read_to_string(&mut text).unwrap();
    text
}

/// Value references by name.
fn references(xml: &str, names: &[String]) -> Vec<u32> {
    let find = |name: &String| {
        let place = xml.find(&format!("name=\"{name}\"")).unwrap();
        let (_, rest) = xml[place..].split_once("valueReference=\"").unwrap();
        rest.split_once('"').unwrap().0.parse().unwrap()
    };
    names.iter().map(find).collect()
}

/// Every ` key="..."` of a Float64 taken out.
fn without(xml: &str, key: &str) -> String {
    let strip = |line: &str| match line.split_once(&format!(" {key}=\"")) {
        Some((head, tail)) if line.trim_start().starts_with("<Float64") => {
            format!("{head}{}\n", tail.split_once('"').unwrap().1)
        }
        _ => format!("{line}\n"),
    };
    xml.lines().map(strip).collect()
}

/// Commands of a race, controller first.
fn race(controller: &mut dyn Slave, car: &mut dyn Slave, xml: [&str; 2]) -> Vec<Vec<f64>> {
    let state = STATE.map(|name| format!("vehicle.{name}"));
    let command = COMMAND.map(str::to_owned);
    let [state, command] =
        [&state[..], &command].map(|names| xml.map(|xml| references(xml, names)));
    let step = |k: usize| {
        let time = k as f64 * PERIOD;
        controller.set(&state[0], &car.get(&state[1]));
        controller.step(time);
        let u = controller.get(&command[0]);
        car.set(&command[1], &u);
        car.step(time);
        u
    };
    (0..STEPS).map(step).collect()
}

fn race2() -> Vec<Vec<f64>> {
    let paths = ["controller", "vehicle"].map(|name| fmu(2, name));
    let [mut controller, mut car] = paths.each_ref().map(|path| {
        let import: Fmi2Import = import::from_path(path).unwrap();
        let mut fmu = import.instantiate_cs("one", false, false).unwrap();
        fmu.setup_experiment(None, 0.0, None).unwrap();
        fmu.enter_initialization_mode().unwrap();
        fmu.exit_initialization_mode().unwrap();
        (fmu, import)
    });
    let xml = paths.each_ref().map(description);
    race(&mut controller.0, &mut car.0, [&xml[0], &xml[1]])
}

fn race3() -> Vec<Vec<f64>> {
    let paths = ["controller", "vehicle"].map(|name| fmu(3, name));
    let xml = paths.each_ref().map(description);
    let imports = [0, 1].map(|i| {
        let folder = tempfile::tempdir().unwrap();
        let bytes = std::fs::read(&paths[i]).unwrap();
        zip::ZipArchive::new(Cursor::new(bytes)).unwrap().extract(folder.path()).unwrap();
        let relaxed = ["unit", "nominal"].iter().fold(xml[i].clone(), |xml, key| without(&xml, key));
        Fmi3Import::new(folder, &relaxed).unwrap()
    });
    let [mut controller, mut car] = imports.each_ref().map(|import| {
        let mut fmu = import.instantiate_cs("one", false, false, false, false, &[]).unwrap();
        fmu.enter_initialization_mode(None, 0.0, None).unwrap();
        fmu.exit_initialization_mode().unwrap();
        fmu
    });
    race(&mut controller, &mut car, [&xml[0], &xml[1]])
}

#[test]
fn both_versions_race_alike() {
    let (two, three) = (race2(), race3());
    assert_eq!(two.len(), STEPS);
    assert!(two.iter().any(|u| u[1].abs() > 0.1), "the car never steered");
    assert_eq!(two, three);
}
