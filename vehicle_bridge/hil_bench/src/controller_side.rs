//! Measures taken from the controller's heartbeats and telemetry.

use lcm_types::{Heartbeat, Message as _, MpcTelemetry, channels};

use super::measure::{Measure, MeasuredValues};

/// A share of grip below this is less grip. \[-\]
const LESS_GRIP: f32 = 0.98;
/// Index of e_y in a state.
const E_Y: usize = 5;

/// Messages of the controller.
#[derive(Debug, Default)]
pub(super) struct ControllerMessages {
    pub(super) beats: Vec<Heartbeat>,
    pub(super) steps: Vec<MpcTelemetry>,
}

impl ControllerMessages {
    /// Takes in a message, if it is the controller's.
    pub(super) fn add(&mut self, channel: &str, payload: &[u8]) {
        match channel {
            "HB/lmpc" => self.beats.extend(Heartbeat::decode(payload).ok()),
            channels::TELEMETRY => self.steps.extend(MpcTelemetry::decode(payload).ok()),
            _ => {}
        }
    }

    /// Everything that can be measured, with the faults beginning at `start_ns`.
    pub(super) fn values(&self, start_ns: i64, values: &mut MeasuredValues) {
        let most = self.steps.iter().map(|step| step.overruns).max();
        values.insert(Measure::Overruns, f64::from(most.unwrap_or(0)));
        let dropped = self.beats.iter().map(|beat| beat.log_dropped).max().unwrap_or(0);
        values.insert(Measure::LogDropped, dropped as f64);
        let failed = self.beats.iter().map(|beat| beat.save_failures).max().unwrap_or(0);
        values.insert(Measure::SaveFailures, failed as f64);
        self.of_steps(start_ns, values);
        let before = self.beats.iter().rfind(|beat| beat.h.mono_ns <= start_ns);
        let anew = |beat: &&Heartbeat| {
            beat.h.mono_ns > start_ns && before.is_some_and(|b| b.h.boot_id != beat.h.boot_id)
        };
        if let (Some(before), Some(beat)) = (before, self.beats.iter().find(anew)) {
            values.insert(Measure::ReadyMs, (beat.h.mono_ns - start_ns) as f64 * 1e-6);
            values.reacted(Measure::ReadyMs, 0.0);
            // The very first one may be sent before the controller is ready.
            let found = self.beats.iter().filter(anew).find_map(laps);
            if let (Some(known), Some(found)) = (laps(before), found) {
                values.insert(Measure::LapsLost, known - found);
            }
        }
    }
}

impl ControllerMessages {
    /// What the controller did and found out after the faults began.
    fn of_steps(&self, start_ns: i64, values: &mut MeasuredValues) {
        let after = || self.steps.iter().filter(|step| step.h.mono_ns >= start_ns);
        let ms = |from: i64, step: &MpcTelemetry| (step.h.mono_ns - from) as f64 * 1e-6;
        let raced = |step: &&MpcTelemetry| step.action == MpcTelemetry::LEARNED;
        if after().next().is_some() {
            let share = after().filter(raced).count() as f64 / after().count() as f64;
            values.insert(Measure::RacedShare, share);
            let least = after().map(|step| f64::from(step.road_grip)).fold(f64::INFINITY, f64::min);
            values.insert(Measure::RoadGrip, least);
        }
        let lost = after().find(|step| step.action == MpcTelemetry::RECOVERING);
        if let Some(lost) = lost
            && let Some(again) = after().filter(|s| s.h.mono_ns > lost.h.mono_ns).find(raced)
        {
            values.insert(Measure::RecoveryMs, ms(lost.h.mono_ns, again));
            values.reacted(Measure::RecoveryMs, (lost.h.mono_ns - start_ns) as f64 * 1e-9);
        }
        if let Some(seen) = after().find(|step| step.road_grip < LESS_GRIP) {
            values.insert(Measure::GripSeenMs, ms(start_ns, seen));
            values.reacted(Measure::GripSeenMs, 0.0);
        }
        if let Some(step) = self.steps.iter().rfind(|step| step.response_found) {
            values.insert(Measure::DelayFoundMs, 1e3 * f64::from(step.delay));
            values.insert(Measure::LagFoundMs, 1e3 * f64::from(step.lag));
        }
        if let Some(step) = self.steps.iter().rfind(|step| step.filtered) {
            values.insert(Measure::NoiseFoundMm, 1e3 * f64::from(step.noise_sigma[E_Y]));
        }
    }
}

/// Laps the controller has learned, from a heartbeat. \[-\]
fn laps(beat: &Heartbeat) -> Option<f64> {
    (beat.laps_learned >= 0).then(|| f64::from(beat.laps_learned))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lcm_types::Header;

    #[test]
    fn recovery_grip_response_and_noise_come_from_the_steps() {
        let step = |at: i16, action, road_grip| MpcTelemetry {
            h: Header { mono_ns: i64::from(at) * 100_000_000, ..Header::default() },
            action,
            road_grip,
            response_found: at > 2,
            delay: 0.05,
            lag: 0.1,
            filtered: true,
            noise_sigma: [0.0, 0.0, 0.0, 0.0, 0.0, 0.002 * f32::from(at)],
            ..MpcTelemetry::default()
        };
        let actions = [
            MpcTelemetry::LEARNED,
            MpcTelemetry::LEARNED,
            MpcTelemetry::RECOVERING,
            MpcTelemetry::RECOVERING,
            MpcTelemetry::LEARNED,
        ];
        let grips = [0.9, 1.0, 0.99, 0.8, 0.7];
        let steps = (0..).zip(actions).zip(grips).map(|((at, action), g)| step(at, action, g));
        let controller = ControllerMessages { beats: Vec::new(), steps: steps.collect() };
        let mut values = MeasuredValues::default();
        controller.values(100_000_000, &mut values);
        let expected = [
            (Measure::RacedShare, 0.5),
            (Measure::RecoveryMs, 200.0),
            (Measure::GripSeenMs, 200.0),
            (Measure::RoadGrip, 0.7),
            (Measure::DelayFoundMs, 50.0),
            (Measure::LagFoundMs, 100.0),
            (Measure::NoiseFoundMm, 8.0),
        ];
        for (measure, value) in expected {
            let found = values.get(measure).unwrap_or(f64::NAN);
            assert!((found - value).abs() < 1e-4, "{measure:?}: {found}, expected {value}");
        }
    }

    #[test]
    fn a_new_start_is_told_from_the_old_one() {
        let h = |boot_id, mono_ns| Header { boot_id, mono_ns, ..Header::default() };
        let step = |boot_id, at, overruns| MpcTelemetry {
            h: h(boot_id, at),
            overruns,
            ..MpcTelemetry::default()
        };
        let beat = |boot_id, at, laps_learned| Heartbeat {
            h: h(boot_id, at),
            laps_learned,
            ..Heartbeat::default()
        };
        let controller = ControllerMessages {
            beats: vec![
                Heartbeat { log_dropped: 12, save_failures: 1, ..beat(1, 5, 7) },
                beat(1, 12, 8),
                beat(2, 2_000_010, -1),
                beat(2, 2_000_110, 6),
            ],
            steps: vec![step(1, 9, 3), step(2, 20, 0)],
        };
        let mut values = MeasuredValues::default();
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
