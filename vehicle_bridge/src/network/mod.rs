//! The controller and the simulated car as programs on an LCM network.
//!
//! [`service`] answers each `CAR/STATE` with one `LMPC/CMD`; [`car`] is a simulated car that
//! publishes the one and obeys the other; [`bridge`] puts the safety core between the two.
//! Checks of what comes in are in [`guard`].
//! [`convert`] and [`telemetry`] alone know how messages and the controller's types correspond.

mod account;
pub mod blackbox;
pub mod bridge;
mod bridge_run;
pub mod car;
pub mod convert;
pub mod effort;
pub mod grant;
pub mod guard;
pub mod map_file;
pub mod mapped_car;
mod neighbours;
pub mod operator;
pub mod operator_client;
pub mod orders;
pub mod outlet;
pub mod pulse;
pub mod realtime;
pub mod record;
pub mod replay;
pub mod schedule;
pub mod service;
pub mod side;
pub mod store;
pub mod telemetry;
pub mod watchdog;
