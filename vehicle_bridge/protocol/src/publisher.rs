//! Publishing with a header: sender, sequence number and time.

use std::fs::File;
use std::io::Read as _;
use std::sync::Arc;

use lcm_types::{BootId, Checked, Header, Message, SeqNumber};

use transport::Transport;

/// Who sends: one for each start of a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity {
    /// Random, never 0: a change is a restart.
    pub boot_id: BootId,
    /// `program@host`.
    pub sender: String,
}

impl Identity {
    /// Of the program `name`, started now.
    #[must_use]
    pub fn new(name: &str) -> Self {
        let host = nix::unistd::gethostname()
            .map_or_else(|_| "unknown".to_owned(), |host| host.to_string_lossy().into_owned());
        Self { boot_id: BootId::new(random().max(1)), sender: format!("{name}@{host}") }
    }
}

/// A random positive number; without the system's source, one that two starts hardly share.
#[must_use]
pub fn random() -> i64 {
    let mut bytes = [0; 8];
    let read = File::open("/dev/urandom").and_then(|mut source| source.read_exact(&mut bytes));
    let number = match read {
        Ok(()) => i64::from_le_bytes(bytes),
        Err(_) => transport::now().utime ^ i64::from(std::process::id()).rotate_left(40),
    };
    number & i64::MAX
}

/// One channel to publish on. Numbers start at 0 and grow by one.
pub struct Publisher {
    network: Arc<dyn Transport>,
    identity: Identity,
    channel: String,
    seq: SeqNumber,
    bytes: Vec<u8>,
}

impl Publisher {
    /// To `channel`.
    #[must_use]
    pub fn new(network: &Arc<dyn Transport>, identity: &Identity, channel: &str) -> Self {
        Self {
            network: Arc::clone(network),
            identity: identity.clone(),
            channel: channel.to_owned(),
            seq: SeqNumber::default(),
            bytes: Vec::new(),
        }
    }

    /// The header of the next message, sent now.
    #[must_use]
    pub fn header(&self) -> Header {
        let now = transport::now();
        Header {
            utime: now.utime,
            mono_ns: now.mono.as_ns(),
            seq: self.seq.get(),
            boot_id: self.identity.boot_id.get(),
            sender: self.identity.sender.clone(),
        }
    }

    /// Sends a message that ends with a checksum.
    ///
    /// # Errors
    /// If it cannot be encoded, or the network refuses it; its number is then used up.
    pub fn send_sealed(&mut self, message: &impl Checked) -> anyhow::Result<()> {
        self.seq = self.seq.next();
        message.seal_into(&mut self.bytes)?;
        Ok(self.network.publish(&self.channel, &self.bytes)?)
    }

    /// Sends a message without a checksum.
    ///
    /// # Errors
    /// As [`Publisher::send_sealed`].
    pub fn send(&mut self, message: &impl Message) -> anyhow::Result<()> {
        self.seq = self.seq.next();
        message.encode_into(&mut self.bytes)?;
        Ok(self.network.publish(&self.channel, &self.bytes)?)
    }
}
