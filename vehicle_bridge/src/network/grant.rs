//! What the bridge grants the controller, as its life signs say.

use std::sync::Arc;
use std::time::{Duration, Instant};

use lcm_types::{Heartbeat, Message as _, channels};

use crate::transport::{Error, Filter, Inbox, Transport};

/// A bridge silent for longer is none.
const SILENCE: Duration = Duration::from_secs(1);

/// The grant last heard.
pub struct Grant {
    inbox: Inbox,
    heard: Option<(Instant, i64, i8)>,
}

impl Grant {
    /// Begins to listen.
    ///
    /// # Errors
    /// If the network refuses the subscription.
    pub fn listen(network: &Arc<dyn Transport>) -> Result<Self, Error> {
        let inbox = Inbox::latest();
        let channel = format!("{}bridge", channels::HEARTBEAT);
        network.subscribe(Filter::channel(&channel), inbox.sink())?;
        Ok(Self { inbox, heard: None })
    }

    /// Takes in what came.
    pub fn update(&mut self) {
        if let Some(received) = self.inbox.take() {
            if let Ok(beat) = Heartbeat::decode(&received.payload) {
                self.heard = Some((Instant::now(), beat.arm_token, beat.state));
            }
            self.inbox.recycle(received);
        }
        self.heard = self.heard.filter(|(when, ..)| when.elapsed() < SILENCE);
    }

    /// The token to echo; 0 if no bridge is heard. \[-\]
    #[must_use]
    pub fn token(&self) -> i64 {
        self.heard.map_or(0, |(_, token, _)| token)
    }

    /// Whether commands reach the car: a bridge that runs, or none at all.
    #[must_use]
    pub fn lets_drive(&self) -> bool {
        self.heard.is_none_or(|(.., state)| state == Heartbeat::RUNNING)
    }
}
