//! What goes on in a whole network, for people and for scripts.
//!
//! [`Seen::read`] decodes a message by its channel. [`Watch`] receives every message and keeps no time
//! of its own; [`Watch::snapshot`] is what it knows at a time.

mod estimates;
mod seen;
mod snapshot;
mod stream;
mod watch;

pub use estimates::{Estimates, action_name, reason_name};
pub use seen::Seen;
pub use snapshot::{
    CarSeen, ChannelSeen, OrderAnswer, OrderSeen, ProgramSeen, Snapshot, StepSeen, TrackSeen,
};
pub use watch::Watch;
