//! Life signs, ten a second, from a thread of their own, and once a second the track.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use lcm_types::{Heartbeat, Track, channels};

use super::guard::Counts;
use super::outlet::{Identity, Outlet};
use crate::transport::Transport;
use crate::worker::Worker;

const INTERVAL: Duration = Duration::from_millis(100);
/// Life signs from one message of the track to the next. \[-\]
const TRACK_EVERY: u64 = 10;
/// Pages of memory on every system this runs on. \[MB\]
const PAGE_MB: f32 = 4096.0 / 1e6;

/// What a program says of itself.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Health {
    /// One of the states of [`Heartbeat`].
    pub state: i8,
    /// Messages received and refused.
    pub counts: Counts,
    /// The grant in force, 0 for none. \[-\]
    pub arm_token: i64,
    /// What a person should know.
    pub detail: String,
}

/// The sending thread; ends when dropped.
pub struct Pulse {
    health: Arc<Mutex<Health>>,
    _worker: Worker,
}

impl Pulse {
    /// Begins to send on `HB/<name>`, and `track`, if there is one, on `MAP/TRACK`.
    ///
    /// # Errors
    /// If the thread cannot be started.
    pub fn start(
        network: &Arc<dyn Transport>,
        identity: &Identity,
        name: &str,
        track: Option<Track>,
    ) -> std::io::Result<Self> {
        let health: Arc<Mutex<Health>> = Arc::default();
        let outlet = Outlet::new(network, identity, &format!("{}{name}", channels::HEARTBEAT));
        let track = track.map(|t| (Outlet::new(network, identity, channels::TRACK), t));
        let seen = Arc::clone(&health);
        let worker = Worker::start("lmpc-pulse", move |stop| beat(outlet, track, &seen, stop))?;
        Ok(Self { health, _worker: worker })
    }

    /// Changes what is said.
    pub fn update(&self, change: impl FnOnce(&mut Health)) {
        change(&mut self.health.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

fn beat(
    mut outlet: Outlet,
    mut track: Option<(Outlet, Track)>,
    health: &Mutex<Health>,
    stop: &AtomicBool,
) {
    let begun = Instant::now();
    let mut due = begun;
    for count in 0_u64.. {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        let Health { state, counts, arm_token, detail } =
            health.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let message = Heartbeat {
            h: outlet.header(),
            state,
            arm_token,
            uptime_s: begun.elapsed().as_secs_f64(),
            rss_mb: resident_mb("self"),
            rx_ok: counts.ok,
            rx_bad: counts.bad,
            rx_old: counts.old,
            rx_stale: counts.stale,
            rx_lost: counts.lost,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            detail,
            ..Heartbeat::default()
        };
        // A life sign that is lost is what its absence says.
        let _ = outlet.send(&message);
        if let Some((outlet, track)) = track.as_mut().filter(|_| count % TRACK_EVERY == 0) {
            track.h = outlet.header();
            // Who missed it has it in a second.
            let _ = outlet.send_sealed(track);
        }
        due += INTERVAL;
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
    }
}

/// Resident memory of a process, by its id; 0 where the system does not tell. \[MB\]
pub(crate) fn resident_mb(process: &str) -> f32 {
    let text = std::fs::read_to_string(format!("/proc/{process}/statm")).unwrap_or_default();
    let pages = text.split_whitespace().nth(1).and_then(|pages| pages.parse::<f32>().ok());
    pages.unwrap_or(0.0) * PAGE_MB
}
