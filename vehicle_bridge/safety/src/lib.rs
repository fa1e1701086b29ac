//! The safety core between controller and car: a pure function of state, event and time.
//!
//! [`step`] knows no clock, no network and no memory but the [`Safety`] it is given; the host
//! tells it what came and when, and applies what each [`Event::Tick`] answers. It does not
//! allocate. States and rules are in `docs/safety.md`.

mod check;
mod command;
mod controllers;
mod doubt;
mod lapse;
mod obey;
mod order;
mod published;
mod rate;
mod rules;
mod step;
mod stop;
#[cfg(test)]
mod tests;
mod types;

pub use check::decode;
pub use command::{Offer, PLAN, Reject};
pub use doubt::{DoubtLimits, Finding, Reaction, Suspicion};
pub use lapse::Lapse;
pub use order::{Denied, Order, OrderKind};
pub use rules::{Rules, Setup};
pub use step::{Safety, step};
pub use types::{Answer, Counts, Event, Output, Phase, Source};
