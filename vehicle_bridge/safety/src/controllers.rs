//! Controllers that are heard: heartbeat and setup of each boot id.

use lcm_types::{BootId, MonoTime};

use super::order::Denied;
use super::rules::Setup;

/// Controllers told apart; the one silent longest makes room. \[-\]
const MOST: usize = 4;

/// One controller process.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ControllerProcess {
    boot_id: BootId,
    beat: Option<MonoTime>,
    setup: Option<Setup>,
    /// Last message of either kind.
    heard: MonoTime,
}

/// The controllers heard lately.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Controllers([Option<ControllerProcess>; MOST]);

impl Controllers {
    fn entry(&mut self, boot_id: BootId, now: MonoTime) -> Option<&mut ControllerProcess> {
        let known = self.0.iter().position(|c| c.is_some_and(|c| c.boot_id == boot_id));
        let index = known.unwrap_or_else(|| {
            let heard = |c: &Option<ControllerProcess>| c.map_or(MonoTime::EARLIEST, |c| c.heard);
            let all = self.0.iter().enumerate();
            all.min_by_key(|(_, c)| heard(c)).map_or(0, |(index, _)| index)
        });
        let place = self.0.get_mut(index)?;
        if known.is_none() {
            *place = Some(ControllerProcess { boot_id, beat: None, setup: None, heard: now });
        }
        let controller = place.as_mut()?;
        controller.heard = now;
        Some(controller)
    }

    /// A heartbeat came.
    pub(super) fn on_heartbeat(&mut self, boot_id: BootId, now: MonoTime) {
        if let Some(controller) = self.entry(boot_id, now) {
            controller.beat = Some(now);
        }
    }

    /// A setup came.
    pub(super) fn on_setup(&mut self, boot_id: BootId, setup: Setup, now: MonoTime) {
        if let Some(controller) = self.entry(boot_id, now) {
            controller.setup = Some(setup);
        }
    }

    /// Last heartbeat of this controller.
    pub(super) fn beat(&self, boot_id: BootId) -> Option<MonoTime> {
        self.0.iter().flatten().find(|c| c.boot_id == boot_id)?.beat
    }

    /// The one controller that may be armed, of those with a heartbeat since `since`; `wanted`
    /// chooses among several, [`BootId::NONE`] does not.
    pub(super) fn choose(
        &self,
        wanted: BootId,
        since: MonoTime,
        ours: &Setup,
    ) -> Result<BootId, Denied> {
        let live = || self.0.iter().flatten().filter(|c| c.beat.is_some_and(|beat| beat >= since));
        let mut candidates = live().filter(|c| wanted.is_none() || c.boot_id == wanted);
        let Some(chosen) = candidates.next() else {
            return Err(match live().map(|c| c.boot_id).min() {
                Some(heard) => Denied::OtherController { wanted, heard },
                None => Denied::NoController,
            });
        };
        if let Some(second) = candidates.next() {
            let (one, two) = (chosen.boot_id, second.boot_id);
            return Err(Denied::Controllers(one.min(two), one.max(two)));
        }
        let theirs = chosen.setup.ok_or(Denied::NoSetup)?;
        let differs = |controller: i64, car: i64| controller != car && controller != 0 && car != 0;
        if theirs.track_id != ours.track_id {
            return Err(Denied::Track { controller: theirs.track_id, car: ours.track_id });
        }
        if differs(theirs.car_id, ours.car_id) {
            return Err(Denied::Car { controller: theirs.car_id, bridge: ours.car_id });
        }
        if differs(theirs.period_ns, ours.period_ns) {
            let ms = |ns: i64| ns as f64 * 1e-6;
            let (controller_ms, bridge_ms) = (ms(theirs.period_ns), ms(ours.period_ns));
            return Err(Denied::Period { controller_ms, bridge_ms });
        }
        if differs(theirs.config_id, ours.config_id) {
            return Err(Denied::Config { controller: theirs.config_id, bridge: ours.config_id });
        }
        Ok(chosen.boot_id)
    }
}
