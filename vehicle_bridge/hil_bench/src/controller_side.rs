//! Measures taken from the controller's heartbeats and telemetry.

use lcm_types::{Heartbeat, Message as _, MpcTelemetry, channels};

use super::measure::{Measure, Values};

/// Messages of the controller.
#[derive(Debug, Default)]
pub(super) struct Controller {
    pub(super) beats: Vec<Heartbeat>,
    pub(super) steps: Vec<MpcTelemetry>,
}

impl Controller {
    /// Takes in a message, if it is the controller's.
    pub(super) fn add(&mut self, channel: &str, payload: &[u8]) {
        match channel {
            "HB/lmpc" => self.beats.extend(Heartbeat::decode(payload).ok()),
            channels::TELEMETRY => self.steps.extend(MpcTelemetry::decode(payload).ok()),
            _ => {}
        }
    }

    /// Everything that can be measured, with the faults beginning at `start_ns`.
    pub(super) fn values(&self, start_ns: i64, values: &mut Values) {
        let most = self.steps.iter().map(|step| step.overruns).max();
        values.insert(Measure::Overruns, f64::from(most.unwrap_or(0)));
        let dropped = self.beats.iter().map(log_dropped).max().unwrap_or(0);
        values.insert(Measure::LogDropped, dropped as f64);
        let failed = self.beats.iter().filter(|beat| beat.detail.contains("cannot save")).count();
        values.insert(Measure::SaveFailures, failed as f64);
        let before = self.beats.iter().rfind(|beat| beat.h.mono_ns <= start_ns);
        let anew = |beat: &&Heartbeat| {
            beat.h.mono_ns > start_ns && before.is_some_and(|b| b.h.boot_id != beat.h.boot_id)
        };
        if let (Some(before), Some(beat)) = (before, self.beats.iter().find(anew)) {
            values.insert(Measure::ReadyMs, (beat.h.mono_ns - start_ns) as f64 * 1e-6);
            values.reacted(Measure::ReadyMs, 0.0);
            // The very first one may be sent before there is anything to say.
            let found = self.beats.iter().filter(anew).find_map(laps);
            if let (Some(known), Some(found)) = (laps(before), found) {
                values.insert(Measure::LapsLost, known - found);
            }
        }
    }
}

/// Laps the controller has learned, from a heartbeat. \[-\]
fn laps(beat: &Heartbeat) -> Option<f64> {
    beat.detail.split(" laps learned").next()?.rsplit(' ').next()?.parse().ok()
}

/// Messages missing in the program's log, from a heartbeat. \[-\]
pub(super) fn log_dropped(beat: &Heartbeat) -> u64 {
    let said = beat.detail.split("log: ").nth(1).and_then(|rest| rest.split(' ').next());
    said.and_then(|number| number.parse().ok()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lcm_types::Header;

    #[test]
    fn a_new_start_is_told_from_the_old_one() {
        let h = |boot_id, mono_ns| Header { boot_id, mono_ns, ..Header::default() };
        let step = |boot_id, at, overruns| MpcTelemetry {
            h: h(boot_id, at),
            overruns,
            ..MpcTelemetry::default()
        };
        let beat = |boot_id, at, detail: &str| Heartbeat {
            h: h(boot_id, at),
            detail: detail.to_owned(),
            ..Heartbeat::default()
        };
        let controller = Controller {
            beats: vec![
                beat(1, 5, "7 laps learned; log: 12 messages dropped, full; cannot save x: full"),
                beat(1, 12, "8 laps learned"),
                beat(2, 2_000_010, "6 laps learned"),
            ],
            steps: vec![step(1, 9, 3), step(2, 20, 0)],
        };
        let mut values = Values::default();
        controller.values(10, &mut values);
        let expected = [
            (Measure::Overruns, 3.0),
            (Measure::ReadyMs, 2.0),
            (Measure::LapsLost, 1.0),
            (Measure::LogDropped, 12.0),
            (Measure::SaveFailures, 1.0),
        ];
        for (measure, value) in expected {
            assert_eq!(values.get(measure), Some(value), "{measure:?}");
        }
    }
}
