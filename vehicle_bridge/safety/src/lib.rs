//! The safety core between controller and car: a pure function of state, event and time.
//!
//! [`step`] knows no clock, no network and no memory but the [`Safety`] it is given; the host
//! passes events with their times and applies what each [`BridgeEvent::Tick`] answers. It does not
//! allocate. States and rules are in `docs/safety.md`.

mod check;
mod command;
mod controllers;
mod doubt;
mod hold;
mod on_order;
mod on_state;
mod order;
mod published;
mod rate;
mod rules;
mod step;
mod stop;
mod stop_reason;
#[cfg(test)]
mod tests;
mod types;

pub use check::decode;
pub use command::{DecodedCommand, PLAN, Reject};
pub use doubt::{DoubtFinding, DoubtLimitError, DoubtLimits, Reaction, Suspicion};
pub use order::{Denied, Order, OrderKind};
pub use rules::{Rules, Setup};
pub use step::{Safety, step};
pub use stop_reason::StopReason;
pub use types::{Answer, BridgeEvent, BridgeState, CommandCounts, InputSource, Output};
