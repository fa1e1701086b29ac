//! Random events that reach what matters: drives that go well, each kind of trouble, and chaos.

use std::collections::VecDeque;

use super::*;

/// What is wrong for a while.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mood {
    Calm,
    NoCommands,
    NoStates,
    NoPulses,
    Gaps,
    Released,
    Storms,
    Resting,
    BadStates,
    Failing,
    Chaos,
}

const MOODS: [Mood; 11] = [
    Mood::Calm,
    Mood::NoCommands,
    Mood::NoStates,
    Mood::NoPulses,
    Mood::Gaps,
    Mood::Released,
    Mood::Storms,
    Mood::Resting,
    Mood::BadStates,
    Mood::Failing,
    Mood::Chaos,
];

/// What is to be said next; filled in when it is said.
#[derive(Debug, Clone, Copy)]
enum Plan {
    State,
    Heartbeat,
    Setup,
    Published,
    End,
    Command,
    Rest,
    Order(OrderKind, bool),
    Fail,
    Tick,
    Sent,
}

/// An event that owns what it says.
pub(super) enum Said {
    /// A command, and what was done to it.
    Command(Box<DecodedCommand>, Option<Reject>),
    Other(BridgeEvent<'static>),
}

/// A token that is not this one.
fn other_than(right: ArmToken) -> ArmToken {
    token(right.get() + 1)
}

pub(super) struct Generator {
    random: Pcg64,
    mood: Mood,
    left: u32,
    queue: VecDeque<Plan>,
    deadman: bool,
    sender: BootId,
    published: i64,
}

impl Generator {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            random: Pcg64::seed_from_u64(seed),
            mood: Mood::Calm,
            left: 0,
            queue: VecDeque::new(),
            deadman: false,
            sender: CONTROLLER,
            published: 0,
        }
    }

    fn once_in(&mut self, n: u32) -> bool {
        self.random.random_range(0..n) == 0
    }

    /// A cycle of about 10 ms.
    fn cycle(&mut self, bridge_state: BridgeState) {
        if self.left == 0 {
            let calm = self.once_in(3);
            self.mood = if calm { Mood::Calm } else { MOODS[self.random.random_range(0..11)] };
            self.left = self.random.random_range(10..80);
            self.sender = if self.once_in(8) { OTHER } else { CONTROLLER };
        }
        self.left -= 1;
        let (mood, n) = (self.mood, self.random.random_range(0..1000));
        if bridge_state == BridgeState::Boot && n % 7 == 0 {
            let early = [Plan::Fail, Plan::Order(OrderKind::Estop, false)];
            self.queue.push_back(early[n % 2]);
        }
        let chaos = mood == Mood::Chaos;
        if n % 3 == 0 && mood != Mood::NoPulses {
            self.queue.push_back(Plan::Heartbeat);
            self.queue.push_back(Plan::Setup);
        }
        let often = if mood == Mood::Chaos { 12 } else { 4 };
        let kind = match bridge_state {
            _ if (chaos && self.once_in(30)) || self.once_in(400) => [
                OrderKind::Estop,
                OrderKind::Stop,
                OrderKind::Disarm,
                OrderKind::Unknown(99),
                OrderKind::Reset,
                OrderKind::Arm { moving: true, controller: BootId::NONE },
            ]
            .get(n % 6)
            .copied(),
            _ if self.once_in(40) => {
                Some(OrderKind::SpeedCap([0.0, 1000.0, 1e4, -1.0, 2.0, 0.5, f64::NAN][n % 7]))
            }
            _ if !self.once_in(often) => None,
            BridgeState::Boot | BridgeState::Idle => {
                Some(OrderKind::Arm { moving: n % 9 == 0, controller: BootId::NONE })
            }
            // What ends ARMED alone needs time.
            BridgeState::Armed if matches!(mood, Mood::NoStates | Mood::NoPulses) => None,
            BridgeState::Armed => Some(OrderKind::Start),
            BridgeState::Fault | BridgeState::Estop => Some(OrderKind::Reset),
            BridgeState::SafeStop if self.once_in(60) => Some(OrderKind::Estop),
            BridgeState::Running | BridgeState::SafeStop => None,
        };
        if bridge_state == BridgeState::Armed {
            self.deadman = n % 2 == 0 || mood == Mood::Released;
        }
        let silent = mood == Mood::NoStates || (bridge_state == BridgeState::Boot && n % 2 == 0);
        if let Some(kind) = kind {
            if !silent {
                // Whether the car stands is then said, not reckoned.
                self.queue.push_back(Plan::State);
            }
            self.queue.push_back(Plan::Order(kind, self.deadman));
        }
        let fell_silent = mood == Mood::Released && n % 2 == 0 && self.left < 20;
        if bridge_state == BridgeState::Running && self.deadman && !fell_silent {
            let held = !(mood == Mood::Released && self.once_in(40));
            self.queue.push_back(Plan::Order(OrderKind::Start, held));
        }
        match mood {
            Mood::NoCommands => {}
            Mood::Storms if self.once_in(40) => {
                self.queue.extend(std::iter::repeat_n(Plan::Command, 130));
            }
            Mood::Resting if self.once_in(10) => self.queue.push_back(Plan::Rest),
            _ if n % 5 < 2 => self.queue.push_back(Plan::Command),
            _ => {}
        }
        if (mood == Mood::Failing || chaos) && self.once_in(40) {
            self.queue.push_back(Plan::Fail);
        }
        if !silent {
            self.queue.push_back(Plan::State);
        }
        self.queue.push_back(Plan::Tick);
        if n % 16 != 3 {
            self.queue.push_back(Plan::Published);
        }
        if chaos && self.once_in(60) {
            self.queue.push_back(Plan::End);
        }
        if n % 8 != 0 {
            self.queue.push_back(Plan::Sent);
        }
    }

    /// The next event and its time.
    pub(super) fn next(&mut self, rules: &Rules, model: &Model, now: i64) -> (Said, i64) {
        while self.queue.is_empty() {
            self.cycle(model.bridge_state);
        }
        let plan = self.queue.pop_front().unwrap_or(Plan::Tick);
        let pause = match (self.mood, plan) {
            (_, Plan::Order(..)) => 0,
            (Mood::Storms, _) if self.queue.len() > 10 => 0,
            (Mood::Gaps | Mood::Chaos, _) if self.once_in(60) => self.random.random_range(50..400),
            _ => self.random.random_range(0..4),
        };
        let now = now + pause * MS;
        let said = match plan {
            Plan::Command => {
                let (offer, damage) = self.command(rules, model, now);
                Said::Command(Box::new(offer), damage)
            }
            Plan::Rest => {
                let (mut offer, damage) = self.command(rules, model, now);
                offer.drives = false;
                offer.estop = self.once_in(2);
                Said::Command(Box::new(offer), damage)
            }
            other => Said::Other(self.other(other, rules, model)),
        };
        (said, now)
    }

    fn other(&mut self, plan: Plan, rules: &Rules, model: &Model) -> BridgeEvent<'static> {
        let odd = self.once_in(12);
        match plan {
            Plan::State => {
                let stands = match model.bridge_state {
                    BridgeState::SafeStop => self.once_in(8),
                    BridgeState::Running | BridgeState::Estop | BridgeState::Fault => {
                        self.once_in(2)
                    }
                    _ => !self.once_in(10),
                };
                let v_x = self.random.random_range(if stands { 0.0..0.05 } else { 1.5..3.0 });
                let s = self.random.random_range(0.0..10.0);
                let bad = self.mood == Mood::BadStates;
                let (v_x, quality) = match self.random.random_range(0..30) {
                    0 if bad => (f64::NAN, 2),
                    1 if bad => (v_x, 0),
                    2 | 3 if bad => (v_x, 1),
                    _ => (v_x, 2),
                };
                BridgeEvent::State(State { v_x, s, ..State::default() }, quality)
            }
            Plan::Heartbeat => BridgeEvent::Heartbeat(if odd { OTHER } else { self.sender }),
            Plan::Setup => {
                let mut setup = rules.setup;
                if odd {
                    let way = self.random.random_range(0..4);
                    let places = [
                        &mut setup.track_id,
                        &mut setup.car_id,
                        &mut setup.period_ns,
                        &mut setup.config_id,
                    ];
                    places.into_iter().nth(way).into_iter().for_each(|id| *id += 1);
                }
                BridgeEvent::Setup(if self.once_in(12) { OTHER } else { self.sender }, setup)
            }
            Plan::Published => {
                self.published += 1;
                BridgeEvent::Published(number(self.published))
            }
            Plan::End => BridgeEvent::End,
            Plan::Order(kind, deadman) => {
                let given = if odd { other_than(model.token) } else { model.token };
                let (none, dead) = (BootId::NONE, BootId::new(5));
                let controller = [none, none, self.sender, OTHER, dead, none, none, none];
                let controller = controller[self.random.random_range(0..8)];
                let kind = match kind {
                    OrderKind::Arm { moving, .. } => OrderKind::Arm { moving, controller },
                    other => other,
                };
                let fresh = token(self.random.random_range(1..i64::MAX - 1));
                BridgeEvent::Order(Order { kind, token: given, deadman, fresh })
            }
            Plan::Fail => BridgeEvent::CarFailed,
            Plan::Sent => BridgeEvent::Sent,
            Plan::Command | Plan::Rest | Plan::Tick => BridgeEvent::Tick,
        }
    }

    /// A command, and the first reason to refuse it that was put into it.
    fn command(
        &mut self,
        rules: &Rules,
        model: &Model,
        now: i64,
    ) -> (DecodedCommand, Option<Reject>) {
        let limiter = rules.limiter;
        let mut input = || Input {
            a: self.random.random_range(limiter.a_min..=limiter.a_max),
            delta: self.random.random_range(-limiter.delta_max..=limiter.delta_max),
        };
        let (input, mut plan) = (input(), [Input::default(); PLAN]);
        plan.fill_with(&mut || Input { a: self.random.random_range(-1.0..1.0), delta: 0.1 });
        let n_plan = self.random.random_range(0..6);
        // What is behind the plan's end is nobody's business.
        plan[n_plan].a = f64::NAN;
        let skip = if self.once_in(10) { self.random.random_range(0..100) } else { 0 };
        let seq = model.last_seq().map_or(1000, |last| last + 1 + skip);
        let arrival_ns = now - self.random.random_range(0..2) * MS;
        let valid_ms = [250, 250, 250, 70, 50][self.random.random_range(0..5)];
        let mut offer = DecodedCommand {
            boot_id: self.sender,
            seq: number(seq),
            arrival: time(arrival_ns),
            since: time(arrival_ns - self.random.random_range(0..20) * MS),
            answers: Some(number(self.published.saturating_sub(self.random.random_range(0..2)))),
            token: model.token,
            drives: true,
            estop: false,
            input,
            valid_for_ns: valid_ms * MS,
            plan,
            n_plan,
            plan_dt: [0.0, 0.02, 0.03][self.random.random_range(0..3)],
        };
        if !self.once_in(4) {
            return (offer, None);
        }
        // The later check's damage first: what both touch belongs to the earlier.
        let (one, two) = (self.random.random_range(0..7), self.random.random_range(0..7));
        let mut found = None;
        for kind in [one.max(two), one.min(two)] {
            found = self.damage(&mut offer, kind, model, now).or(found);
        }
        (offer, found)
    }

    fn damage(
        &mut self,
        offer: &mut DecodedCommand,
        kind: u32,
        model: &Model,
        now: i64,
    ) -> Option<Reject> {
        let way = self.random.random_range(0..6);
        let last = offer.n_plan.saturating_sub(1);
        Some(match (kind, way) {
            (0, 0) => {
                offer.input.a = f64::NAN;
                Reject::NotFinite
            }
            (0, 1) => {
                offer.input.delta = f64::INFINITY;
                Reject::NotFinite
            }
            (0, 2) if offer.n_plan > 0 => {
                offer.plan[last].delta = f64::NAN;
                Reject::NotFinite
            }
            (0, _) => {
                offer.plan_dt = f64::NAN;
                Reject::NotFinite
            }
            (1, 0) => {
                offer.input.a = -1e9;
                Reject::Range
            }
            (1, 1) => {
                offer.input.delta = -3.0;
                Reject::Range
            }
            (1, 2) if offer.n_plan > 0 => {
                offer.plan[last].a = 1e9;
                Reject::Range
            }
            (1, 3) => {
                offer.plan_dt = -0.1;
                Reject::Range
            }
            (1, _) => {
                offer.valid_for_ns = 0;
                Reject::Range
            }
            (2, 0) => {
                offer.valid_for_ns = 5 * MS;
                offer.since = time(now - 6 * MS);
                Reject::Stale
            }
            (2, 1) => {
                offer.arrival = time(now - 101 * MS);
                Reject::Stale
            }
            (2, _) => {
                offer.since = time(now - 101 * MS);
                Reject::Stale
            }
            (3, _) => {
                offer.boot_id = BootId::new(79);
                Reject::Boot
            }
            (4, 0..3) => {
                offer.seq = number(model.last_seq()? - i64::from(way));
                Reject::Sequence
            }
            (4, _) => {
                offer.seq = number(model.last_seq()? + 101);
                Reject::Sequence
            }
            (5, _) => {
                offer.token = other_than(model.token);
                Reject::Token
            }
            _ => {
                let wrong = [None, Some(self.published + 1), Some(-1)];
                offer.answers = wrong[(way % 3) as usize].map(number);
                offer.drives.then_some(Reject::Unanswered)?
            }
        })
    }
}
