//! The controller and the simulated car as programs on an LCM network.
//!
//! [`service`] answers each `CAR/STATE` with one `LMPC/CMD`; [`car`] is a simulated car that
//! publishes the one and obeys the other; [`bridge`] puts the safety core between the two.
//! Messages and the checks of what arrives are in the crate `protocol`.

mod account;
pub mod blackbox;
pub mod bridge;
mod bridge_run;
pub mod car;
mod car_clock;
pub mod deadline_monitor;
mod descriptions;
pub mod grant;
pub mod heartbeat;
pub mod map_file;
pub mod mapped_car;
mod neighbours;
pub mod operator;
pub mod operator_client;
pub mod replay;
pub mod schedule;
pub mod service;
mod service_options;
pub mod side;
pub mod store;
pub mod watchdog;
