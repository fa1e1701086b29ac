//! The bridge that a controller works for, and its arm token, by the bridge's heartbeats.

use std::sync::Arc;
use std::time::{Duration, Instant};

use lcm_types::{ArmToken, BootId, Heartbeat, Message as _, channels};

use transport::{Error, Filter, Inbox, Transport};

/// A bridge not heard for this long is considered gone.
const SILENCE: Duration = Duration::from_secs(1);
/// Heartbeats that may wait. \[-\]
const WAITING: usize = 64;

/// A bridge as last heard.
#[derive(Debug, Clone, PartialEq)]
struct HeardBridge {
    heard: Instant,
    boot_id: BootId,
    sender: String,
    token: ArmToken,
    state: i8,
}

/// The bridge heard first, as long as it is heard.
pub struct Grant {
    inbox: Inbox,
    bridge: Option<HeardBridge>,
    other: Option<HeardBridge>,
}

impl Grant {
    /// Begins to listen.
    ///
    /// # Errors
    /// If the network refuses the subscription.
    pub fn listen(network: &Arc<dyn Transport>) -> Result<Self, Error> {
        let inbox = Inbox::queue(WAITING);
        let channel = format!("{}bridge", channels::HEARTBEAT);
        network.subscribe(Filter::channel(&channel), inbox.sink())?;
        Ok(Self { inbox, bridge: None, other: None })
    }

    /// Takes in what came.
    pub fn update(&mut self) {
        let is_heard = |bridge: &HeardBridge| bridge.heard.elapsed() < SILENCE;
        for _ in 0..WAITING {
            let Some(received) = self.inbox.take() else { break };
            if let Ok(beat) = Heartbeat::decode(&received.payload) {
                let (token, state) = (ArmToken::new(beat.arm_token), beat.state);
                let (boot_id, sender) = (beat.h.sender_start(), beat.h.sender);
                let bridge = HeardBridge { heard: Instant::now(), boot_id, sender, token, state };
                self.bridge = self.bridge.take().filter(is_heard);
                let same = self.bridge.as_ref().is_none_or(|known| known.boot_id == boot_id);
                *(if same { &mut self.bridge } else { &mut self.other }) = Some(bridge);
            }
            self.inbox.recycle(received);
        }
        self.bridge = self.bridge.take().filter(is_heard);
        self.other = self.other.take().filter(is_heard);
    }

    /// The token to echo, if a bridge is heard.
    #[must_use]
    pub fn token(&self) -> ArmToken {
        self.bridge.as_ref().map_or(ArmToken::NONE, |bridge| bridge.token)
    }

    /// Whether commands reach the car: a bridge that runs, or none at all.
    #[must_use]
    pub fn lets_drive(&self) -> bool {
        self.bridge.as_ref().is_none_or(|bridge| bridge.state == Heartbeat::RUNNING)
    }

    /// Boot id of the bridge, whose states alone are answered.
    #[must_use]
    pub fn bridge(&self) -> Option<BootId> {
        self.bridge.as_ref().map(|bridge| bridge.boot_id)
    }

    /// What is wrong: another bridge on this network.
    #[must_use]
    pub fn complaint(&self) -> Option<String> {
        let (bridge, other) = (self.bridge.as_ref()?, self.other.as_ref()?);
        Some(format!(
            "two bridges are on this network: {} (boot id {}), which is obeyed, and {} (boot id {})",
            bridge.sender, bridge.boot_id, other.sender, other.boot_id
        ))
    }
}
