//! Settings for what nobody planned: incidents and delay.

use serde::{Deserialize, Serialize};

/// Delay compensation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DelayConfig {
    /// Whole periods between a command and its effect; the state is predicted through the
    /// queued inputs. [0, 20]
    pub steps: usize,
}

/// What happens after a spin, an excursion, a standstill or a start askew.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RecoveryConfig {
    /// Whether the controller drives back to the line by itself. Without it a car that points the
    /// wrong way, or is far off, brakes until its host resets it.
    pub active: bool,
}
