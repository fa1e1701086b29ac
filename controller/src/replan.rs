//! A plan along a driven lap, where the last plan diverged.
//!
//! Each problem is linearised along the plan before it. Where hard braking makes a car unstable, a small change
//! near the car is a large one at the far end of the plan. The tyres there are then linearised beyond their
//! peak, where the slope of the force has the wrong sign, and the plans that follow diverge further. A lap
//! of the safe set was driven, so that the model holds along it.

use vehicle_model::State;

use crate::controller::Controller;
use crate::fhocp::SolveReport;
use crate::optimize::Workspace;

/// Least share of a lap's speed that the car must have, and be allowed to have, for the lap to be the plan.
const AS_FAST: f64 = 0.8;

impl Workspace {
    /// Whether the tyres slip by more than twice their guards in the far part of the last solution.
    pub(crate) fn diverged(&self) -> bool {
        let (problem, slacks) = (self.problem(), &self.slacks);
        let beyond =
            |slack: &[f64], guard: f64| slack.iter().skip(self.far()).any(|slip| *slip > guard);
        beyond(&slacks.front, problem.front_max) || beyond(&slacks.rear, problem.rear_max)
    }
}

impl Controller {
    /// Solves the problem linearised along a driven lap. None, and the plan as it was, where no lap fits or
    /// there is no solution.
    pub(crate) fn replan(&mut self, x_0: &State) -> Option<SolveReport> {
        let before = (self.memory.query_s, self.memory.plan_tail);
        std::mem::swap(&mut self.memory.plan, &mut self.spare);
        if self.driven_plan(x_0) {
            self.work.prepare(&self.setup, &self.memory, &mut ());
            let report = self.work.solve(x_0, &mut self.memory);
            if report.status.usable() {
                return Some(report);
            }
        }
        std::mem::swap(&mut self.memory.plan, &mut self.spare);
        (self.memory.query_s, self.memory.plan_tail) = before;
        None
    }

    /// Makes the best lap of the safe set, from here on, the plan; false where the car is, or has to be, much
    /// slower than it was then, or the lap was interrupted within the horizon.
    fn driven_plan(&mut self, x_0: &State) -> bool {
        let memory = &mut self.memory;
        let Some(&lap) = memory.selected.first() else { return false };
        let (samples, _) = memory.dataset.driven(lap);
        // At most the number of samples, which fits isize.
        let here = samples.partition_point(|sample| sample.x.s < x_0.s) as isize;
        let seen = |t: usize| {
            memory.dataset.seen_from(
                lap,
                here.saturating_add_unsigned(t),
                self.setup.track.length(),
            )
        };
        memory.plan.clear();
        memory.plan.x.push(*x_0);
        for t in 0..self.setup.config.horizon.steps {
            let (Some(now), Some(next)) = (seen(t), seen(t + 1)) else { return false };
            let (allowed, s) = (self.work.speed_cap(), now.sample.x.s + now.offset);
            let fastest = allowed.min(memory.derived.road_speed.at(s));
            let fastest = if t == 0 { fastest.min(x_0.v_x) } else { fastest };
            if fastest < AS_FAST * now.sample.x.v_x {
                return false;
            }
            memory.plan.u.push(now.sample.u);
            memory.plan.x.push(next.place());
            memory.plan_tail = now.sample.u;
        }
        memory.query_s = memory.plan.x.last().map_or(x_0.s, |end| end.s);
        true
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::sync::Arc;

    use vehicle_model::{CarParams, Plant, PlantParams, Track};

    use super::*;
    use crate::config::Config;
    use crate::presets::Preset;
    use crate::status::{Measurement, Pose};

    fn measured(time: f64, plant: &mut Plant) -> Measurement {
        Measurement { time, pose: Pose::Frenet(plant.measure()), applied: None }
    }

    /// A plan whose far end was led astray is as good one step later as one that was not.
    #[test]
    fn a_plan_that_diverged_is_made_anew() {
        let track = Arc::new(Track::builtin("l").unwrap());
        let car = CarParams::builtin("barc").unwrap();
        let config = Config::derived(Preset::Race, &car, &track);
        let dt = config.horizon.period;
        let new = || Controller::new(config.clone(), car.clone(), track.clone()).unwrap();
        let (mut controller, mut time) = (new(), 0.0);
        let start = State { v_x: 1.0, ..State::default() };
        let mut plant = Plant::new(PlantParams::new(car.clone()), track.clone(), start).unwrap();
        // Braking before a bend of the sixth learned lap.
        while controller.memory.learned_laps < 5 || controller.memory.command.a > -0.5 {
            let command = controller.step(&measured(time, &mut plant));
            plant.apply(command.input, dt);
            time += dt;
        }
        let sound = controller.state();
        let far = controller.work.far();
        for (t, x) in controller.memory.plan.x.iter_mut().enumerate().skip(far) {
            x.v_y += if t % 2 == 0 { 2.0 } else { -2.0 };
        }
        let astray = controller.state();
        let now = measured(time, &mut plant);
        let Pose::Frenet(x_0) = now.pose else { panic!("{:?}", now.pose) };

        controller.prepare();
        let mut memory = controller.memory.clone();
        let report = controller.work.solve(&x_0, &mut memory);
        assert!(!report.status.usable() || controller.work.diverged());

        let [expected, found] = [sound, astray].map(|state| {
            let mut controller = new();
            controller.resume(&state);
            let command = controller.step(&now);
            assert!(!controller.work.diverged());
            (command.input, controller.memory.plan)
        });
        let off = found.0.to_vector() - expected.0.to_vector();
        assert!(off[0].abs() < 1.0 && off[1].abs() < 0.05, "input {off}");
        let ends = [expected, found].map(|(_, plan)| plan.x.last().copied().unwrap());
        assert!((ends[0].s - ends[1].s).abs() < 0.5, "{ends:?}");
    }
}
