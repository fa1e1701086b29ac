//! The car's messages to a state.

use std::fmt;

use lcm_types::value::{Path, Value};
use lcm_types::{Header, VehicleState};

use super::Mapping;
use super::file::{
    FrameEntry, MapFile, QuaternionOrder, ReferenceEntry, Sense, Signal, VelocityFrame, Zero,
};
use super::resolve::Resolver;
use super::unit::Quantity;
use lcm_types::Arrival;

/// A clock that leaps by more than this was set, or its program started again. \[ns\]
const LEAP_NS: i64 = 1_000_000_000;

/// What became of the car's messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CarMessageCounts {
    /// States made. \[-\]
    pub states: u64,
    /// Messages that could not be decoded, or held what is no number. \[-\]
    pub bad: u64,
    /// Messages measured no later than the one before. \[-\]
    pub old: u64,
    /// States not made because another message they need was missing or too old. \[-\]
    pub incomplete: u64,
}

impl fmt::Display for CarMessageCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { states, bad, old, incomplete } = self;
        write!(f, "car: {states} states, {bad} bad, {old} old, {incomplete} incomplete")
    }
}

/// `gain * field + offset`, in our unit.
#[derive(Debug, Clone)]
struct Number {
    source: usize,
    path: Path,
    gain: f64,
    offset: f64,
}

#[derive(Debug, Clone)]
enum Yaw {
    Angle { number: Number, zero: Zero, positive: Sense },
    Quaternion { source: usize, paths: [Path; 4], order: QuaternionOrder },
}

#[derive(Debug, Clone)]
struct Source {
    channel: String,
    kind: String,
    time: Option<(Path, f64)>,
    max_age_ns: i64,
    last: Option<(Value, i64)>,
}

/// Everything about the state.
#[derive(Debug, Clone)]
pub(super) struct StateMap {
    sources: Vec<Source>,
    /// The source of the position: each of its messages makes a state.
    main: usize,
    numbers: [Option<Number>; 8],
    yaw: Yaw,
    velocity_frame: VelocityFrame,
    reference: ReferenceEntry,
    frame: FrameEntry,
    /// Our monotonic clock when the source's is 0, and its last time. \[ns\]
    clock: Option<(i64, i64)>,
    counts: CarMessageCounts,
}

// Places in `StateMap::numbers`.
const X: usize = 0;
const Y: usize = 1;
const VX: usize = 2;
const VY: usize = 3;
const RATE: usize = 4;
const AX: usize = 5;
const AY: usize = 6;
const STEER: usize = 7;

impl StateMap {
    pub(super) fn resolve(file: &MapFile, r: &mut Resolver<'_>) -> Option<Self> {
        let sources = file.source.values().map(|entry| {
            r.channel(&entry.channel);
            let known = r.kind(&entry.kind);
            let time = entry.time.as_ref().filter(|_| known).and_then(|time| {
                let place = r.number(entry.kind.get_ref(), &time.field);
                let unit = r.unit(Quantity::Time, &time.unit);
                Some((place?.path, unit?))
            });
            #[expect(clippy::cast_possible_truncation, reason = "milliseconds")]
            let max_age_ns = (r.finite("max_age_ms", &entry.max_age_ms, true) * 1e6) as i64;
            let (channel, kind) = (entry.channel.get_ref().clone(), entry.kind.get_ref().clone());
            Source { channel, kind, time, max_age_ns, last: None }
        });
        let sources: Vec<Source> = sources.collect();
        let entry = &file.state;
        let mut number = |signal: &Signal, quantity| {
            let found = r.source(&file.source, signal.source.as_ref(), &signal.field);
            let unit = r.unit(quantity, &signal.unit);
            let scale = r.finite("scale", &signal.scale, false);
            let offset = r.finite("offset", &signal.offset, false);
            let (source, of) = found?;
            let path = r.number(of.kind.get_ref(), &signal.field)?.path;
            Some(Number { source, path, gain: scale * unit?, offset: offset * unit? })
        };
        let all = [
            (Some(&entry.x), Quantity::Length),
            (Some(&entry.y), Quantity::Length),
            (Some(&entry.vx), Quantity::Velocity),
            (entry.vy.as_ref(), Quantity::Velocity),
            (Some(&entry.yaw_rate), Quantity::AngularVelocity),
            (entry.ax.as_ref(), Quantity::Acceleration),
            (entry.ay.as_ref(), Quantity::Acceleration),
            (entry.steer.as_ref(), Quantity::Angle),
        ];
        let numbers = all.map(|(signal, quantity)| signal.and_then(|s| number(s, quantity)));
        let yaw = Self::resolve_yaw(file, r);
        if entry.velocity_frame == VelocityFrame::World && entry.vy.is_none() {
            let message = "velocity_frame = \"world\" needs `vy` too".to_owned();
            r.wrong(&entry.vx.field, message);
        }
        for (name, value) in [
            ("reference.forward_m", file.reference.forward_m),
            ("reference.left_m", file.reference.left_m),
            ("frame.x_m", file.frame.x_m),
            ("frame.y_m", file.frame.y_m),
            ("frame.yaw_deg", file.frame.yaw_deg),
        ] {
            r.finite(name, &toml::Spanned::new(0..0, value), false);
        }
        Some(Self {
            main: numbers[X].as_ref()?.source,
            yaw: yaw?,
            numbers,
            sources,
            velocity_frame: entry.velocity_frame,
            reference: file.reference,
            frame: file.frame,
            clock: None,
            counts: CarMessageCounts::default(),
        })
    }

    fn resolve_yaw(file: &MapFile, r: &mut Resolver<'_>) -> Option<Yaw> {
        let entry = file.state.yaw.get_ref();
        let (source, of) = r.source(&file.source, entry.source.as_ref(), &file.state.yaw)?;
        match (&entry.quaternion, &entry.field) {
            (Some(field), None) => {
                let paths = r.four(of.kind.get_ref(), field)?;
                Some(Yaw::Quaternion { source, paths, order: entry.order })
            }
            (None, Some(field)) => {
                let Some(unit) = &entry.unit else {
                    r.wrong(field, "`unit` is missing, expected rad or deg".to_owned());
                    return None;
                };
                let unit = r.unit(Quantity::Angle, unit)?;
                let gain = unit * r.finite("scale", &entry.scale, false);
                let offset = unit * r.finite("offset", &entry.offset, false);
                let path = r.number(of.kind.get_ref(), field)?.path;
                let number = Number { source, path, gain, offset };
                Some(Yaw::Angle { number, zero: entry.zero, positive: entry.positive })
            }
            _ => {
                let message = "yaw: expected either `quaternion` or `field`".to_owned();
                r.wrong(&file.state.yaw, message);
                None
            }
        }
    }

    pub(super) fn channels(&self) -> Vec<String> {
        self.sources.iter().map(|source| source.channel.clone()).collect()
    }

    fn read(&self, number: &Number, now_ns: i64) -> Option<f64> {
        let value = number.path.get(self.message(number.source, now_ns)?)?.number()?;
        Some(number.gain * value + number.offset).filter(|v| v.is_finite())
    }

    fn message(&self, source: usize, now_ns: i64) -> Option<&Value> {
        let source = self.sources.get(source)?;
        let (value, arrival_ns) = source.last.as_ref()?;
        (now_ns - arrival_ns <= source.max_age_ns).then_some(value)
    }

    fn heading(&self, now_ns: i64) -> Option<f64> {
        match &self.yaw {
            Yaw::Angle { number, zero, positive } => {
                let angle = self.read(number, now_ns)?;
                let turned = if *positive == Sense::Clockwise { -angle } else { angle };
                let north = if *zero == Zero::North { std::f64::consts::FRAC_PI_2 } else { 0.0 };
                Some(turned + north)
            }
            Yaw::Quaternion { source, paths, order } => {
                let message = self.message(*source, now_ns)?;
                let q = paths.each_ref().map(|p| p.get(message).and_then(Value::number));
                let [a, b, c, d] = q;
                let (w, x, y, z) = match order {
                    QuaternionOrder::Wxyz => (a?, b?, c?, d?),
                    QuaternionOrder::Xyzw => (d?, a?, b?, c?),
                };
                let norm = w * w + x * x + y * y + z * z;
                // Not a rotation: an estimator that has not started sends zeros.
                (0.25..4.0)
                    .contains(&norm)
                    .then(|| (2.0 * (w * z + x * y)).atan2(w * w + x * x - y * y - z * z))
            }
        }
    }

    /// The state at the centre of mass, in the track's world.
    fn state(&self, now_ns: i64) -> Option<VehicleState> {
        let get = |i: usize| self.numbers[i].as_ref().and_then(|n| self.read(n, now_ns));
        let heading = self.heading(now_ns)?;
        let (mut vx, mut vy) = (get(VX)?, get(VY));
        if self.velocity_frame == VelocityFrame::World {
            let (sin, cos) = heading.sin_cos();
            let (east, north) = (vx, vy?);
            (vx, vy) = (east * cos + north * sin, Some(north * cos - east * sin));
        }
        let yaw_rate = get(RATE)?;
        let (forward, left) = (self.reference.forward_m, self.reference.left_m);
        let turn = self.frame.yaw_deg.to_radians();
        let (x, y) = (get(X)?, get(Y)?);
        let yaw = heading + turn;
        let (x, y) = (
            self.frame.x_m + x * turn.cos() - y * turn.sin(),
            self.frame.y_m + x * turn.sin() + y * turn.cos(),
        );
        let mut valid = VehicleState::POSE | VehicleState::VEL;
        let (ax, ay, steer) = (get(AX), get(AY), get(STEER));
        valid |= if ax.is_some() && ay.is_some() { VehicleState::ACC } else { 0 };
        valid |= if steer.is_some() { VehicleState::STEER } else { 0 };
        // Without a measured lateral velocity the rear axle is taken not to slip.
        let vy = if self.numbers[VY].is_some() { vy? } else { 0.0 };
        Some(VehicleState {
            valid,
            quality: 1,
            x: x - forward * yaw.cos() + left * yaw.sin(),
            y: y - forward * yaw.sin() - left * yaw.cos(),
            yaw: vehicle_model::track::wrap_angle(yaw),
            vx: vx + yaw_rate * left,
            vy: vy - yaw_rate * forward,
            yaw_rate,
            ax: ax.unwrap_or_default(),
            ay: ay.unwrap_or_default(),
            steer: steer.unwrap_or_default(),
            ..VehicleState::default()
        })
    }

    /// Our monotonic time of a measurement; `None` if it is no later than the last. Differences are
    /// those of the source's clock; where it begins is when its first message arrived.
    fn time(&mut self, theirs_ns: i64, arrival_ns: i64) -> Option<i64> {
        let base = match self.clock {
            Some((base, last)) if (theirs_ns - last).abs() <= LEAP_NS => {
                // A message that is repeated is answered again.
                if theirs_ns < last {
                    return None;
                }
                base
            }
            _ => arrival_ns.saturating_sub(theirs_ns),
        };
        self.clock = Some((base, theirs_ns));
        Some(base.saturating_add(theirs_ns))
    }
}

impl Mapping {
    /// Takes a message of the car. A state comes out for each message with the position, if all it
    /// needs has been heard; its header is empty, and the host stamps and numbers it.
    pub fn take(&mut self, channel: &str, bytes: &[u8], at: Arrival) -> Option<VehicleState> {
        let map = &mut self.state;
        let mut found = None;
        for index in 0..map.sources.len() {
            let source = &mut map.sources[index];
            if source.channel != channel {
                continue;
            }
            let Ok(value) = self.schema.decode(&source.kind, bytes) else {
                map.counts.bad += 1;
                continue;
            };
            let time = source
                .time
                .as_ref()
                .map(|(path, unit)| path.get(&value).and_then(|value| nanoseconds(value, *unit)));
            source.last = Some((value, at.mono.as_ns()));
            if index != map.main {
                continue;
            }
            let meas_mono_ns = match time {
                None => at.mono.as_ns(),
                Some(Some(theirs_ns)) => match map.time(theirs_ns, at.mono.as_ns()) {
                    Some(ours) => ours,
                    None => {
                        map.counts.old += 1;
                        continue;
                    }
                },
                Some(None) => {
                    map.counts.bad += 1;
                    continue;
                }
            };
            let state = map.state(at.mono.as_ns());
            map.counts.states += u64::from(state.is_some());
            map.counts.incomplete += u64::from(state.is_none());
            found = state.map(|state| VehicleState {
                h: Header::default(),
                meas_utime: at.utime,
                meas_mono_ns,
                ..state
            });
        }
        found
    }

    /// What became of the messages so far.
    #[must_use]
    pub fn counts(&self) -> CarMessageCounts {
        self.state.counts
    }

    /// The source's own time of a measurement that a state carried as `meas_mono_ns`. \[ns\]
    pub(super) fn their_time(&self, meas_mono_ns: i64) -> Option<i64> {
        self.state.clock.map(|(base, _)| meas_mono_ns - base)
    }
}

/// Nanoseconds of a time stamp; integers exactly.
#[expect(clippy::cast_possible_truncation, reason = "checked")]
fn nanoseconds(value: &Value, unit: f64) -> Option<i64> {
    match value {
        Value::Integer(count) => count.checked_mul(unit as i64),
        other => {
            let time = other.number()? * unit;
            (time.abs() < 9e18).then_some(time as i64)
        }
    }
}
