//! What a run measures, and the limits of it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// What can be measured; each name ends in its unit, counts have none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// From the last valid command that reached the car side to the first report of a safe stop.
    LossToStopMs,
    /// From the fault's beginning to the first report of a safe stop.
    FaultToStopMs,
    /// From the first emergency stop that reached the car side to the first report that obeys.
    EstopMs,
    /// From the last valid command to the first report that comes from the fallback plan.
    LossToPlanMs,
    /// Reports beyond the car's range or rates, with a number that is none, or that drive after a
    /// stop without a new grant.
    UnsafeOutputs,
    /// Reports that drive by a command that was altered, too old, or not the source's.
    BadApplied,
    /// Changes from driving to stopping after the fault began.
    Trips,
    /// Reports that drive by the fallback plan.
    PlanTicks,
    /// Messages the car side's heartbeat counts as refused.
    Refused,
    /// States in which a part of the car's body was beyond the edge of the track. By the car's true
    /// state where it sends it.
    OffTrack,
    /// How far the car's body was beyond the edge of the track, at most; negative if it never was. By
    /// the car's true state where it tells it. \[m\]
    BeyondM,
    /// Reports that drive after the fault began.
    Drives,
    /// Processes that ended by themselves.
    Crashes,
    /// Growth of the car side's memory. \[MB\]
    MemoryMb,
    /// Reports that drive after the first gap of more than 0.2 s between two of them.
    DrivesAfterGap,
    /// Rate at which storms and second controllers really sent. \[1/s\]
    StormHz,
    /// Emergency stops that were lost before the first that was not.
    EstopsLost,
    /// Messages of another type, or of another version of it, that the car side counted after the
    /// fault's beginning.
    FingerprintsNamed,
    /// Orders that the car side refused.
    OrdersRefused,
    /// Longest gap between two reports of the car side. \[ms\]
    LongestGapMs,
    /// Distance driven from the fault to standstill. \[m\]
    StopDistanceM,
    /// Reports that drive by a command again after a stop.
    Resumed,
    /// Steps that took the controller longer than a period, as its telemetry says.
    Overruns,
    /// From the fault's beginning to the first heartbeat of a controller that started anew.
    ReadyMs,
    /// Laps the controller had learned before the fault began, less those at its new start.
    LapsLost,
    /// Messages that controller and car side could not write to their logs, as their heartbeats say.
    LogDropped,
    /// Attempts of the controller to save what it learned that failed, as its heartbeats say.
    SaveFailures,
    /// Share of the controller's steps after the fault's beginning that raced: its learned plan. \[-\]
    RacedShare,
    /// From the controller's first step of a recovery after the fault to its first that races again.
    RecoveryMs,
    /// From the fault's beginning to the first step that knows of a road with 2 % less grip.
    GripSeenMs,
    /// Smallest share of grip that the controller gave the road after the fault's beginning. \[-\]
    RoadGrip,
    /// Pure delay of the actuators as estimated.
    DelayFoundMs,
    /// Time constant of the actuators as estimated.
    LagFoundMs,
    /// Standard deviation of the noise of e_y as estimated. \[mm\]
    NoiseFoundMm,
    /// Smallest speed after the fault's beginning, by the true state where the car sends it. \[m/s\]
    LeastSpeedMps,
    /// Largest speed in the last second, likewise. \[m/s\]
    FinalSpeedMps,
}

/// What a limit is on.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Name {
    /// What the bench measures itself.
    Observed(Measure),
    /// What a scenario's program prints, as a line `name value`.
    Printed(String),
}

/// A limit on a measure.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Expectation {
    /// What is measured.
    pub measure: Name,
    /// Largest value allowed.
    pub most: Option<f64>,
    /// Smallest value allowed.
    pub least: Option<f64>,
}

/// Values of one run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeasuredValues {
    values: BTreeMap<Name, f64>,
    origins: BTreeMap<Name, f64>,
}

impl MeasuredValues {
    /// Sets a value.
    pub fn insert(&mut self, name: impl Into<Name>, value: f64) {
        self.values.insert(name.into(), value);
    }

    /// Notes from when on the time of a reaction counts, since the faults began. \[s\]
    pub fn reacted(&mut self, name: impl Into<Name>, from: f64) {
        self.origins.insert(name.into(), from);
    }

    /// The value, if it was measured.
    #[must_use]
    pub fn get(&self, name: impl Into<Name>) -> Option<f64> {
        self.values.get(&name.into()).copied()
    }

    /// From when on the time of a reaction counts, since the faults began. \[s\]
    #[must_use]
    pub fn origin(&self, name: impl Into<Name>) -> Option<f64> {
        self.origins.get(&name.into()).copied()
    }

    /// All values, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&Name, f64)> {
        self.values.iter().map(|(name, value)| (name, *value))
    }
}

impl Measure {
    /// Whether a computer that stood still is no excuse.
    pub(super) fn is_strict(self) -> bool {
        matches!(
            self,
            Self::UnsafeOutputs
                | Self::BadApplied
                | Self::Crashes
                | Self::DrivesAfterGap
                | Self::MemoryMb
                | Self::OffTrack
                | Self::BeyondM
                | Self::Drives
                | Self::DelayFoundMs
                | Self::LagFoundMs
                | Self::NoiseFoundMm
        )
    }

    /// The name in bench files.
    #[must_use]
    pub fn name(self) -> String {
        serde_json::to_value(self)
            .ok()
            .and_then(|v| v.as_str().map(str::to_owned))
            .unwrap_or_default()
    }
}

impl Name {
    /// The name in bench files.
    #[must_use]
    pub fn text(&self) -> String {
        match self {
            Self::Observed(measure) => measure.name(),
            Self::Printed(name) => name.clone(),
        }
    }

    /// The name as people read it, and its unit, empty for a count.
    #[must_use]
    pub fn words(&self) -> (String, &'static str) {
        let text = self.text();
        let units = [
            ("_ms", "ms"),
            ("_mb", "MB"),
            ("_hz", "1/s"),
            ("_mps", "m/s"),
            ("_mm", "mm"),
            ("_m", "m"),
            ("_s", "s"),
        ];
        let found = units.iter().find_map(|(end, unit)| Some((text.strip_suffix(end)?, *unit)));
        let (name, unit) = found.unwrap_or((text.as_str(), ""));
        (name.replace('_', " "), unit)
    }
}

impl From<Measure> for Name {
    fn from(measure: Measure) -> Self {
        Self::Observed(measure)
    }
}

impl From<&Name> for Name {
    fn from(name: &Name) -> Self {
        name.clone()
    }
}

impl From<&str> for Name {
    fn from(text: &str) -> Self {
        let known = serde_json::from_value(text.into());
        known.map_or_else(|_| Self::Printed(text.to_owned()), Self::Observed)
    }
}

impl Expectation {
    pub(super) fn problem(&self) -> Option<String> {
        let name = self.measure.text();
        match (self.least, self.most) {
            (None, None) => Some(format!("expect {name}: neither least nor most")),
            (Some(least), Some(most)) if least > most => {
                Some(format!("expect {name}: least {least} is above most {most}"))
            }
            _ => None,
        }
    }

    /// The limit in words.
    #[must_use]
    pub fn limit(&self) -> String {
        match (self.least, self.most) {
            (Some(least), Some(most)) if least == most => format!("= {least}"),
            (Some(least), Some(most)) => format!("{least} to {most}"),
            (Some(least), None) => format!(">= {least}"),
            (None, Some(most)) => format!("<= {most}"),
            (None, None) => String::new(),
        }
    }

    /// Why values do not meet it; a value that is missing does not.
    #[must_use]
    pub fn broken(&self, values: &MeasuredValues) -> Option<String> {
        let name = self.measure.text();
        let Some(value) = values.get(&self.measure) else {
            return Some(format!("{name}: never happened, limit {}", self.limit()));
        };
        let met = self.least.is_none_or(|l| value >= l) && self.most.is_none_or(|m| value <= m);
        (!met).then(|| format!("{name}: {value:.4}, limit {}", self.limit()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_never_happened_breaks_every_limit() {
        let measure = Name::from("loss_to_stop_ms");
        assert_eq!(measure, Measure::LossToStopMs.into());
        let limit = Expectation { measure, most: Some(110.0), least: None };
        assert!(limit.broken(&MeasuredValues::default()).is_some());
        let with = |value| {
            let mut values = MeasuredValues::default();
            values.insert(Measure::LossToStopMs, value);
            limit.broken(&values)
        };
        assert_eq!(
            (with(110.0), with(110.1).is_some(), with(f64::NAN).is_some()),
            (None, true, true)
        );
    }
}
