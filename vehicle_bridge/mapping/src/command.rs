//! Our input to the car's command.

use lcm_types::Error;
use lcm_types::schema::Primitive;
use lcm_types::value::{Path, Value};
use vehicle_model::Input;

use super::Mapping;
use super::file::{CommandEntry, From, TimeOf};
use super::resolve::{Place, Resolver};
use super::unit::Quantity;

/// What the car is to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CarRequest {
    /// Input to apply; `None` sends the safe stop.
    pub input: Option<Input>,
    /// `meas_mono_ns` of the state this answers, if any. \[ns\]
    pub answers_ns: Option<i64>,
    /// Wall clock now. \[us\]
    pub utime: i64,
}

#[derive(Debug, Clone)]
struct Field {
    place: Place,
    from: From,
    gain: f64,
    offset: f64,
    min: f64,
    max: f64,
    stop: Option<f64>,
    last: f64,
}

/// Everything about the command.
#[derive(Debug, Clone)]
pub(super) struct CommandMap {
    pub(super) channel: String,
    pub(super) period: f64,
    kind: String,
    time: Option<(Place, f64, TimeOf)>,
    fields: Vec<Field>,
    message: Value,
}

impl CommandMap {
    pub(super) fn resolve(entry: &CommandEntry, r: &mut Resolver<'_>) -> Option<Self> {
        r.channel(&entry.channel);
        let period = r.finite("period_ms", &entry.period_ms, true) * 1e-3;
        if !r.kind(&entry.kind) {
            return None;
        }
        let kind = entry.kind.get_ref();
        let time = entry.time.as_ref().and_then(|time| {
            let place = r.number(kind, &time.field);
            let unit = r.unit(Quantity::Time, &time.unit);
            Some((place?, unit?, time.of))
        });
        let mut fields = Vec::new();
        for spanned in &entry.field {
            let field = spanned.get_ref();
            let (quantity, ours) = match field.from {
                From::Accel | From::Drive | From::Brake => (Quantity::Acceleration, "m/s^2"),
                From::Steer => (Quantity::Angle, "rad"),
                From::Enabled | From::Constant => (Quantity::Own, "-"),
            };
            let unit = match &field.unit {
                Some(unit) => r.unit(quantity, unit),
                None if ours == "-" => Some(1.0),
                None => {
                    let name = field.field.get_ref();
                    let message = format!("{name}: `unit` is missing, such as \"{ours}\"");
                    r.wrong(&field.field, message);
                    None
                }
            };
            let scale = r.finite("scale", &field.scale, false);
            let offset = r.finite("offset", &field.offset, false);
            let (min, max) =
                (field.min.unwrap_or(f64::NEG_INFINITY), field.max.unwrap_or(f64::INFINITY));
            if min.is_nan() || max.is_nan() || min > max {
                r.wrong(&field.field, format!("min = {min}, max = {max}: expected min <= max"));
            }
            if field.stop.is_some_and(|stop| !(min..=max).contains(&stop)) {
                let message = format!("stop = {:?}: expected {min} to {max}", field.stop);
                r.wrong(&field.field, message);
            }
            if let (Some(place), Some(unit)) = (r.number(kind, &field.field), unit) {
                let last = field.stop.unwrap_or(offset);
                let (gain, from, stop) = (scale / unit, field.from, field.stop);
                fields.push(Field { place, from, gain, offset, min, max, stop, last });
            }
        }
        // A car that only coasts when the commands stop is no safe car.
        let stops = |f: &Field| {
            let slows = matches!(f.from, From::Accel | From::Brake | From::Drive | From::Enabled);
            slows && f.stop.is_some()
        };
        if fields.len() == entry.field.len() && !fields.iter().any(stops) {
            let message = "no `stop` on any field from accel, drive, brake or enabled: the car \
                           would go on when the commands stop";
            r.wrong(&entry.kind, message.to_owned());
        }
        let zero = r.schema.zero(kind).map_err(|e| e.to_string());
        let message = r.note(&entry.kind, zero)?;
        let channel = entry.channel.get_ref().clone();
        Some(Self { channel, period, kind: kind.clone(), time, fields, message })
    }
}

impl Field {
    fn value(&mut self, input: Option<Input>) -> f64 {
        let Some(Input { a, delta }) = input else {
            return self.stop.unwrap_or(self.last);
        };
        let ours = match self.from {
            From::Accel => a,
            From::Drive => a.max(0.0),
            From::Brake => (-a).max(0.0),
            From::Steer => delta,
            From::Enabled => 1.0,
            From::Constant => 0.0,
        };
        self.last = (self.gain * ours + self.offset).clamp(self.min, self.max);
        self.last
    }
}

impl Mapping {
    /// Replaces the contents of `out` with the car's command.
    ///
    /// # Errors
    /// If the command cannot be encoded; nothing that [`Mapping::new`] let through is known to do
    /// so.
    pub fn command(&mut self, request: &CarRequest, out: &mut Vec<u8>) -> Result<(), Error> {
        let answered = request.answers_ns.and_then(|ns| self.their_time(ns));
        let map = &mut self.command;
        for field in &mut map.fields {
            let value = field.value(request.input);
            put(&mut map.message, &field.place.path, of_kind(field.place.kind, value));
        }
        if let Some((place, unit, of)) = &map.time {
            let ns = match of {
                TimeOf::Sending => request.utime.saturating_mul(1000),
                TimeOf::Measurement => answered.unwrap_or(0),
            };
            #[expect(clippy::cast_possible_truncation, reason = "1 to 10^9")]
            let count = ns / (*unit as i64).max(1);
            #[expect(clippy::cast_precision_loss, reason = "a float has no more")]
            let value = match place.kind {
                Primitive::Int64 => Value::Integer(count),
                kind => of_kind(kind, ns as f64 / unit),
            };
            put(&mut map.message, &place.path, value);
        }
        self.schema.encode_into(&map.kind, &map.message, out)
    }
}

fn put(message: &mut Value, path: &Path, value: Value) {
    if let Some(place) = path.get_mut(message) {
        *place = value;
    }
}

/// A number as the type of a field has it: integers rounded and kept in range.
#[expect(clippy::cast_possible_truncation, reason = "rounded and kept in range")]
fn of_kind(kind: Primitive, value: f64) -> Value {
    let within = |min: i64, max: i64| Value::Integer((value.round() as i64).clamp(min, max));
    match kind {
        Primitive::Int8 => within(i8::MIN.into(), i8::MAX.into()),
        Primitive::Int16 => within(i16::MIN.into(), i16::MAX.into()),
        Primitive::Int32 => within(i32::MIN.into(), i32::MAX.into()),
        Primitive::Byte => within(0, 255),
        Primitive::Float => Value::Float(value as f32),
        Primitive::Boolean => Value::Boolean(value >= 0.5),
        Primitive::Int64 | Primitive::String => Value::Integer(value.round() as i64),
        Primitive::Double => Value::Double(value),
    }
}
