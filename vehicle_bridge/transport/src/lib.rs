//! Bytes to and from an LCM network, behind one trait, chosen by URL.
//!
//! | URL | implementation | why |
//! |---|---|---|
//! | `udpm://…` | Rust ([`Udpm`]) | liblcm's receiver reads past its buffer on one malformed datagram and takes the process down, and hands over torn messages when a fragment comes twice; this one does neither, at half the latency |
//! | `memq://`, `tcpq://…`, `file://…`, `mpudpm://…` | liblcm, through the `lcm` crate | the providers exist only there |
//! | `liblcm+udpm://…` | liblcm | to compare the two |
//!
//! [`Local`] is a network within one process.
//!
//! Messages are handed to [`Sink`]s on the receiving thread as they arrive. A slow loop puts an
//! [`Inbox`] there: it reads the newest state from [`Inbox::latest`] and every order from
//! [`Inbox::queue`], and never makes the network wait.
//!
//! LCM has no authentication: whoever can send to the group can drive the car. The default time to
//! live is 0, which does not leave the host; a real car gets a network of its own.

mod datagram;
mod dispatch;
mod error;
mod inbox;
#[cfg(feature = "liblcm")]
pub mod liblcm;
#[cfg(feature = "liblcm")]
mod liblcm_loaded;
mod local;
mod reassembly;
pub mod record;
mod statistics;
mod udpm;
mod url;

use std::net::SocketAddrV4;
use std::sync::Arc;

use lcm_types::{MonoTime, channels};

pub use dispatch::Sink;
pub use error::Error;
pub use inbox::{Inbox, Received};
pub use lcm_types::Arrival;
pub use local::Local;
pub use reassembly::{EXPIRY_NS, MAX_MESSAGE, MAX_PARTIAL};
pub use statistics::{MAX_SENDERS, SenderStatistics, Statistics};
pub use udpm::Udpm;
pub use url::{DEFAULT_URL, UdpmOptions, Url};

/// A message as it arrives, borrowed from the receiver's buffer.
#[derive(Debug, Clone, Copy)]
pub struct ReceivedMessage<'a> {
    /// Channel.
    pub channel: &'a str,
    /// The encoded message. Nothing in it has been checked.
    pub payload: &'a [u8],
    /// When the kernel received its last datagram; with liblcm, when liblcm handed it over.
    pub arrival: Arrival,
    /// Who sent it, where the implementation knows.
    pub sender: Option<SocketAddrV4>,
}

/// Which channels a sink gets.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Filter {
    /// Every channel. Not with liblcm: the `lcm` crate does not report the channel.
    All,
    /// The channels named.
    Only(Vec<String>),
}

impl Filter {
    /// The one channel named.
    #[must_use]
    pub fn channel(name: &str) -> Self {
        Self::Only(vec![name.to_owned()])
    }

    fn accepts(&self, channel: &str) -> bool {
        match self {
            Self::All => true,
            Self::Only(names) => names.iter().any(|name| name == channel),
        }
    }
}

/// A connection to an LCM network. All methods may be called from any thread.
pub trait Transport: Send + Sync {
    /// Sends `payload` on `channel`.
    ///
    /// # Errors
    /// [`Error::Channel`], [`Error::TooLarge`], and [`Error::Send`] if the system refuses it or the
    /// implementation's queue is full.
    fn publish(&self, channel: &str, payload: &[u8]) -> Result<(), Error>;

    /// Hands every message from now on that `filter` accepts to `sink`, on the receiving thread.
    ///
    /// # Errors
    /// [`Error::Channel`] for a name no message can have, [`Error::Unsupported`], [`Error::Closed`].
    fn subscribe(&self, filter: Filter, sink: Box<dyn Sink>) -> Result<(), Error>;

    /// What was sent, received and lost so far.
    fn statistics(&self) -> Statistics;

    /// Warnings for the user at the start: a receive buffer smaller than requested.
    fn warnings(&self) -> &[String];
}

/// Runs once on the receiving thread before it receives: to set its priority.
pub type ThreadStart = Box<dyn FnOnce() + Send>;

/// Connects to the network `url` names; see the [module](self) for which implementation it gets.
///
/// # Errors
/// [`Error::Url`], [`Error::Socket`] where the system refuses, [`Error::Unsupported`] for a provider
/// this build does not have, [`Error::Environment`] (liblcm only).
pub fn open(url: &str, start: Option<ThreadStart>) -> Result<Arc<dyn Transport>, Error> {
    let url = Url::parse(url)?;
    if url.is_udpm() {
        return Ok(Arc::new(Udpm::open(&url.udpm_options()?, start)?));
    }
    #[cfg(feature = "liblcm")]
    return Ok(Arc::new(liblcm::Liblcm::open(&url, start)?));
    #[cfg(not(feature = "liblcm"))]
    return Err(Error::Unsupported {
        what: format!("{url}: this program was built without the feature `liblcm`"),
    });
}

/// The time now, on both clocks.
#[must_use]
pub fn now() -> Arrival {
    use nix::time::ClockId;
    Arrival {
        utime: read_clock(ClockId::CLOCK_REALTIME) / 1000,
        mono: MonoTime::from_ns(read_clock(ClockId::CLOCK_MONOTONIC)),
    }
}

/// Nanoseconds of a clock; the two clocks used exist on every Linux, so no error is possible.
fn read_clock(clock: nix::time::ClockId) -> i64 {
    clock.now().map_or(0, |t| t.tv_sec() * 1_000_000_000 + t.tv_nsec())
}

fn check_channel(channel: &str) -> Result<(), Error> {
    if channels::is_valid(channel) {
        return Ok(());
    }
    Err(Error::Channel { found: channel.to_owned() })
}

fn check_filter(filter: &Filter) -> Result<(), Error> {
    match filter {
        Filter::All => Ok(()),
        Filter::Only(names) => names.iter().try_for_each(|name| check_channel(name)),
    }
}

fn check_size(payload: &[u8]) -> Result<(), Error> {
    if payload.len() <= MAX_MESSAGE {
        return Ok(());
    }
    Err(Error::TooLarge { found: payload.len() })
}
