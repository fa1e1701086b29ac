//! Faults of a bench file.

use serde::{Deserialize, Serialize};

pub use super::fault_names::{BenchOrder, EndSignal, Field, Forged, Token};

/// A fault: what is done, where, from when, for how long.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Fault {
    /// Seconds after the scenario's `when`. \[s\]
    #[serde(default)]
    pub at_s: f64,
    /// Duration; absent: to the end of the run. \[s\]
    pub for_s: Option<f64>,
    /// Channel whose messages it acts on; absent: all.
    pub channel: Option<String>,
    /// Share of the messages it acts on, drawn by the seed. \[-\]
    #[serde(default = "all")]
    pub share: f64,
    /// On the simulated car itself, started with `--bench-car {dir}/car-faults.json`: fields of a
    /// state are its sensors, before the bridge sees them, `accel` and `steer` its actuators, behind
    /// the bridge's limiter.
    #[serde(default)]
    pub car: bool,
    /// What is done.
    pub action: FaultKind,
}

/// What a fault does.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FaultKind {
    /// Messages are lost; with `first`, only that many.
    Drop {
        /// Most messages lost; absent: all. \[-\]
        first: Option<u32>,
    },
    /// Messages are late; on the car, its actuators are, without jitter.
    Delay {
        /// By this. \[ms\]
        ms: f64,
        /// And by up to this more, drawn for each. \[ms\]
        #[serde(default)]
        jitter_ms: f64,
    },
    /// Each message comes so many times more.
    Duplicate {
        /// Further copies. \[-\]
        copies: u32,
    },
    /// Each pair of messages changes places.
    Swap {},
    /// After each message the last `count` come again.
    Replay {
        /// Old messages. \[-\]
        count: u32,
    },
    /// Bits flip.
    Corrupt {
        /// Bits in each message. \[-\]
        bits: u32,
    },
    /// With each message come junk, copies with flipped bits, cut copies, channels without end,
    /// sizes of 4 GiB and forged fragments.
    Junk {
        /// Datagrams with each message. \[-\]
        count: u32,
    },
    /// Messages of which one fragment is missing.
    Fragments {
        /// How many. \[-\]
        count: u32,
        /// Size each claims. \[B\]
        bytes: u32,
    },
    /// Messages on the fault's channel that mean nothing.
    Storm {
        /// Rate. \[1/s\]
        rate_hz: f64,
        /// Size. \[B\]
        bytes: usize,
    },
    /// With each message comes one of the datagrams no sender makes, in turn.
    Malformed {},
    /// Another sender of well-formed commands with a start, numbers and checksums of its own.
    SecondController {
        /// Rate. \[1/s\]
        rate_hz: f64,
        /// The grant it claims.
        #[serde(default)]
        token: Token,
    },
    /// Well-formed messages of somebody who has no key, with what was sniffed.
    Forge {
        /// Which.
        message: Forged,
        /// Rate. \[1/s\]
        rate_hz: f64,
    },
    /// Well-formed commands in a storm.
    CommandStorm {
        /// Rate. \[1/s\]
        rate_hz: f64,
        /// Senders without a grant that take turns; 0: the source's own last command again.
        #[serde(default)]
        senders: u32,
    },
    /// Contents stay as they were while stamps and numbers go on.
    Freeze {},
    /// Time stamps of the sender's monotonic clock are older.
    Stale {
        /// By this. \[ms\]
        ms: f64,
    },
    /// The sender's wall clock jumps forth and back.
    WallClock {
        /// By this. \[s\]
        jump_s: f64,
    },
    /// A field becomes not a number.
    Nan {
        /// Which.
        field: Field,
    },
    /// A field becomes this.
    Set {
        /// Which.
        field: Field,
        /// In the field's unit.
        value: f64,
    },
    /// A field is off by this.
    Bias {
        /// Which.
        field: Field,
        /// In the field's unit.
        value: f64,
    },
    /// A field has normal noise added.
    Noise {
        /// Which.
        field: Field,
        /// Standard deviation, in the field's unit.
        sigma: f64,
    },
    /// A field drifts from its value, from the fault's beginning on.
    Ramp {
        /// Which.
        field: Field,
        /// In the field's unit a second.
        per_s: f64,
    },
    /// A field wanders off at random.
    RandomWalk {
        /// Which.
        field: Field,
        /// Standard deviation after one second, in the field's unit.
        sigma: f64,
    },
    /// A field is multiplied.
    Scale {
        /// Which.
        field: Field,
        /// By this. \[-\]
        factor: f64,
    },
    /// A field stays as it was, while stamps, numbers and the other fields go on.
    Stuck {
        /// Which.
        field: Field,
    },
    /// A field follows slowly, as a first-order lag.
    Lag {
        /// Which.
        field: Field,
        /// Time constant. \[s\]
        seconds: f64,
    },
    /// Other grip of the simulated car's road.
    Grip {
        /// Factor on the friction of the front axle. \[-\]
        #[serde(default = "all")]
        front: f64,
        /// Factor on the friction of the rear axle. \[-\]
        #[serde(default = "all")]
        rear: f64,
    },
    /// Every n-th message alone goes through.
    Every {
        /// n. \[-\]
        n: u32,
    },
    /// The sender's clocks run at another rate, from the fault's beginning on.
    ClockDrift {
        /// Faster by this. \[us/s\]
        ppm: f64,
    },
    /// A command may be used for this long.
    Ttl {
        /// Time. \[ms\]
        ms: f64,
    },
    /// The message type's fingerprint is another one, as of an old version.
    Fingerprint {},
    /// The reference driver starts again without a gap: other boot id, numbers from 0, no grant.
    SourceRestart {},
    /// The reference driver is silent.
    SourceSilent {},
    /// SIGKILL.
    Kill {
        /// Which.
        process: String,
    },
    /// A signal at which a program ends by itself.
    Interrupt {
        /// Which.
        process: String,
        /// The signal.
        #[serde(default)]
        signal: EndSignal,
    },
    /// SIGSTOP; SIGCONT at the fault's end.
    Stop {
        /// Which.
        process: String,
    },
    /// SIGKILL, and a new start at once.
    Restart {
        /// Which.
        process: String,
    },
    /// The dead man's switch is let go.
    DeadmanReleased {},
    /// Who holds the dead man's switch is not heard any more.
    DeadmanSilent {},
    /// The operator arms and starts again, as before the faults.
    Rearm {},
    /// The network interface is down; the run gets a network of its own.
    NetworkDown {},
    /// The file system of `disk_mb`, `{dir}/disk`, is full.
    FillDisk {},
    /// The operator gives an order.
    Order {
        /// Which.
        order: BenchOrder,
        /// The speed of `speed_cap`; 0 takes it away. \[m/s\]
        value: Option<f64>,
    },
}

impl FaultKind {
    /// Whether it changes messages that pass, and so may find none.
    pub(super) fn is_on_messages(&self) -> bool {
        matches!(
            self,
            Self::Drop { .. }
                | Self::Delay { .. }
                | Self::Duplicate { .. }
                | Self::Swap {}
                | Self::Replay { .. }
                | Self::Corrupt { .. }
                | Self::Junk { .. }
                | Self::Malformed {}
                | Self::Freeze {}
                | Self::Stale { .. }
                | Self::WallClock { .. }
                | Self::Nan { .. }
                | Self::Set { .. }
                | Self::Bias { .. }
                | Self::Noise { .. }
                | Self::Ramp { .. }
                | Self::RandomWalk { .. }
                | Self::Scale { .. }
                | Self::Stuck { .. }
                | Self::Lag { .. }
                | Self::Every { .. }
                | Self::ClockDrift { .. }
                | Self::Ttl { .. }
                | Self::Fingerprint {}
        )
    }

    /// Whether it can be done to the simulated car, beside faults of a field.
    fn is_of_car(&self) -> bool {
        match *self {
            Self::Freeze {} | Self::Grip { .. } => true,
            Self::Delay { jitter_ms, .. } => jitter_ms == 0.0,
            _ => false,
        }
    }

    /// Whether it sends though nothing comes.
    pub(super) fn is_storm(&self) -> bool {
        matches!(
            self,
            Self::Storm { .. }
                | Self::SecondController { .. }
                | Self::CommandStorm { .. }
                | Self::Forge { .. }
        )
    }
}

impl Fault {
    /// What is out of range or names nothing.
    pub(super) fn problems(&self, processes: &[String]) -> Vec<String> {
        let mut problems = Vec::new();
        if !(self.at_s >= 0.0 && self.for_s.is_none_or(|length| length > 0.0)) {
            problems.push("fault: at_s must be 0 or above, for_s above 0".to_owned());
        }
        if !(self.share > 0.0 && self.share <= 1.0) {
            problems.push(format!(
                "fault: share is {}, expected above 0, at most 1: with 0 it acts on nothing",
                self.share
            ));
        }
        if let FaultKind::Kill { process }
        | FaultKind::Interrupt { process, .. }
        | FaultKind::Stop { process }
        | FaultKind::Restart { process } = &self.action
            && !processes.contains(process)
        {
            problems.push(format!("fault: process `{process}` is not started by this scenario"));
        }
        if let FaultKind::Storm { rate_hz, .. }
        | FaultKind::SecondController { rate_hz, .. }
        | FaultKind::Forge { rate_hz, .. }
        | FaultKind::CommandStorm { rate_hz, .. } = self.action
            && !(rate_hz > 0.0 && rate_hz <= 100_000.0)
        {
            problems.push(format!("fault: rate_hz is {rate_hz}, expected above 0, at most 100000"));
        }
        problems.extend(self.action.problem().map(|problem| format!("fault: {problem}")));
        let on_car = self.action.field().is_some() || self.action.is_of_car();
        if self.car && !on_car {
            let known = "faults of a field, freeze, grip, and delay without jitter";
            problems.push(format!("fault: car = true goes with {known}"));
        }
        if !self.car && matches!(self.action, FaultKind::Grip { .. }) {
            problems.push("fault: grip goes with car = true".to_owned());
        }
        if self.car && self.channel.is_some() {
            problems.push("fault: car = true is on no channel".to_owned());
        }
        problems
    }

    /// What is done where, in the words of the bench file.
    pub(super) fn words(&self) -> String {
        let action = serde_json::to_value(&self.action).unwrap_or_default();
        let Some((name, options)) = action.as_object().and_then(|all| all.iter().next()) else {
            return String::new();
        };
        let mut words = name.replace('_', " ");
        for (key, value) in options.as_object().into_iter().flatten().filter(|o| !o.1.is_null()) {
            let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            words = format!("{words} {key}={value}");
        }
        let place = if self.car { Some("the car") } else { self.channel.as_deref() };
        place.map_or(words.clone(), |place| format!("{words} on {place}"))
    }

    /// When it acts, relative to the scenario's `when`. \[ns\]
    pub(super) fn window_ns(&self) -> (i64, i64) {
        let ns = |s: f64| protocol::convert::nanoseconds(s);
        let start = ns(self.at_s);
        (start, self.for_s.map_or(i64::MAX, |length| start + ns(length)))
    }
}

fn all() -> f64 {
    1.0
}
