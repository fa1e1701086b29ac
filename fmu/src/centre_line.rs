//! Which centre line a saved state is of.

use serde::{Deserialize, Serialize};
use vehicle_model::Track;

use crate::status::Fault;

/// What tells one centre line from another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CentreLine {
    fingerprint: u64,
    /// Length \[m\].
    length: f64,
}

impl CentreLine {
    pub(crate) fn of(track: &Track) -> Self {
        Self { fingerprint: track.fingerprint(), length: track.length() }
    }

    /// Refuses a state of another centre line.
    ///
    /// # Errors
    /// [`Fault::Refused`] with both lengths.
    pub(crate) fn check(&self, here: &Track) -> Result<(), Fault> {
        if *self == Self::of(here) {
            return Ok(());
        }
        Err(Fault::Refused(format!(
            "the state is of another centre line, {} m long; that of this instance, track '{}', is \
             {} m long (param.track)",
            self.length,
            here.name(),
            here.length()
        )))
    }
}
