//! Heartbeats, ten a second, from a thread of their own, and once a second track and setup.

use std::fmt::{Display, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use lcm_types::{ArmToken, Heartbeat, Setup, Track, channels};

use hosting::memory::resident_mb;
use hosting::worker::Worker;
use protocol::publisher::{Identity, Publisher};
use protocol::stream_filter::StreamCounts;
use safety::StopReason;
use transport::Transport;
use transport::record::NetworkLog;

const INTERVAL: Duration = Duration::from_millis(100);
/// Heartbeats from one message of track and setup to the next. \[-\]
const PLACE_EVERY: u64 = 10;

/// State of a program, as its heartbeat reports it.
#[derive(Debug, Clone, Default)]
pub struct Health<D = String> {
    /// One of the states of [`Heartbeat`].
    pub state: i8,
    /// Messages received and refused.
    pub counts: StreamCounts,
    /// The grant in force, if any.
    pub arm_token: ArmToken,
    /// Why the bridge stopped the car last.
    pub stop_reason: StopReason,
    /// Laps the controller has learned from; `None` from a program without one. \[-\]
    pub laps_learned: Option<usize>,
    /// Attempts to save what was learned that failed. \[-\]
    pub save_failures: u64,
    /// The log behind the network; what it loses is in every heartbeat.
    pub log: Option<NetworkLog>,
    /// Text for people; formatted when it is sent.
    pub detail: D,
}

/// Where and with what a controller drives.
#[derive(Debug, Clone, Default)]
pub struct TrackAndSetup {
    /// The track, for `MAP/TRACK`.
    pub track: Track,
    /// The setup, for `LMPC/SETUP`.
    pub setup: Setup,
}

/// The sending thread; ends when dropped.
pub struct HeartbeatSender<D = String> {
    health: Arc<Mutex<Health<D>>>,
    _worker: Worker,
}

impl<D: Display + Clone + Default + Send + 'static> HeartbeatSender<D> {
    /// Begins to send on `HB/<name>`, and `driven`, if there is one, on `MAP/TRACK` and `LMPC/SETUP`.
    ///
    /// # Errors
    /// If the thread cannot be started.
    pub fn start(
        network: &Arc<dyn Transport>,
        identity: &Identity,
        name: &str,
        driven: Option<TrackAndSetup>,
    ) -> std::io::Result<Self> {
        let health: Arc<Mutex<Health<D>>> = Arc::default();
        let publisher =
            Publisher::new(network, identity, &format!("{}{name}", channels::HEARTBEAT));
        let driven = driven.map(|driven| {
            let publisher = |channel: &str| Publisher::new(network, identity, channel);
            (publisher(channels::TRACK), publisher(channels::SETUP), driven)
        });
        let seen = Arc::clone(&health);
        let worker =
            Worker::start("lmpc-heartbeat", move |stop| beat(publisher, driven, &seen, stop))?;
        Ok(Self { health, _worker: worker })
    }

    /// Changes what the next heartbeat reports.
    pub fn update(&self, change: impl FnOnce(&mut Health<D>)) {
        change(&mut self.health.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

fn beat<D: Display + Clone>(
    mut publisher: Publisher,
    mut driven: Option<(Publisher, Publisher, TrackAndSetup)>,
    health: &Mutex<Health<D>>,
    stop: &AtomicBool,
) {
    let version = env!("CARGO_PKG_VERSION").to_owned();
    let mut message = Heartbeat { version, ..Heartbeat::default() };
    let begun = Instant::now();
    let mut due = begun;
    for count in 0_u64.. {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        let seen = health.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let mut words = std::mem::take(&mut message.detail);
        words.clear();
        // Writing to a String cannot fail.
        let _ = write!(words, "{}", seen.detail);
        if let Some(complaint) = seen.log.as_ref().and_then(NetworkLog::complaint) {
            let _ = write!(words, "{}{complaint}", if words.is_empty() { "" } else { "; " });
        }
        let (stop_reason, stop_doubt) = seen.stop_reason.codes();
        message = Heartbeat {
            h: publisher.header(),
            state: seen.state,
            stop_reason,
            stop_doubt,
            arm_token: seen.arm_token.get(),
            uptime_s: begun.elapsed().as_secs_f64(),
            rss_mb: resident_mb("self"),
            rx_ok: seen.counts.ok,
            rx_bad: seen.counts.bad,
            rx_wrong_type: seen.counts.wrong_type,
            rx_old: seen.counts.old,
            rx_stale: seen.counts.stale,
            rx_lost: seen.counts.lost,
            laps_learned: seen.laps_learned.and_then(|laps| laps.try_into().ok()).unwrap_or(-1),
            save_failures: signed(seen.save_failures),
            log_dropped: signed(seen.log.as_ref().map_or(0, NetworkLog::dropped)),
            detail: words,
            ..message
        };
        // Errors are ignored: the receiver detects a missing heartbeat itself.
        let _ = publisher.send(&message);
        if let Some((tracks, setups, driven)) = driven.as_mut().filter(|_| count % PLACE_EVERY == 0)
        {
            (driven.track.h, driven.setup.h) = (tracks.header(), setups.header());
            // Sent again in a second.
            let _ = tracks.send_sealed(&driven.track);
            let _ = setups.send_sealed(&driven.setup);
        }
        due += INTERVAL;
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
    }
}

fn signed(count: u64) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use std::fmt;
    use std::sync::atomic::AtomicUsize;

    use lcm_types::Message as _;

    use super::*;
    use transport::{Error, Filter, Sink, Statistics};

    /// Keeps what is said.
    #[derive(Default)]
    struct Ear(Mutex<Vec<Heartbeat>>);

    impl Transport for Ear {
        fn publish(&self, _: &str, payload: &[u8]) -> Result<(), Error> {
            self.0.lock().unwrap().push(Heartbeat::decode(payload).unwrap());
            Ok(())
        }

        fn subscribe(&self, _: Filter, _: Box<dyn Sink>) -> Result<(), Error> {
            Ok(())
        }

        fn statistics(&self) -> Statistics {
            Statistics::default()
        }

        fn warnings(&self) -> &[String] {
            &[]
        }
    }

    /// Counts how often it is put into words.
    #[derive(Clone, Default)]
    struct Words(u32, Arc<AtomicUsize>);

    impl Display for Words {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            self.1.fetch_add(1, Ordering::Relaxed);
            write!(f, "tick {}", self.0)
        }
    }

    #[test]
    fn words_are_made_for_what_is_sent_and_not_at_every_tick() {
        let (ear, made) = (Arc::new(Ear::default()), Arc::new(AtomicUsize::new(0)));
        let network: Arc<dyn Transport> = Arc::<Ear>::clone(&ear);
        let heartbeat =
            HeartbeatSender::start(&network, &Identity::new("test"), "test", None).unwrap();
        for tick in (0..40).map(|n| 1000 - n) {
            heartbeat.update(|health| health.detail = Words(tick, Arc::clone(&made)));
            std::thread::sleep(Duration::from_millis(10));
        }
        drop(heartbeat);
        let said: Vec<_> = ear.0.lock().unwrap().drain(..).map(|beat| beat.detail).collect();
        // The first heartbeat may come before the first tick.
        let mut made = made.load(Ordering::Relaxed);
        made += usize::from(said.first().is_some_and(|first| first == "tick 0"));
        assert!(said.len() >= 3, "{said:?}");
        assert_eq!(made, said.len(), "{said:?}");
        let ticks: Vec<u32> = said.iter().skip(1).map(|said| said[5..].parse().unwrap()).collect();
        assert!(ticks.windows(2).all(|pair| pair[0] > pair[1]), "each says its own: {said:?}");
    }
}
