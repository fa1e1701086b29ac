//! What went through the fault proxy to the car, for the measures.

use std::collections::BTreeMap;

use lcm_types::{ActuationCommand, Checked as _, OperatorCommand, channels};

/// A command that passed unaltered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Passing {
    pub(super) boot_id: i64,
    pub(super) seq: i64,
    pub(super) token: i64,
    /// When. \[ns\]
    pub(super) time_ns: i64,
}

/// What went through.
#[derive(Debug, Clone, Default)]
pub(super) struct Passed {
    /// Commands of the source.
    pub(super) commands: Vec<Passing>,
    /// First emergency stop that passed. \[ns\]
    pub(super) estop_ns: Option<i64>,
    /// Emergency stops lost before it. \[-\]
    pub(super) estops_lost: u32,
    /// Messages each fault acted on, by its place in the scenario. \[-\]
    pub(super) acted: BTreeMap<usize, u32>,
    /// Messages of storms, and when the first and the last went out. \[-, ns, ns\]
    pub(super) storm: Option<(u32, i64, i64)>,
}

impl Passed {
    /// Notes a message that goes on to the car unaltered at `time_ns`, or is lost.
    pub(super) fn note(&mut self, channel: &str, message: &[u8], time_ns: i64, lost: bool) {
        match channel {
            channels::COMMAND if !lost => {
                self.commands.extend(ActuationCommand::open(message).ok().map(|c| Passing {
                    boot_id: c.h.boot_id,
                    seq: c.h.seq,
                    token: c.arm_token,
                    time_ns,
                }));
            }
            channels::OPERATOR if self.estop_ns.is_none() => {
                let order = OperatorCommand::open(message);
                if order.is_ok_and(|order| order.command == OperatorCommand::ESTOP) {
                    self.estops_lost += u32::from(lost);
                    self.estop_ns = (!lost).then_some(time_ns);
                }
            }
            _ => {}
        }
    }

    /// Notes messages of a storm.
    pub(super) fn storm(&mut self, count: u32, time_ns: i64) {
        let (sent, first, _) = self.storm.unwrap_or((0, time_ns, time_ns));
        self.storm = Some((sent + count, first, time_ns));
    }

    /// Rate of the storms. \[1/s\]
    pub(super) fn storm_hz(&self) -> Option<f64> {
        let (sent, first, last) = self.storm?;
        (last > first).then(|| f64::from(sent) / ((last - first) as f64 * 1e-9))
    }

    /// Commands of the source that was armed: of all starts that echo a grant, the first.
    pub(super) fn genuine(&self) -> Vec<Passing> {
        let mut armed = BTreeMap::new();
        let genuine = |c: &&Passing| *armed.entry(c.token).or_insert(c.boot_id) == c.boot_id;
        self.commands.iter().filter(genuine).copied().collect()
    }
}
