//! What a key costs: signing and checking a message, and a tick of the bridge with and without, in
//! memory, so that no system call hides the difference. `cargo bench -p auth`
#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a program of its own")]

use std::hint::black_box;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use auth::{Key, Signed};
use lcm_types::{
    ActuationCommand, ActuationReport, ArmToken, BootId, Checked as _, Header, MonoTime, SeqNumber,
    VehicleState, channels,
};
use safety::{BridgeEvent, Order, OrderKind, Rules, Safety, decode, step};
use transport::{Arrival, Error, Filter, Inbox, ReceivedMessage, Sink, Statistics, Transport};
use vehicle_model::{CarParams, State, Track};

const MS: i64 = 1_000_000;
const ROUNDS: usize = 5_000;
const CONTROLLER: i64 = 7;

/// Who asked for which channels.
type Asked = (Filter, Arc<Mutex<Box<dyn Sink>>>);

/// Hands every message to everybody who asked for its channel.
#[derive(Default)]
struct Bus(Mutex<Vec<Asked>>);

impl Transport for Bus {
    fn publish(&self, channel: &str, payload: &[u8]) -> Result<(), Error> {
        let asked = |filter: &Filter| match filter {
            Filter::All => true,
            Filter::Only(names) => names.iter().any(|name| name == channel),
        };
        let all = self.0.lock().unwrap();
        let sinks: Vec<_> =
            all.iter().filter(|(f, _)| asked(f)).map(|(_, sink)| Arc::clone(sink)).collect();
        drop(all);
        for sink in sinks {
            let arrival = Arrival::default();
            sink.lock().unwrap().deliver(&ReceivedMessage {
                channel,
                payload,
                arrival,
                sender: None,
            });
        }
        Ok(())
    }

    fn subscribe(&self, filter: Filter, sink: Box<dyn Sink>) -> Result<(), Error> {
        self.0.lock().unwrap().push((filter, Arc::new(Mutex::new(sink))));
        Ok(())
    }

    fn statistics(&self) -> Statistics {
        Statistics::default()
    }

    fn warnings(&self) -> &[String] {
        &[]
    }
}

/// Median and 99th percentile of the rounds. \[us\]
fn times(mut round: impl FnMut(i64)) -> [f64; 2] {
    let mut all: Vec<Duration> = (0..ROUNDS as i64)
        .map(|n| {
            let begun = Instant::now();
            round(n);
            begun.elapsed()
        })
        .collect();
    all.sort_unstable();
    [ROUNDS / 2, ROUNDS * 99 / 100].map(|i| all[i].as_secs_f64() * 1e6)
}

/// A command as a controller at 10 Hz sends it: fifteen steps of fallback plan.
fn command(seq: i64, mono_ns: i64) -> Vec<u8> {
    let sender = "lmpc@host".to_owned();
    let h = Header { mono_ns, utime: mono_ns / 1000, seq, boot_id: CONTROLLER, sender };
    let command = ActuationCommand {
        h,
        state_boot_id: 5,
        state_seq: seq,
        state_mono_ns: mono_ns,
        valid_for_us: 100_000,
        arm_token: 9,
        enable: true,
        mode: ActuationCommand::MODE_DRIVE,
        accel: 0.1,
        plan_dt: 0.1,
        n_plan: 15,
        plan_accel: vec![0.1; 15],
        plan_steer: vec![0.0; 15],
        ..ActuationCommand::default()
    };
    let mut bytes = Vec::new();
    command.seal_into(&mut bytes).unwrap();
    bytes
}

/// The bridge's work of one tick: command in, core, state and report out.
struct Bridge {
    rules: Rules,
    safety: Safety,
    network: Arc<dyn Transport>,
}

impl Bridge {
    fn new(network: Arc<dyn Transport>) -> Self {
        let car = CarParams::builtin("barc").unwrap();
        let track = Arc::new(Track::builtin("l").unwrap());
        let mut rules = Rules::new(&car, &track, 10 * MS);
        rules.boot_id = BootId::new(5);
        let mut bridge = Self { rules, safety: Safety::default(), network };
        let still = State::default();
        for at_ns in (0..1_200 * MS).step_by(10 * MS as usize) {
            bridge.on(&BridgeEvent::State(still, 2), at_ns);
        }
        let now_ns = 1_190 * MS;
        let controller = BootId::new(CONTROLLER);
        bridge.on(&BridgeEvent::Heartbeat(controller), now_ns);
        let setup = bridge.rules.setup;
        bridge.on(&BridgeEvent::Setup(controller, setup), now_ns);
        for kind in [OrderKind::Arm { moving: false, controller: BootId::NONE }, OrderKind::Start] {
            let token = ArmToken::new(9);
            let order = Order { kind, token, deadman: false, fresh: token };
            bridge.on(&BridgeEvent::Order(order), now_ns);
        }
        bridge
    }

    fn on(&mut self, event: &BridgeEvent<'_>, at_ns: i64) -> safety::Output {
        let (next, output) = step(&self.rules, &self.safety, event, MonoTime::from_ns(at_ns));
        self.safety = next;
        output
    }

    fn tick(&mut self, n: i64, bytes: &[u8]) {
        let at_ns = 1_200 * MS + 10 * MS * n;
        self.on(&BridgeEvent::State(State::default(), 2), at_ns);
        self.on(&BridgeEvent::Published(SeqNumber::new(n)), at_ns);
        let offer = decode(bytes, MonoTime::from_ns(at_ns), &self.rules, "elsewhere").unwrap();
        self.on(&BridgeEvent::Command(&offer), at_ns);
        let output = self.on(&BridgeEvent::Tick, at_ns);
        let h =
            Header { seq: n, boot_id: 5, sender: "bridge@host".to_owned(), ..Header::default() };
        let (mut state, mut report) = (Vec::new(), Vec::new());
        VehicleState { h: h.clone(), ..VehicleState::default() }.seal_into(&mut state).unwrap();
        let accel = output.applied.sent.a;
        ActuationReport { h, accel, ..ActuationReport::default() }.seal_into(&mut report).unwrap();
        self.network.publish(channels::STATE, &state).unwrap();
        self.network.publish(channels::ACTUATION, &report).unwrap();
    }
}

fn main() {
    let key = || Key::from_bytes(&[7; 32]);
    let plain: Arc<dyn Transport> = Arc::<Bus>::default();
    let bus: Arc<dyn Transport> = Arc::<Bus>::default();
    let sender = Signed::new(Arc::clone(&bus), key()).unwrap();
    let receiver = Signed::new(Arc::clone(&bus), key()).unwrap();
    // Greetings: from then on the receiver lets the sender's messages in.
    let heard = Inbox::latest();
    receiver.subscribe(Filter::channel("BENCH"), heard.sink()).unwrap();
    let patience = Instant::now() + Duration::from_secs(5);
    while heard.take().is_none() {
        sender.publish("BENCH", b"x").unwrap();
        assert!(Instant::now() < patience, "the two never met");
        std::thread::sleep(Duration::from_millis(5));
    }
    let inboxes = [Inbox::latest(), Inbox::latest()];
    plain.subscribe(Filter::channel(channels::COMMAND), inboxes[0].sink()).unwrap();
    receiver.subscribe(Filter::channel(channels::COMMAND), inboxes[1].sink()).unwrap();
    let bytes = command(1, 0);
    let send = |network: &dyn Transport, channel: &str| {
        times(|_| network.publish(channel, black_box(&bytes)).unwrap())
    };
    // On a channel that nobody asked for: signed and sent, no more.
    let unheard = "HB/nobody";
    let [plain_out, signed_out] = [send(&*plain, unheard), send(&sender, unheard)];
    let [plain_both, signed_both] =
        [send(&*plain, channels::COMMAND), send(&sender, channels::COMMAND)];
    let sign = signed_out[0] - plain_out[0];
    let check = signed_both[0] - plain_both[0] - sign;
    let tick = |network: Arc<dyn Transport>| {
        let mut bridge = Bridge::new(network);
        let commands: Vec<_> = (0..ROUNDS as i64).map(|n| command(n, 0)).collect();
        times(|n| bridge.tick(n, &commands[n as usize]))
    };
    let without = tick(Arc::clone(&plain));
    let with = tick(Arc::new(Signed::new(Arc::<Bus>::default(), key()).unwrap()));
    println!("command of {} bytes, medians of {ROUNDS} [us]", bytes.len());
    println!("  sign    {sign:6.2}");
    println!("  check   {check:6.2}");
    println!("tick of the bridge without system calls, median and p99 [us]");
    println!("  without key                        {:6.2} {:6.2}", without[0], without[1]);
    println!("  two messages signed                {:6.2} {:6.2}", with[0], with[1]);
    println!("  two signed and one checked         {:6.2}", with[0] + check);
    println!("  ratio to the tick without          {:6.2}", (with[0] + check) / without[0]);
    println!(
        "  share of the 10 ms between ticks   {:6.4}",
        (with[0] + check - without[0]) / 10_000.0
    );
}
