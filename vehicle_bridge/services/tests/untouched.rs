//! What the controller sends passes the bridge untouched: random cars, tracks, noise, delays, limits
//! and speed caps, with the messages of the service and the safety core of the bridge between the
//! controller and a simulated car.
#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

use std::sync::Arc;

use controller::{Config, Controller, Measurement, Pose, Preset};
use lcm_types::{ActuationCommand, ArmToken, BootId, Checked as _, Header, MonoTime, SeqNumber};
use protocol::convert::{AnsweredState, CommandDraft};
use rand::{RngExt as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use safety::{Answer, BridgeEvent, BridgeState, OrderKind, Rules, Safety, decode, step};
use services::operator::{capped, plan_cap};
use vehicle_model::{CarParams, Input, Limit, Plant, PlantParams, SensorNoise, State, Track};

const MS: i64 = 1_000_000;
const TICK_MS: i64 = 10;
const BRIDGE: BootId = BootId::new(5);
const CONTROLLER: BootId = BootId::new(77);
const TOKEN: ArmToken = ArmToken::new(9);
/// Drives, each with another seed. \[-\]
const DRIVES: u64 = 64;
/// Duration of a drive. \[ms\]
const LENGTH_MS: i64 = 50_000;
/// Until then the brake of the start is let go. \[ms\]
const RELEASE_MS: i64 = 300;

/// One drive.
struct Case {
    car: CarParams,
    track: Arc<Track>,
    config: Config,
    noise: f64,
    /// From the state to the arrival of its command. \[ms\]
    latency_ms: i64,
    /// Speed cap from some time on. \[m/s\]
    cap: Option<f64>,
}

impl Case {
    fn new(seed: u64) -> Self {
        let mut rng = Pcg64Mcg::seed_from_u64(seed);
        let mut between = |least: f64, most: f64| least + (most - least) * rng.random::<f64>();
        let names = ["barc", "f1tenth", "kart", "mini", "road", "formula_student"];
        let mut car = CarParams::builtin(names[seed as usize % names.len()]).unwrap();
        car.mass *= between(0.9, 1.1);
        car = car.clone().with_mu(car.tyre_front.mu * between(0.9, 1.1));
        car.a_max *= between(0.7, 1.0);
        car.a_min *= between(0.7, 1.0);
        car.delta_max *= between(0.9, 1.0);
        if seed.is_multiple_of(2) {
            car.a_rate_max = Some(car.a_max * between(5.0, 40.0));
            car.delta_rate_max = Some(car.delta_max * between(5.0, 25.0));
        }
        if seed.is_multiple_of(3) {
            car.actuator_delay = between(0.0, 0.05);
        }
        assert_eq!(car.validate(), vec![], "seed {seed}");
        let track = Arc::new(vehicle_model::track::random(seed, &car).unwrap());
        let mut config = Config::derived(Preset::Race, &car, &track);
        let period_ms = (1e3 * config.horizon.period).round() as i64;
        // A fifth of the drives with a command for each tick of the bridge.
        let ticks = if seed.is_multiple_of(5) { 1 } else { (period_ms / TICK_MS).max(1) };
        config.horizon.period = 1e-3 * (ticks * TICK_MS) as f64;
        let noise = [0.0, 0.001, 0.003][seed as usize % 3];
        let latency_ms = between(0.0, 0.8 * (ticks * TICK_MS) as f64) as i64;
        let cap =
            (seed % 4 == 1 || seed % 8 == 2).then(|| between(0.5, 1.2) * config.warm_up.speed);
        // The bridge caps by the speed of each state: noise there moves what it allows.
        let noise = if cap.is_some() { 0.0 } else { noise };
        Self { car, track, config, noise, latency_ms, cap }
    }

    fn period_ms(&self) -> i64 {
        (1e3 * self.config.horizon.period).round() as i64
    }
}

/// The core, with its clock.
struct Bridge {
    rules: Rules,
    safety: Safety,
}

impl Bridge {
    fn on(&mut self, event: &BridgeEvent<'_>, at_ms: i64) -> safety::Output {
        let (next, output) = step(&self.rules, &self.safety, event, MonoTime::from_ns(at_ms * MS));
        self.safety = next;
        output
    }

    fn order(&mut self, kind: OrderKind, at_ms: i64) {
        let order = safety::Order { kind, token: TOKEN, deadman: false, fresh: TOKEN };
        assert_eq!(self.on(&BridgeEvent::Order(order), at_ms).answer, Answer::Accepted, "{kind:?}");
    }
}

fn sealed(command: &ActuationCommand) -> Vec<u8> {
    let mut bytes = Vec::new();
    command.seal_into(&mut bytes).unwrap();
    bytes
}

/// What a drive showed.
#[derive(Debug, Default)]
struct Seen {
    commands: u32,
    ramps: u32,
    learned: usize,
}

fn drive(seed: u64) -> Seen {
    let case = Case::new(seed);
    let mut params = PlantParams::new(case.car.clone());
    let (pose, velocity) = (case.noise, 3.0 * case.noise);
    params.noise = SensorNoise {
        v_x: velocity,
        v_y: velocity,
        omega_z: velocity,
        e_psi: pose,
        s: pose,
        e_y: pose,
    };
    params.seed = seed;
    let mut plant = Plant::new(params, Arc::clone(&case.track), State::default()).unwrap();
    let mut controller =
        Controller::new(case.config.clone(), case.car.clone(), Arc::clone(&case.track)).unwrap();
    let period_ms = case.period_ms();
    let mut rules = Rules::new(&case.car, &case.track, period_ms * MS);
    rules.boot_id = BRIDGE;
    let mut bridge = Bridge { rules, safety: Safety::default() };
    let mut seen = Seen::default();
    // A second of good states, then ARM and START.
    let begin_ms = 2_000;
    for at_ms in (begin_ms - 1_100..begin_ms).step_by(TICK_MS as usize) {
        bridge.on(&BridgeEvent::State(plant.measure(), 2), at_ms);
        bridge.on(&BridgeEvent::Published(SeqNumber::new(at_ms)), at_ms);
        bridge.on(&BridgeEvent::Tick, at_ms);
    }
    bridge.on(&BridgeEvent::Heartbeat(CONTROLLER), begin_ms);
    let setup = bridge.rules.setup;
    bridge.on(&BridgeEvent::Setup(CONTROLLER, setup), begin_ms);
    bridge.order(OrderKind::Arm { moving: false, controller: BootId::NONE }, begin_ms);
    bridge.order(OrderKind::Start, begin_ms);

    let (mut last, mut wanted, mut applied) = (Input::default(), None, Input::default());
    // Whether the brake of the start has been let go.
    let mut released = false;
    let mut under_way: Option<(i64, Vec<u8>, (i64, Input))> = None;
    let mut in_force: Option<(i64, Input)> = None;
    let mut known_from_ms = 0;
    for at_ms in begin_ms..begin_ms + LENGTH_MS {
        let (at, since_ms) = (MonoTime::from_ns(at_ms * MS), at_ms - begin_ms);
        let context =
            || format!("seed {seed}, {} on {}, {since_ms} ms", case.car.name, case.track.name());
        let tick = at_ms % TICK_MS == 0;
        if tick {
            bridge.on(&BridgeEvent::State(plant.measure(), 2), at_ms);
            bridge.on(&BridgeEvent::Published(SeqNumber::new(at_ms)), at_ms);
        }
        let cap = case.cap.filter(|_| since_ms >= LENGTH_MS / 3);
        if since_ms == LENGTH_MS / 3
            && let Some(cap) = cap
        {
            bridge.order(OrderKind::SpeedCap(cap), at_ms);
            controller.set_speed_cap(plan_cap(Some(cap), &controller)).unwrap();
            // The bridge brakes from the order on, the controller from its next commands on.
            (in_force, known_from_ms) = (None, since_ms + 3 * period_ms);
        }
        if since_ms % period_ms == 0 {
            let x = plant.measure();
            let time = 1e-3 * since_ms as f64;
            let applied = wanted.is_some_and(|wanted| wanted != last).then_some(last);
            let command = controller.step(&Measurement { time, pose: Pose::Frenet(x), applied });
            wanted = Some(command.input);
            let input = capped(command.input, last, x.v_x, cap, &controller);
            let order = CommandDraft {
                answered: AnsweredState {
                    boot_id: BRIDGE,
                    seq: SeqNumber::new(at_ms),
                    measured: at,
                },
                mode: ActuationCommand::MODE_DRIVE,
                input,
                plan: (input == command.input).then(|| controller.plan()),
                period: controller.config().horizon.period,
                valid_for_us: 250_000,
                arm_token: TOKEN,
            };
            let boot_id = CONTROLLER.get();
            let h = Header { boot_id, seq: seen.commands.into(), ..Header::default() };
            under_way = Some((at_ms + case.latency_ms, sealed(&order.message(h)), (at_ms, input)));
            last = input;
            seen.commands += 1;
            controller.prepare();
        }
        if let Some((_, bytes, (sent_ms, input))) = under_way.take_if(|(due, ..)| *due <= at_ms) {
            let command = decode(&bytes, at, &bridge.rules, "elsewhere").unwrap();
            let answer = bridge.on(&BridgeEvent::Command(&command), at_ms).answer;
            assert_eq!(answer, Answer::Accepted, "{}: {input:?}", context());
            in_force = (sent_ms - begin_ms >= known_from_ms).then_some((at_ms, input));
        }
        if tick {
            let output = bridge.on(&BridgeEvent::Tick, at_ms);
            assert_eq!(
                bridge.safety.bridge_state(),
                BridgeState::Running,
                "{}: {:?}",
                context(),
                bridge.safety.stop_reason()
            );
            applied = output.applied.sent;
            if let Some((came_ms, input)) = in_force {
                let off = (applied.a - input.a).abs().max((applied.delta - input.delta).abs());
                if off > 1e-6 {
                    // A command that counts for several ticks may use up a period's rate: the bridge
                    // gives the car a tick's share at a time, and all of it before the next one.
                    // The brake that held the car is let go at the car's own jerk.
                    let first = !released && since_ms < RELEASE_MS;
                    let ramp = period_ms > TICK_MS && at_ms - came_ms < period_ms - TICK_MS;
                    let rates = Limit::Jerk as i32 | Limit::SteeringRate as i32;
                    let allowed = output.applied.bits & !rates == 0 && (ramp || first);
                    assert!(allowed, "{}: {:?} after {came_ms}", context(), output.applied);
                    seen.ramps += u32::from(!first);
                } else {
                    released = true;
                }
            }
        }
        plant.apply(applied, 1e-3);
    }
    seen.learned = controller.laps().len();
    seen
}

#[test]
fn everything_the_controller_sends_passes_untouched() {
    let mut all = Seen::default();
    let drives: Vec<Seen> = (0..DRIVES).map(drive).collect();
    for seen in drives {
        all.commands += seen.commands;
        all.ramps += seen.ramps;
        all.learned += seen.learned;
    }
    // It drove, it learned, and rates were used.
    assert!(all.commands > 10_000 && all.learned > 20 && all.ramps > 100, "{all:?}");
}
