//! One instance of a model: the state machine both standards share.

mod access;
mod run;
mod snapshot;

use std::collections::BTreeMap;
use std::ffi::CString;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

pub(crate) use access::{Boolean2, Boolean3, Element};
use snapshot::FmuState;

use crate::description::Version;
use crate::log::{CallLog, Filter};
use crate::model::{FmuModel, Io};
use crate::status::CallError;
use crate::values::VariableValues;

/// Where an instance is in its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    /// Made or reset; parameters may be set.
    Instantiated,
    /// Between enter and exit of the initialisation mode.
    Initialization,
    /// Steps may be taken.
    Stepping,
    /// Terminated; values may be read.
    Terminated,
    /// The model failed; values may be read, the instance reset or an earlier state restored.
    Failed,
    /// Nothing but freeing is left.
    Dead,
}

impl Phase {
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Instantiated => "instantiated",
            Self::Initialization => "in initialisation mode",
            Self::Stepping => "stepping",
            Self::Terminated => "terminated",
            Self::Failed => "in the error state",
            Self::Dead => "broken",
        }
    }

    pub(crate) const ALL: [Self; 6] = [
        Self::Instantiated,
        Self::Initialization,
        Self::Stepping,
        Self::Terminated,
        Self::Failed,
        Self::Dead,
    ];
}

/// The part of an instance that a saved FMU state covers.
#[derive(Clone)]
pub(crate) struct Core {
    pub(crate) phase: Phase,
    /// Times [s]: start of the simulation, now, and the end if the host defined one.
    pub(crate) origin: f64,
    pub(crate) time: f64,
    pub(crate) stop: Option<f64>,
    pub(crate) values: VariableValues,
}

/// One instance.
pub(crate) struct Instance<M: FmuModel> {
    pub(crate) version: Version,
    pub(crate) core: Core,
    /// `None` until the model is built from the parameters.
    pub(crate) model: Option<M>,
    pub(crate) resources: Option<PathBuf>,
    pub(crate) filter: Filter,
    pub(crate) log: CallLog,
    /// Texts handed to the host stay alive here until read again.
    pub(crate) texts: BTreeMap<usize, CString>,
    snapshots: BTreeMap<usize, FmuState<M>>,
    /// Numbers from before the step under way.
    backup: Vec<f64>,
}

impl<M: FmuModel> Instance<M> {
    pub(crate) fn new(version: Version, resources: Option<PathBuf>, filter: Filter) -> Self {
        let values = VariableValues::start(&M::description().table);
        Self {
            version,
            core: Core { phase: Phase::Instantiated, origin: 0.0, time: 0.0, stop: None, values },
            model: None,
            resources,
            filter,
            log: CallLog::default(),
            texts: BTreeMap::new(),
            snapshots: BTreeMap::new(),
            backup: Vec::new(),
        }
    }

    /// Refuses a call that the standard does not allow now.
    pub(crate) fn allow(&self, function: &str, phases: &[Phase]) -> Result<(), CallError> {
        let phase = self.core.phase;
        if phases.contains(&phase) {
            return Ok(());
        }
        let text = format!("{function}: not allowed while the instance is {}", phase.words());
        Err(if phase == Phase::Dead { CallError::Fatal(text) } else { CallError::Refused(text) })
    }

    /// Runs code of the model; a panic in it becomes a failure with its message.
    fn guarded<T>(what: &str, body: impl FnOnce() -> Result<T, CallError>) -> Result<T, CallError> {
        catch_unwind(AssertUnwindSafe(body)).unwrap_or_else(|payload| {
            Err(CallError::Failed(format!("{what}: internal error: {}", panic_text(&*payload))))
        })
    }

    /// Builds the model if the parameters changed since it was last built.
    fn ensure_model(&mut self) -> Result<(), CallError> {
        if self.model.is_some() {
            return Ok(());
        }
        let mut values = self.core.values.clone();
        self.model = Some(self.build(&mut values)?);
        self.core.values = values;
        Ok(())
    }

    /// A model of these parameters, and its initial outputs.
    fn build(&mut self, values: &mut VariableValues) -> Result<M, CallError> {
        let mut io = Io { values, resources: self.resources.as_deref(), log: &mut self.log };
        let model = Self::guarded("initialisation", || M::start(&mut io))?;
        check_outputs::<M>(io.values)?;
        Ok(model)
    }
}

/// A model that writes a value that is not finite has failed, whatever it returned.
fn check_outputs<M: FmuModel>(values: &VariableValues) -> Result<(), CallError> {
    if values.numbers.iter().all(|x| x.is_finite()) {
        return Ok(());
    }
    let variables = M::description().table.variables();
    let bad = variables.iter().zip(&values.numbers).find(|(_, x)| !x.is_finite());
    let name = bad.map_or("?", |(v, _)| v.name.as_str());
    Err(CallError::Failed(format!("the model computed a value that is not finite for '{name}'")))
}

/// The message of a panic, if it carried one.
pub(crate) fn panic_text(payload: &(dyn std::any::Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|s| (*s).to_owned());
    text.or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "panic without a message".to_owned())
}
