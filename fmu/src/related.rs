//! Files beside the model that an importer can try an FMU with (layered standard FMI-LS-REF 1.0):
//! a smoke test with its inputs and expected outputs, parameter sets of the cars, and, for the
//! controller, the state of one that has learned.

use std::path::Path;

use crate::controller::ControllerFmu;
use crate::description::Version;
use crate::instance::Instance;
use crate::log::Filter;
use crate::model::FmuModel;
use crate::pack::PackError;
use crate::status::CallError;
use crate::system::{self, Element, Ssp};
use crate::vehicle::VehicleFmu;
use crate::xml::{Xml, number};

/// Communication step of the experiments: the controller's period [s].
const STEP: f64 = 0.1;
/// Steps of the smoke test: one initial lap of the small car is 142.
const SMOKE: usize = 150;
/// Steps after which the controller's state is kept: the initial laps and learned ones.
const LEARNED: usize = 900;

const STATE: [&str; 6] =
    ["vehicle.v_x", "vehicle.v_y", "vehicle.omega_z", "vehicle.e_psi", "vehicle.s", "vehicle.e_y"];
const COMMAND: [&str; 2] = ["cmd.a", "cmd.delta"];

/// Path in the archive and contents.
pub(crate) type Files = Vec<(String, Vec<u8>)>;

/// What goes into the archive of each model.
pub(crate) struct Related {
    pub(crate) controller: Files,
    pub(crate) vehicle: Files,
}

/// One FMU driven from here.
struct Driven<M: FmuModel>(Instance<M>);

impl<M: FmuModel> Driven<M> {
    fn start() -> Result<Self, CallError> {
        let mut fmu = Instance::new(Version::Fmi3, None, Filter::new(false));
        fmu.enter_initialization("reference")?;
        fmu.exit_initialization("reference")?;
        Ok(Self(fmu))
    }

    fn references<const N: usize>(names: &[&str; N]) -> [u32; N] {
        let variables = M::description().table.variables();
        names.map(|name| variables.iter().position(|v| v.name == name).unwrap_or_default() as u32)
    }

    fn get<const N: usize>(&mut self, names: &[&str; N]) -> Result<[f64; N], CallError> {
        let mut values = [0.0; N];
        self.0.get("reference", &Self::references(names), &mut values)?;
        Ok(values)
    }

    fn set<const N: usize>(
        &mut self,
        names: &[&str; N],
        values: &[f64; N],
    ) -> Result<(), CallError> {
        self.0.set("reference", &Self::references(names), values)
    }

    fn step(&mut self, k: usize) -> Result<(), CallError> {
        self.0.do_step("reference", self.0.core.time, (k + 1) as f64 * STEP - self.0.core.time)
    }
}

/// A table with the time in front.
struct Table(String);

impl Table {
    fn new(names: &[&str]) -> Self {
        Self(format!("time,{}\n", names.join(",")))
    }

    fn row(&mut self, k: usize, values: &[f64]) {
        let time = k as f64 * STEP;
        let cells: Vec<String> = [&[time], values].concat().into_iter().map(number).collect();
        self.0.push_str(&cells.join(","));
        self.0.push('\n');
    }
}

/// Drives both models against each other and keeps what they exchanged.
///
/// # Errors
/// [`PackError::Related`] if a model refuses; only a broken build does that.
pub(crate) fn related() -> Result<Related, PackError> {
    race().map_err(|fault| PackError::Related(fault.to_string()))
}

fn race() -> Result<Related, CallError> {
    let mut controller = Driven::<ControllerFmu>::start()?;
    let mut vehicle = Driven::<VehicleFmu>::start()?;
    let (mut states, mut commands) = (Table::new(&STATE), Table::new(&COMMAND));
    // As an output a command stands at the end of its step, as an input at the beginning.
    let mut outputs = Table::new(&COMMAND);
    for k in 0..LEARNED {
        let state = vehicle.get(&STATE)?;
        controller.set(&STATE, &state)?;
        controller.step(k)?;
        let command = controller.get(&COMMAND)?;
        vehicle.set(&COMMAND, &command)?;
        vehicle.step(k)?;
        if k < SMOKE {
            states.row(k, &state);
            commands.row(k, &command);
            outputs.row(k + 1, &command);
        }
    }
    let saved = controller.0.get_state("reference", 0)?;
    let learned = controller.0.serialize("reference", saved)?;
    let (states, commands) = (states.0.into_bytes(), commands.0.into_bytes());
    let outputs = outputs.0.into_bytes();
    let smoke = |stimuli: &[u8], references: &[u8]| {
        vec![
            ("smoke-test.xml".to_owned(), experiment().into_bytes()),
            ("smoke-test-in.csv".to_owned(), stimuli.to_vec()),
            ("smoke-test-ref.csv".to_owned(), references.to_vec()),
        ]
    };
    let mut of_controller = smoke(&states, &outputs);
    of_controller.push(("learned.bin".to_owned(), learned));
    Ok(Related {
        controller: files(of_controller, Element::Controller),
        vehicle: files(smoke(&commands, &states), Element::Vehicle),
    })
}

/// Adds the cars' parameter sets and the manifest, and places all in the archive.
fn files(mut files: Files, element: Element) -> Files {
    for set in system::SETS {
        let text = system::ssv(Ssp::V1, &set, element);
        files.push((format!("{}.ssv", set.car), text.into_bytes()));
    }
    files.push(("fmi-ls-manifest.xml".to_owned(), manifest(&files).into_bytes()));
    let placed = |(name, bytes)| (format!("extra/org.fmi-standard.fmi-ls-ref/{name}"), bytes);
    files.into_iter().map(placed).collect()
}

/// The smoke test: inputs held from their time on, outputs as they are at their time.
fn experiment() -> String {
    let mut xml = Xml::new();
    xml.open("Experiments", &[]);
    xml.open(
        "Experiment",
        &[
            ("name", "smoke-test".to_owned()),
            ("description", "Default parameters, one initial lap of the small car".to_owned()),
            ("startTime", number(0.0)),
            ("stopTime", number(SMOKE as f64 * STEP)),
            ("stepSize", number(STEP)),
        ],
    );
    xml.leaf("Stimuli", &[("source", "smoke-test-in.csv".to_owned())]);
    xml.leaf("References", &[("source", "smoke-test-ref.csv".to_owned())]);
    xml.close("Experiment");
    xml.close("Experiments");
    xml.finish()
}

fn manifest(files: &Files) -> String {
    let mut xml = Xml::new();
    xml.open(
        "fmiReferences",
        &[
            ("xmlns:fmi-ls", "http://fmi-standard.org/fmi-ls-manifest".to_owned()),
            ("fmi-ls:fmi-ls-name", "org.fmi-standard.fmi-ls-ref".to_owned()),
            ("fmi-ls:fmi-ls-version", "1.0.0-alpha.1".to_owned()),
            (
                "fmi-ls:fmi-ls-description",
                "Layered Standard providing information on related files included in an FMU."
                    .to_owned(),
            ),
        ],
    );
    for (name, _) in files {
        let ending = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or_default();
        let (kind, role) = match ending {
            "xml" => ("application/xml", "experiment/smoke-test"),
            "csv" => ("text/csv", "result"),
            "ssv" => ("application/x-ssp-parameter-set", "parameter"),
            _ => ("application/octet-stream", "serialized-state"),
        };
        xml.leaf(
            "Related",
            &[("type", kind.to_owned()), ("source", name.clone()), ("role", role.to_owned())],
        );
    }
    xml.close("fmiReferences");
    xml.finish()
}
