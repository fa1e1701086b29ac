//! The map file as written.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

/// A map file. Names are not resolved yet.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapFile {
    /// `.lcm` files of the car's types, relative to the map file.
    pub types: Vec<Spanned<String>>,
    /// Messages the state is made of, by a name of the file's own.
    pub(super) source: BTreeMap<String, SourceEntry>,
    pub(super) state: StateEntry,
    #[serde(default)]
    pub(super) reference: ReferenceEntry,
    #[serde(default)]
    pub(super) frame: FrameEntry,
    pub(super) command: CommandEntry,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SourceEntry {
    pub(super) channel: Spanned<String>,
    #[serde(rename = "type")]
    pub(super) kind: Spanned<String>,
    /// When it was measured; without it, when it arrived.
    pub(super) time: Option<TimeEntry>,
    /// Oldest value of it that joins a state. \[ms\]
    #[serde(default = "default_age")]
    pub(super) max_age_ms: Spanned<f64>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TimeEntry {
    pub(super) field: Spanned<String>,
    pub(super) unit: Spanned<String>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StateEntry {
    pub(super) x: Signal,
    pub(super) y: Signal,
    pub(super) yaw: Spanned<YawEntry>,
    pub(super) vx: Signal,
    pub(super) vy: Option<Signal>,
    pub(super) yaw_rate: Signal,
    pub(super) ax: Option<Signal>,
    pub(super) ay: Option<Signal>,
    pub(super) steer: Option<Signal>,
    /// Axes of `vx` and `vy`.
    #[serde(default)]
    pub(super) velocity_frame: VelocityFrame,
}

/// One number of a message: `scale * field + offset` in `unit`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Signal {
    pub(super) source: Option<Spanned<String>>,
    pub(super) field: Spanned<String>,
    pub(super) unit: Spanned<String>,
    #[serde(default = "one")]
    pub(super) scale: Spanned<f64>,
    #[serde(default = "zero")]
    pub(super) offset: Spanned<f64>,
}

/// The heading: an angle (`field`), or from a quaternion body to world.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct YawEntry {
    pub(super) source: Option<Spanned<String>>,
    /// An array of four.
    pub(super) quaternion: Option<Spanned<String>>,
    #[serde(default)]
    pub(super) order: QuaternionOrder,
    pub(super) field: Option<Spanned<String>>,
    pub(super) unit: Option<Spanned<String>>,
    #[serde(default = "one")]
    pub(super) scale: Spanned<f64>,
    #[serde(default = "zero")]
    pub(super) offset: Spanned<f64>,
    #[serde(default)]
    pub(super) zero: Zero,
    #[serde(default)]
    pub(super) positive: Sense,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum VelocityFrame {
    #[default]
    Body,
    World,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum QuaternionOrder {
    #[default]
    Wxyz,
    Xyzw,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Zero {
    #[default]
    East,
    North,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Sense {
    #[default]
    CounterClockwise,
    Clockwise,
}

/// Where on the car the source measures, from the centre of mass, body frame. \[m\]
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct ReferenceEntry {
    pub(super) forward_m: f64,
    pub(super) left_m: f64,
}

/// Where the source's origin lies in the track's world, and how it is turned there.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct FrameEntry {
    pub(super) x_m: f64,
    pub(super) y_m: f64,
    pub(super) yaw_deg: f64,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CommandEntry {
    pub(super) channel: Spanned<String>,
    #[serde(rename = "type")]
    pub(super) kind: Spanned<String>,
    pub(super) time: Option<CommandTimeEntry>,
    /// A command is sent at least this often. \[ms\]
    #[serde(default = "default_period")]
    pub(super) period_ms: Spanned<f64>,
    pub(super) field: Vec<Spanned<CommandField>>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CommandTimeEntry {
    pub(super) field: Spanned<String>,
    pub(super) unit: Spanned<String>,
    /// The time that is written.
    #[serde(default)]
    pub(super) of: TimeOf,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum TimeOf {
    /// The wall clock when it is sent.
    #[default]
    Sending,
    /// The measurement the command answers, the source's own clock.
    Measurement,
}

/// One number of the command: `scale * value + offset` in `unit`, kept within `min` and `max`.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CommandField {
    pub(super) field: Spanned<String>,
    pub(super) from: From,
    pub(super) unit: Option<Spanned<String>>,
    #[serde(default = "one")]
    pub(super) scale: Spanned<f64>,
    #[serde(default = "zero")]
    pub(super) offset: Spanned<f64>,
    pub(super) min: Option<f64>,
    pub(super) max: Option<f64>,
    /// What is written when there is no valid command; without it, the last value stays.
    pub(super) stop: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum From {
    /// The acceleration.
    Accel,
    /// The acceleration where it is positive, else 0.
    Drive,
    /// The acceleration's negative where it is negative, else 0.
    Brake,
    /// The steering angle.
    Steer,
    /// 1 while a command is in force, else 0.
    Enabled,
    /// 0: what is written is the offset.
    Constant,
}

fn default_age() -> Spanned<f64> {
    Spanned::new(0..0, 200.0)
}

fn default_period() -> Spanned<f64> {
    Spanned::new(0..0, 20.0)
}

fn one() -> Spanned<f64> {
    Spanned::new(0..0, 1.0)
}

fn zero() -> Spanned<f64> {
    Spanned::new(0..0, 0.0)
}
