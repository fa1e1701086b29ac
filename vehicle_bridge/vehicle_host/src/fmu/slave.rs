//! A co-simulation FMU of either version, through the `fmi` crate.
#![allow(unsafe_code, reason = "shared libraries of others are loaded and called")]

use std::collections::BTreeMap;
use std::ffi::CString;
use std::fs::{self, File};
use std::io::Read as _;
use std::path::{Path, PathBuf};

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{self as instance2, CoSimulation as _, Common as _};
use fmi::fmi3::import::Fmi3Import;
use fmi::fmi3::{CoSimulation as _, Fmi3Model as _, GetSet as _};
use fmi::traits::{FmiImport as _, FmiInstance as _};
use fmu_core::{Inspection, inspect};

use super::element::{self, Element, find};
use super::error::FmuError;
use super::{heard, reduced};

type Fmi3Instance = fmi::fmi3::instance::InstanceCS;

/// A value for a variable, as a table has it.
#[derive(Debug, Clone, PartialEq)]
pub enum VariableValue {
    /// A number of any type.
    Number(f64),
    /// A truth value.
    Boolean(bool),
    /// A text.
    Text(String),
}

/// A variable of an FMU, ready to be read and set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImportedVariable {
    /// Its name.
    pub name: String,
    kind: String,
    reference: u32,
    element: Option<Element>,
}

enum Instance {
    // The instance before the folder of its library: it is dropped first.
    Two(Box<instance2::InstanceCS>, #[expect(dead_code, reason = "owns the folder")] Fmi2Import),
    Three(Box<Fmi3Instance>, #[expect(dead_code, reason = "owns the folder")] Fmi3Import),
}

/// An instance of a co-simulation FMU; its files are in a folder that goes with it.
pub struct CoSimInstance {
    instance: Instance,
    inspection: Inspection,
    path: PathBuf,
    /// Arrays of which elements are set, by reference: FMI sets them whole.
    arrays: BTreeMap<u32, Vec<f64>>,
}

// SAFETY: FMI lets any thread call an instance, one at a time; `&mut self` sees to that.
unsafe impl Send for CoSimInstance {}

impl CoSimInstance {
    /// Unpacks and instantiates an FMU. `preload` is a library its own needs and does not name;
    /// that of a PythonFMU is looked for.
    ///
    /// # Errors
    /// [`FmuError`] if it is no co-simulation FMU for this platform or refuses to begin.
    pub fn open(path: &Path, preload: Option<&Path>) -> Result<Self, FmuError> {
        let failed = |reason: String| FmuError::Load { path: path.to_owned(), reason };
        heard::listen();
        let inspection = inspect(path)?;
        let folder = unpack(path).map_err(|e| failed(e.to_string()))?;
        super::preload::preload(&inspection, preload).map_err(failed)?;
        let description = reduced::reduce(&inspection.model_description).map_err(failed)?;
        let version = attribute(&inspection, "fmiVersion");
        let refused = |e: fmi::Error| failed(with_heard(&e.to_string()));
        let instance = if version.starts_with('2') {
            let import = Fmi2Import::new(folder, &description).map_err(refused)?;
            let instance = import.instantiate_cs("vehicle", false, true).map_err(refused)?;
            Instance::Two(Box::new(instance), import)
        } else if version.starts_with('3') {
            let import = Fmi3Import::new(folder, &description).map_err(refused)?;
            let instance = import
                .instantiate_cs("vehicle", false, true, false, false, &[])
                .map_err(refused)?;
            Instance::Three(Box::new(instance), import)
        } else {
            return Err(failed(format!("FMI version `{version}`, expected 2.0 or 3.0")));
        };
        Ok(Self { instance, inspection, path: path.to_owned(), arrays: BTreeMap::new() })
    }

    /// What is inside the FMU.
    #[must_use]
    pub fn inspection(&self) -> &Inspection {
        &self.inspection
    }

    /// The variable of this name, or the element of an array: `velocity[0]`.
    ///
    /// # Errors
    /// [`FmuError::NoVariable`] if there is no such variable or element.
    pub fn variable(&self, name: &str) -> Result<ImportedVariable, FmuError> {
        let (row, element) = find(&self.inspection, name).map_err(|reason| {
            FmuError::NoVariable { path: self.path.clone(), name: name.to_owned(), reason }
        })?;
        let reference = row.value_reference.parse().map_err(|_| FmuError::Load {
            path: self.path.clone(),
            reason: format!("{name}: value reference `{}` is no number", row.value_reference),
        })?;
        Ok(ImportedVariable { name: name.to_owned(), kind: row.kind.clone(), reference, element })
    }

    fn outcome<T, E: std::fmt::Display>(
        &self,
        what: &str,
        result: Result<T, E>,
    ) -> Result<T, FmuError> {
        result.map_err(|status| FmuError::Refused {
            path: self.path.clone(),
            call: what.to_owned(),
            reason: with_heard(&format!("status {status}")),
        })
    }

    /// Sets variables in order; `values` holds as many.
    ///
    /// # Errors
    /// [`FmuError`] if the FMU refuses one.
    pub fn set_numbers(&mut self, to: &[ImportedVariable], values: &[f64]) -> Result<(), FmuError> {
        for (variable, value) in to.iter().zip(values) {
            self.set(variable, &VariableValue::Number(*value))?;
        }
        Ok(())
    }

    /// Sets a variable.
    ///
    /// # Errors
    /// [`FmuError`] if the value does not fit its type, or the FMU refuses it.
    pub fn set(&mut self, to: &ImportedVariable, value: &VariableValue) -> Result<(), FmuError> {
        let vr = [to.reference];
        let what = || format!("setting {}", to.name);
        let misfit = || FmuError::Misfit {
            path: self.path.clone(),
            name: to.name.clone(),
            kind: to.kind.clone(),
            found: format!("{value:?}"),
        };
        if let (Some(element), VariableValue::Number(v)) = (to.element, value) {
            return self.set_element(to, element, *v);
        }
        #[expect(clippy::cast_possible_truncation, reason = "whole numbers of the right size")]
        match (&mut self.instance, to.kind.as_str(), value) {
            (Instance::Two(i, _), "Real", VariableValue::Number(v)) => {
                let done = i.set_real(&vr, &[*v]).map(drop);
                self.outcome(&what(), done)
            }
            (Instance::Two(i, _), "Integer" | "Enumeration", VariableValue::Number(v)) => {
                let done = i.set_integer(&vr, &[*v as i32]).map(drop);
                self.outcome(&what(), done)
            }
            (Instance::Two(i, _), "Boolean", VariableValue::Boolean(v)) => {
                let done = i.set_boolean(&vr, &[i32::from(*v)]).map(drop);
                self.outcome(&what(), done)
            }
            (Instance::Two(i, _), "String", VariableValue::Text(v)) => {
                let text = CString::new(v.as_str()).map_err(|_| misfit())?;
                let done = i.set_string(&vr, &[text]);
                self.outcome(&what(), done)
            }
            (Instance::Three(i, _), kind, VariableValue::Number(v)) => {
                let done = match kind {
                    "Float64" => i.set_float64(&vr, &[*v]),
                    "Float32" => i.set_float32(&vr, &[*v as f32]),
                    "Int32" => i.set_int32(&vr, &[*v as i32]),
                    "Int64" | "Enumeration" => i.set_int64(&vr, &[*v as i64]),
                    _ => return Err(misfit()),
                };
                self.outcome(&what(), done.map(drop))
            }
            (Instance::Three(i, _), "Boolean", VariableValue::Boolean(v)) => {
                let done = i.set_boolean(&vr, &[*v]).map(drop);
                self.outcome(&what(), done)
            }
            (Instance::Three(i, _), "String", VariableValue::Text(v)) => {
                let text = CString::new(v.as_str()).map_err(|_| misfit())?;
                let done = i.set_string(&vr, &[text]);
                self.outcome(&what(), done)
            }
            _ => Err(misfit()),
        }
    }

    /// Sets an array with this element in it, and all others as they were set last.
    fn set_element(
        &mut self,
        to: &ImportedVariable,
        element: Element,
        v: f64,
    ) -> Result<(), FmuError> {
        let row = find(&self.inspection, &to.name).ok().map(|(row, _)| row);
        let array = self.arrays.entry(to.reference).or_insert_with(|| {
            row.map_or_else(Vec::new, |row| element::starts(row, element.count))
        });
        if let Some(place) = array.get_mut(element.index) {
            *place = v;
        }
        let vr = [to.reference];
        #[expect(clippy::cast_possible_truncation, reason = "numbers of the right size")]
        let done = match (&mut self.instance, to.kind.as_str()) {
            (Instance::Three(i, _), "Float64") => i.set_float64(&vr, array),
            (Instance::Three(i, _), "Float32") => {
                i.set_float32(&vr, &array.iter().map(|v| *v as f32).collect::<Vec<_>>())
            }
            _ => return Err(self.no_array(to)),
        };
        self.outcome(&format!("setting {}", to.name), done.map(drop))
    }

    fn element(&mut self, of: &ImportedVariable, element: Element) -> Result<f64, FmuError> {
        let vr = [of.reference];
        let mut all = vec![0.0; element.count];
        let found = match (&mut self.instance, of.kind.as_str()) {
            (Instance::Three(i, _), "Float64") => i.get_float64(&vr, &mut all).map(drop),
            (Instance::Three(i, _), "Float32") => {
                let mut single = vec![0.0; element.count];
                let done = i.get_float32(&vr, &mut single).map(drop);
                all = single.into_iter().map(f64::from).collect();
                done
            }
            _ => return Err(self.no_array(of)),
        };
        self.outcome(&format!("reading {}", of.name), found)?;
        Ok(all.get(element.index).copied().unwrap_or(f64::NAN))
    }

    fn no_array(&self, of: &ImportedVariable) -> FmuError {
        FmuError::Misfit {
            path: self.path.clone(),
            name: of.name.clone(),
            kind: of.kind.clone(),
            found: "an element of an array, expected Float64 or Float32".to_owned(),
        }
    }

    /// Reads numbers in order; `values` holds as many.
    ///
    /// # Errors
    /// [`FmuError`] if a variable is not a number, or the FMU refuses to read it.
    pub fn numbers(&mut self, of: &[ImportedVariable], values: &mut [f64]) -> Result<(), FmuError> {
        for (variable, value) in of.iter().zip(values) {
            *value = self.number(variable)?;
        }
        Ok(())
    }

    fn number(&mut self, of: &ImportedVariable) -> Result<f64, FmuError> {
        if let Some(element) = of.element {
            return self.element(of, element);
        }
        let vr = [of.reference];
        let mut real = [0.0];
        #[expect(clippy::cast_precision_loss, reason = "counts")]
        let found = match (&mut self.instance, of.kind.as_str()) {
            (Instance::Two(i, _), "Real") => {
                i.get_real(&vr, &mut real).map(|_| real[0]).map_err(|e| e.to_string())
            }
            (Instance::Two(i, _), "Integer" | "Enumeration") => {
                let mut n = [0];
                i.get_integer(&vr, &mut n).map(|_| f64::from(n[0])).map_err(|e| e.to_string())
            }
            (Instance::Three(i, _), "Float64") => {
                i.get_float64(&vr, &mut real).map(|_| real[0]).map_err(|e| e.to_string())
            }
            (Instance::Three(i, _), "Float32") => {
                let mut n = [0.0];
                i.get_float32(&vr, &mut n).map(|_| f64::from(n[0])).map_err(|e| e.to_string())
            }
            (Instance::Three(i, _), "Int32") => {
                let mut n = [0];
                i.get_int32(&vr, &mut n).map(|_| f64::from(n[0])).map_err(|e| e.to_string())
            }
            (Instance::Three(i, _), "Int64") => {
                let mut n = [0];
                i.get_int64(&vr, &mut n).map(|_| n[0] as f64).map_err(|e| e.to_string())
            }
            _ => {
                return Err(FmuError::Misfit {
                    path: self.path.clone(),
                    name: of.name.clone(),
                    kind: of.kind.clone(),
                    found: "a number".to_owned(),
                });
            }
        };
        self.outcome(&format!("reading {}", of.name), found)
    }

    /// Goes through initialisation at time 0; parameters are set before.
    ///
    /// # Errors
    /// [`FmuError`] if the FMU refuses.
    pub fn begin(&mut self) -> Result<(), FmuError> {
        let done = match &mut self.instance {
            Instance::Two(i, _) => i
                .setup_experiment(None, 0.0, None)
                .and_then(|_| instance2::Common::enter_initialization_mode(&mut **i))
                .and_then(|_| instance2::Common::exit_initialization_mode(&mut **i))
                .map(drop)
                .map_err(|e| e.to_string()),
            Instance::Three(i, _) => i
                .enter_initialization_mode(None, 0.0, None)
                .and_then(|_| i.exit_initialization_mode())
                .map(drop)
                .map_err(|e| e.to_string()),
        };
        self.outcome("initialisation", done)
    }

    /// Steps from `time` over `size` seconds.
    ///
    /// # Errors
    /// [`FmuError`] if the FMU refuses, ends the simulation, or returns early.
    pub fn step(&mut self, time: f64, size: f64) -> Result<(), FmuError> {
        let done = match &mut self.instance {
            Instance::Two(i, _) => {
                i.do_step(time, size, true).map(drop).map_err(|e| format!("status {e}"))
            }
            Instance::Three(i, _) => {
                let (mut event, mut ended, mut early, mut last) = (false, false, false, time);
                let (event, ended, early) = (&mut event, &mut ended, &mut early);
                match i.do_step(time, size, true, event, ended, early, &mut last) {
                    Ok(_) if *ended => Err("it ended the simulation".to_owned()),
                    Ok(_) if *early => Err(format!("it returned early, at {last} s")),
                    Ok(_) => Ok(()),
                    Err(e) => Err(format!("status {e}")),
                }
            }
        };
        let call = format!("the step from {time:.3} s");
        done.map_err(|reason| FmuError::Refused {
            path: self.path.clone(),
            call,
            reason: with_heard(&reason),
        })
    }
}

/// An attribute of the model description, empty if it is not there.
pub(super) fn attribute<'a>(inspection: &'a Inspection, key: &str) -> &'a str {
    inspection.attributes.iter().find(|(k, _)| k == key).map_or("", |(_, v)| v)
}

/// What happened, with the FMU's own message.
fn with_heard(what: &str) -> String {
    match heard::take() {
        Some(said) => format!("{what}; the FMU's message: {said}"),
        None => what.to_owned(),
    }
}

fn unpack(path: &Path) -> std::io::Result<tempfile::TempDir> {
    let folder = tempfile::Builder::new().prefix("lmpc-fmu").tempdir()?;
    let mut archive = zip::ZipArchive::new(File::open(path)?)?;
    for i in 0..archive.len() {
        let mut member = archive.by_index(i)?;
        // A name that leads out of the folder is none.
        let Some(name) = member.enclosed_name().map(|name| folder.path().join(name)) else {
            continue;
        };
        if member.is_dir() {
            fs::create_dir_all(name)?;
            continue;
        }
        if let Some(parent) = name.parent() {
            fs::create_dir_all(parent)?;
        }
        let mut bytes = Vec::new();
        member.read_to_end(&mut bytes)?;
        fs::write(name, bytes)?;
    }
    Ok(folder)
}
