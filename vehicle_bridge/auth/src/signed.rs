//! A network on which only holders of a key are heard.

use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use lcm_types::signature::{self, Signature};
use lcm_types::{Checked as _, Header, Hello, Message as _, OperatorCommand, channels};

use super::key::{Key, KeyError, random};
use super::peers::Peers;
use hosting::worker::Worker;
use transport::{Error, Filter, ReceivedMessage, Sink, Statistics, Transport};

/// Time between two greetings.
const INTERVAL: Duration = Duration::from_millis(100);
/// Least time between two greetings: replayed greetings of strangers cause no storm.
const LEAST: Duration = Duration::from_millis(5);

/// Messages that were not let in, by what was wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Refusals {
    /// Without a signature. \[-\]
    pub unsigned: u64,
    /// With a code that is not the key's, for this channel. \[-\]
    pub forged: u64,
    /// Of a start that has not proved that it runs now: recorded earlier. \[-\]
    pub stranger: u64,
    /// Seen before, or older than one seen before. \[-\]
    pub replayed: u64,
}

impl fmt::Display for Refusals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { unsigned, forged, stranger, replayed } = self;
        write!(
            f,
            "refused without a valid signature: {unsigned} unsigned, {forged} forged, {stranger} of \
             senders not met, {replayed} replayed"
        )
    }
}

#[derive(Default)]
struct Counts([AtomicU64; 4]);

/// What one program knows of the key and of the others.
struct Shared {
    network: Arc<dyn Transport>,
    key: Key,
    start: i64,
    seq: AtomicI64,
    peers: Mutex<Peers>,
    /// Somebody new was met; the greeting thread waits for it.
    met: (Mutex<bool>, Condvar),
    counts: Counts,
}

/// The network; drop it to end its greetings.
pub struct Signed {
    shared: Arc<Shared>,
    _worker: Worker,
}

/// What heartbeats say of a [`Signed`] network.
#[derive(Clone)]
pub struct Seal(Arc<Shared>);

impl fmt::Debug for Seal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Seal({})", self.0.key.id())
    }
}

impl Seal {
    /// Messages not let in so far.
    #[must_use]
    pub fn refusals(&self) -> Refusals {
        let [unsigned, forged, stranger, replayed] =
            [0, 1, 2, 3].map(|i| self.0.counts.0[i].load(Ordering::Relaxed));
        Refusals { unsigned, forged, stranger, replayed }
    }

    /// In words; nothing as long as all was let in.
    #[must_use]
    pub fn complaint(&self) -> Option<String> {
        let refusals = self.refusals();
        (refusals != Refusals::default()).then(|| refusals.to_string())
    }
}

impl Signed {
    /// Before `network`, with `key`.
    ///
    /// # Errors
    /// If there are no random numbers, the network refuses the subscription, or the greeting thread
    /// cannot be started.
    pub fn new(network: Arc<dyn Transport>, key: Key) -> anyhow::Result<Self> {
        let start = number()?;
        let peers = Peers::new(start, [number()?, number()?], transport::now().mono.as_ns());
        let (seq, peers) = (AtomicI64::new(0), Mutex::new(peers));
        let met = (Mutex::new(true), Condvar::new());
        let counts = Counts::default();
        let shared = Arc::new(Shared { network, key, start, seq, peers, met, counts });
        let ear = Arc::clone(&shared);
        let hear = move |message: &ReceivedMessage<'_>| ear.greeted(message);
        shared.network.subscribe(Filter::channel(channels::HELLO), Box::new(hear))?;
        let mouth = Arc::clone(&shared);
        let worker = Worker::start("lmpc-hello", move |stop| mouth.greet(stop))?;
        Ok(Self { shared, _worker: worker })
    }

    /// For heartbeats.
    #[must_use]
    pub fn seal(&self) -> Seal {
        Seal(Arc::clone(&self.shared))
    }
}

/// Channels of ours: signed. A car's own messages are its driver's.
fn is_ours(channel: &str) -> bool {
    use channels::{ACTUATION, COMMAND, COMMAND_DRY, HEARTBEAT, HELLO, LAP, OPERATOR};
    use channels::{OPERATOR_ACK, SETUP, STATE, TELEMETRY, TRACK};
    let ours = [
        ACTUATION,
        COMMAND,
        COMMAND_DRY,
        HELLO,
        LAP,
        OPERATOR,
        OPERATOR_ACK,
        SETUP,
        STATE,
        TELEMETRY,
        TRACK,
    ];
    channel.starts_with(HEARTBEAT) || ours.contains(&channel)
}

/// An emergency stop is obeyed whoever sends it.
fn is_estop(channel: &str, message: &[u8]) -> bool {
    channel == channels::OPERATOR
        && OperatorCommand::open(message).is_ok_and(|m| m.command == OperatorCommand::ESTOP)
}

fn number() -> Result<i64, KeyError> {
    random().map(i64::from_be_bytes)
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    /// Signs and sends.
    fn publish(&self, channel: &str, message: &[u8]) -> Result<(), Error> {
        let (start, seq) = (self.start, self.seq.fetch_add(1, Ordering::Relaxed));
        let tag = self.key.tag(channel, start, seq, message);
        let mut bytes = Vec::with_capacity(message.len() + signature::SIZE);
        bytes.extend_from_slice(message);
        Signature { start, seq, tag }.append_to(&mut bytes);
        self.network.publish(channel, &bytes)
    }

    /// A greeting on the network.
    fn greeted(&self, message: &ReceivedMessage<'_>) {
        let (payload, Some(signature)) = signature::split(message.payload) else { return };
        let Signature { start, seq, tag } = signature;
        if start == self.start || !self.key.holds(message.channel, (start, seq), payload, &tag) {
            return;
        }
        let Ok(hello) = Hello::decode(payload) else { return };
        let now_ns = transport::now().mono.as_ns();
        if lock(&self.peers).greet(&hello, (start, seq), now_ns) {
            *lock(&self.met.0) = true;
            self.met.1.notify_one();
        }
    }

    /// Greets until `stop` is set.
    fn greet(&self, stop: &AtomicBool) {
        let mut buffer = Vec::new();
        while !stop.load(Ordering::Relaxed) {
            let now = transport::now();
            let mut hello = {
                let mut peers = lock(&self.peers);
                if peers.wants_challenge(now.mono.as_ns())
                    // Without random numbers the old challenge stays, and nobody new is believed.
                    && let Ok(challenge) = number()
                {
                    peers.challenge(challenge, now.mono.as_ns());
                }
                peers.hello(now.mono.as_ns())
            };
            let (utime, mono_ns) = (now.utime, now.mono.as_ns());
            hello.h = Header { utime, mono_ns, boot_id: self.start, ..Header::default() };
            if hello.encode_into(&mut buffer).is_ok() {
                // The next greeting follows soon.
                let _ = self.publish(channels::HELLO, &buffer);
            }
            std::thread::sleep(LEAST);
            let met = lock(&self.met.0);
            let waited = self.met.1.wait_timeout_while(met, INTERVAL - LEAST, |met| !*met);
            *waited.unwrap_or_else(PoisonError::into_inner).0 = false;
        }
    }

    fn refuse(&self, what: usize) {
        self.counts.0[what].fetch_add(1, Ordering::Relaxed);
    }
}

impl Transport for Signed {
    fn publish(&self, channel: &str, payload: &[u8]) -> Result<(), Error> {
        if is_ours(channel) {
            return self.shared.publish(channel, payload);
        }
        self.shared.network.publish(channel, payload)
    }

    fn subscribe(&self, filter: Filter, sink: Box<dyn Sink>) -> Result<(), Error> {
        let gate = Gate { shared: Arc::clone(&self.shared), sink, seen: Vec::new() };
        self.shared.network.subscribe(filter, Box::new(gate))
    }

    fn statistics(&self) -> Statistics {
        self.shared.network.statistics()
    }

    fn warnings(&self) -> &[String] {
        self.shared.network.warnings()
    }
}

/// The last message of a start on a channel.
struct Seen {
    start: i64,
    channel: String,
    seq: i64,
}

/// Lets in what holds, for one subscription.
struct Gate {
    shared: Arc<Shared>,
    sink: Box<dyn Sink>,
    seen: Vec<Seen>,
}

impl Gate {
    /// Why a message is refused, as its place in the counts; `None` in silence.
    fn check(
        &mut self,
        channel: &str,
        payload: &[u8],
        signature: Option<Signature>,
    ) -> Result<(), Option<usize>> {
        let Signature { start, seq, tag } = signature.ok_or(Some(0_usize))?;
        if !self.shared.key.holds(channel, (start, seq), payload, &tag) {
            return Err(Some(1));
        }
        if start == self.shared.start {
            return Err(None); // our own, come back
        }
        let now_ns = transport::now().mono.as_ns();
        let peers = lock(&self.shared.peers);
        if !peers.believes((start, seq), now_ns) {
            return Err(Some(2));
        }
        let mut seen = self.seen.iter_mut();
        match seen.find(|seen| seen.start == start && seen.channel == channel) {
            Some(seen) if seq <= seen.seq => return Err(Some(3)),
            Some(seen) => seen.seq = seq,
            None => {
                // Whoever is not believed any more has to prove itself by a new answer first.
                self.seen.retain(|seen| peers.knows(seen.start, now_ns));
                self.seen.push(Seen { start, channel: channel.to_owned(), seq });
            }
        }
        Ok(())
    }
}

impl Sink for Gate {
    fn deliver(&mut self, message: &ReceivedMessage<'_>) {
        let ReceivedMessage { channel, payload, .. } = *message;
        if !is_ours(channel) {
            return self.sink.deliver(message);
        }
        let (payload, signature) = signature::split(payload);
        let message = ReceivedMessage { payload, ..*message };
        match self.check(channel, payload, signature) {
            Ok(()) => self.sink.deliver(&message),
            Err(_) if is_estop(channel, payload) => self.sink.deliver(&message),
            Err(what) => what.into_iter().for_each(|what| self.shared.refuse(what)),
        }
    }
}
