//! Faults of single fields: of messages between controller and car, and of the simulated car's own
//! sensors and actuators.

use rand::RngExt as _;
use rand_distr::StandardNormal;

use super::fault::{BenchOrder, FaultKind, Field};
use super::random::Random;

/// What the fault of a field remembers.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FieldMemory {
    /// When the fault first acted, and when last. \[ns\]
    first_ns: Option<i64>,
    last_ns: i64,
    /// The random walk so far.
    walk: f64,
    /// What is stuck, or follows slowly.
    kept: Option<f64>,
}

impl FaultKind {
    /// The field it changes, for actions that change one.
    pub(super) fn field(&self) -> Option<Field> {
        match *self {
            Self::Nan { field }
            | Self::Set { field, .. }
            | Self::Bias { field, .. }
            | Self::Noise { field, .. }
            | Self::Ramp { field, .. }
            | Self::RandomWalk { field, .. }
            | Self::Scale { field, .. }
            | Self::Stuck { field }
            | Self::Lag { field, .. } => Some(field),
            _ => None,
        }
    }

    /// What the field says in place of `old` at `now_ns`; `None` if it is no fault of a field.
    pub(super) fn change(
        &self,
        old: f64,
        now_ns: i64,
        memory: &mut FieldMemory,
        random: &mut Random,
    ) -> Option<f64> {
        self.field()?;
        let first_ns = *memory.first_ns.get_or_insert(now_ns);
        let since = (now_ns - first_ns) as f64 * 1e-9;
        let dt = if memory.last_ns == 0 { 0.0 } else { (now_ns - memory.last_ns) as f64 * 1e-9 };
        memory.last_ns = now_ns;
        let mut normal = || random.sample::<f64, _>(StandardNormal);
        Some(match *self {
            Self::Nan { .. } => f64::NAN,
            Self::Set { value, .. } => value,
            Self::Bias { value, .. } => old + value,
            Self::Noise { sigma, .. } => old + sigma * normal(),
            Self::Ramp { per_s, .. } => old + per_s * since,
            Self::RandomWalk { sigma, .. } => {
                memory.walk += sigma * dt.max(0.0).sqrt() * normal();
                old + memory.walk
            }
            Self::Scale { factor, .. } => old * factor,
            Self::Stuck { .. } => *memory.kept.get_or_insert(old),
            Self::Lag { seconds, .. } => {
                let before = memory.kept.unwrap_or(old);
                let share = 1.0 - (-dt.max(0.0) / seconds).exp();
                *memory.kept.insert(before + share * (old - before))
            }
            _ => return None,
        })
    }

    /// What is out of range about it, in words.
    pub(super) fn problem(&self) -> Option<String> {
        match *self {
            Self::Lag { seconds, .. } if !(seconds > 0.0 && seconds <= 60.0) => {
                Some(format!("seconds is {seconds}, expected above 0, at most 60"))
            }
            Self::Noise { sigma, .. } | Self::RandomWalk { sigma, .. }
                if sigma.is_nan() || sigma < 0.0 =>
            {
                Some(format!("sigma is {sigma}, expected 0 or above"))
            }
            Self::Grip { front, rear }
                if !(0.0..=10.0).contains(&front) || !(0.0..=10.0).contains(&rear) =>
            {
                Some(format!("grip is {front}, {rear}, expected factors from 0 to 10"))
            }
            Self::Delay { ms, jitter_ms }
                if !(0.0..=60_000.0).contains(&ms) || !(0.0..=60_000.0).contains(&jitter_ms) =>
            {
                Some(format!("ms is {ms}, jitter_ms {jitter_ms}, expected 0 to 60000"))
            }
            Self::Order { order: BenchOrder::SpeedCap, value }
                if !value.is_some_and(|value| (0.0..=1000.0).contains(&value)) =>
            {
                Some(format!("value of speed_cap is {value:?}, expected 0 to 1000 m/s"))
            }
            Self::Every { n } if n < 2 => Some(format!("n is {n}, expected 2 or above")),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use super::*;
    use crate::random;

    fn over(action: &FaultKind, values: &[f64]) -> Vec<f64> {
        let (mut memory, mut random) = (FieldMemory::default(), random::of(1));
        let at = |k: usize| 1 + 10_000_000 * i64::try_from(k).unwrap();
        let each = values.iter().enumerate();
        each.map(|(k, old)| action.change(*old, at(k), &mut memory, &mut random).unwrap()).collect()
    }

    #[test]
    fn each_fault_of_a_field_does_what_it_says() {
        let field = Field::Vx;
        let values = [1.0, 2.0, 3.0, 4.0];
        assert_eq!(over(&FaultKind::Scale { field, factor: 0.5 }, &values), [0.5, 1.0, 1.5, 2.0]);
        assert_eq!(over(&FaultKind::Stuck { field }, &values), [1.0; 4]);
        let ramp = over(&FaultKind::Ramp { field, per_s: 10.0 }, &[0.0; 4]);
        assert!(
            ramp.iter().zip([0.0, 0.1, 0.2, 0.3]).all(|(a, b)| (a - b).abs() < 1e-12),
            "{ramp:?}"
        );
        // After one time constant 63 % of a step are there.
        let mut step = vec![0.0];
        step.extend([1.0; 101]);
        let lag = over(&FaultKind::Lag { field, seconds: 1.0 }, &step);
        assert!((lag[100] - (1.0 - (-1.0_f64).exp())).abs() < 1e-3, "{}", lag[100]);
        // A walk grows as the root of the time: sigma after a second.
        let walks = over(&FaultKind::RandomWalk { field, sigma: 2.0 }, &vec![0.0; 100_001]);
        let seconds = walks.chunks(100).map(|second| second[0]);
        let steps: Vec<f64> = seconds.clone().zip(seconds.skip(1)).map(|(a, b)| b - a).collect();
        let variance = steps.iter().map(|s| s * s).sum::<f64>() / steps.len() as f64;
        assert!((variance.sqrt() - 2.0).abs() < 0.15, "{}", variance.sqrt());
    }
}
