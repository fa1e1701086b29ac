//! Why the car is being stopped.

use super::doubt::Suspicion;

/// What made the core leave RUNNING or ARMED.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, thiserror::Error)]
pub enum StopReason {
    /// Nothing.
    #[default]
    #[error("")]
    None,
    /// No valid command in time.
    #[error("no valid command in time")]
    Commands,
    /// The last command's validity ended.
    #[error("the last command's validity ended")]
    Validity,
    /// No valid state in time.
    #[error("no valid state in time")]
    States,
    /// The bridge itself did not run.
    #[error("the bridge itself stood still")]
    Gap,
    /// The dead man's switch was released, or its holder fell silent.
    #[error("dead man's switch released")]
    Deadman,
    /// The controller asked to stop.
    #[error("the controller asked to stop")]
    Controller,
    /// The controller exceeded the rate limit.
    #[error("the controller sends too much")]
    Flood,
    /// The controller's heartbeats ended.
    #[error("no heartbeat of the controller")]
    Heartbeat,
    /// The operator.
    #[error("the operator's order")]
    Operator,
    /// The state or an actuator is doubted.
    #[error("{0}")]
    Doubt(Suspicion),
    /// The bridge is being ended.
    #[error("the bridge is being ended")]
    End,
    /// The car failed.
    #[error("the car failed")]
    Car,
}
