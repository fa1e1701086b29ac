//! What goes on in the whole network, for people at a terminal and for scripts.
//!
//! [`Watch`] hears every message and keeps no time of its own; [`Watch::snapshot`] is what it knows
//! at a time, [`draw`] turns that into lines.

mod snapshot;
mod stream;
#[cfg(test)]
mod tests;
mod view;
mod watch;

pub use snapshot::{
    CarSeen, ChannelSeen, OrderAnswer, OrderSeen, ProgramSeen, Snapshot, StepSeen, TrackSeen,
};
pub use view::draw;
pub use watch::Watch;
