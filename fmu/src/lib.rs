//! One model behind the FMI 2.0 and the FMI 3.0 co-simulation interfaces.
//!
//! A [`FmuModel`] names its variables in a [`VariableTable`] and knows how to start, step, save and load.
//! Everything else is here: the state machine, all checks, FMU states, the log, the C functions
//! of both versions ([`export_fmu!`]), the model descriptions and the packed file ([`pack`]).
//!
//! What every call promises: it returns a status, whatever the order of calls and whatever the
//! arguments; *error* never changes an output; a panic in a model becomes *error* with its
//! message. *Discard* is only for a step that a smaller one may replace. *Fatal* is only for an
//! instance whose own bookkeeping failed.
//!
//! | Status | Means | What the host may do next |
//! |---|---|---|
//! | ok | done | anything the standard allows |
//! | warning | done; read the message | the same |
//! | discard | step not taken, nothing changed | a smaller step |
//! | error, call refused | nothing changed | go on |
//! | error, model failed | outputs unchanged | reset, restore a state, read, free |
//! | fatal | instance lost | free |
// The same bits on every machine: no function of the platform's mathematical library.
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod bytes;
pub mod c;
mod checksum;
mod controller;
mod description;
mod documents;
mod export;
mod files;
mod inspect;
mod instance;
mod log;
mod model;
mod pack;
mod registry;
mod related;
mod schedule;
mod ship;
mod status;
mod system;
mod table;
pub mod unit;
mod values;
mod variable;
mod vehicle;
mod xml;

pub use crate::controller::{ControllerFmu, ControllerFmuState};
pub use bytes::{ByteReader, ByteWriter};
pub use description::{Description, Resource, Terminal, Version};
pub use inspect::{Inspection, VariableRow, inspect};
pub use log::{CATEGORIES, CallLog, LogMessage};
pub use model::{CommunicationStep, FmuModel, Io};
pub use pack::{Binary, PackError, Platform, pack, write_zip};
pub use schedule::TickSchedule;
pub use ship::{Libraries, models, ship};
pub use status::{CallError, FmiStatus};
pub use table::{Boolean, Integer, Real, Text, VariableTable};
pub use values::VariableValues;
pub use variable::{Role, Variable, VariableType};
pub use vehicle::{VehicleFmu, VehicleState};
