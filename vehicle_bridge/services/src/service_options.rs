//! How the service is to run.

use super::deadline_monitor::Overrun;
use auth::Seal;
use transport::record::NetworkLog;

/// How the service is to run.
#[derive(Debug, Clone)]
pub struct ServiceOptions {
    /// Commands go to `LMPC/CMD_DRY` and are never for the car.
    pub dry_run: bool,
    /// Wait for the operator's `START`.
    pub wait_for_start: bool,
    /// How long a command may be used; also the oldest state believed. \[s\]
    pub valid_for: f64,
    /// What a person should know of this start; goes into every heartbeat.
    pub notes: Vec<String>,
    /// What the bridge compares before it arms this controller.
    pub setup: lcm_types::Setup,
    /// The log behind the network; what it loses is in every heartbeat too.
    pub log: Option<NetworkLog>,
    /// The key before the network; what it refused is in every heartbeat too.
    pub seal: Option<Seal>,
    /// For the bench: steps that take longer.
    pub overrun: Option<Overrun>,
}
