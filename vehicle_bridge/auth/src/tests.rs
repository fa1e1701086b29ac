//! Forged and recorded messages against a network with a key, on a bus in memory.
#![allow(clippy::unwrap_used, reason = "code of tests")]

use std::os::unix::fs::PermissionsExt as _;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use lcm_types::{
    ActuationCommand, Checked as _, Header, Heartbeat, Message as _, OperatorCommand, VehicleState,
    channels, signature,
};

use super::{Key, KeyError, Refusals, Signed};
use transport::{Arrival, Error, Filter, Inbox, ReceivedMessage, Sink, Statistics, Transport};

/// Attacks of each kind. \[-\]
const TIMES: i64 = 10_000;

type Heard = (Filter, Arc<Mutex<Box<dyn Sink>>>);

/// Hands every message to everybody, as multicast does, and keeps what was said.
#[derive(Default)]
struct Bus {
    sinks: Mutex<Vec<Heard>>,
    said: Mutex<Vec<(String, Vec<u8>)>>,
}

impl Bus {
    fn said(&self, channel: &str) -> Vec<Vec<u8>> {
        let said = self.said.lock().unwrap();
        said.iter().filter(|(c, _)| c == channel).map(|(_, bytes)| bytes.clone()).collect()
    }
}

impl Transport for Bus {
    fn publish(&self, channel: &str, payload: &[u8]) -> Result<(), Error> {
        self.said.lock().unwrap().push((channel.to_owned(), payload.to_vec()));
        let sinks: Vec<_> = {
            let all = self.sinks.lock().unwrap();
            let asked = |filter: &Filter| match filter {
                Filter::All => true,
                Filter::Only(names) => names.iter().any(|name| name == channel),
            };
            all.iter().filter(|(f, _)| asked(f)).map(|(_, sink)| Arc::clone(sink)).collect()
        };
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
        self.sinks.lock().unwrap().push((filter, Arc::new(Mutex::new(sink))));
        Ok(())
    }

    fn statistics(&self) -> Statistics {
        Statistics::default()
    }

    fn warnings(&self) -> &[String] {
        &[]
    }
}

fn key(byte: u8) -> Key {
    Key::from_bytes(&[byte; 32])
}

fn join(bus: &Arc<Bus>, byte: u8) -> Signed {
    let network: Arc<dyn Transport> = Arc::<Bus>::clone(bus);
    Signed::new(network, key(byte)).unwrap()
}

/// One message of each kind that makes somebody do something, with this number.
fn kinds(seq: i64) -> Vec<(&'static str, Vec<u8>)> {
    let h = Header { boot_id: 7, seq, sender: "x@here".to_owned(), ..Header::default() };
    let (mut command, mut state, mut arm, mut reset, mut beat) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
    ActuationCommand { h: h.clone(), ..Default::default() }.seal_into(&mut command).unwrap();
    VehicleState { h: h.clone(), ..Default::default() }.seal_into(&mut state).unwrap();
    let order = |command: i8| OperatorCommand { h: h.clone(), command, ..Default::default() };
    order(OperatorCommand::ARM).seal_into(&mut arm).unwrap();
    order(OperatorCommand::ESTOP_RESET).seal_into(&mut reset).unwrap();
    Heartbeat { h, ..Default::default() }.encode_into(&mut beat).unwrap();
    vec![
        (channels::COMMAND, command),
        (channels::STATE, state),
        (channels::OPERATOR, arm),
        (channels::OPERATOR, reset),
        ("HB/lmpc", beat),
    ]
}

const ALL: [&str; 4] = [channels::COMMAND, channels::STATE, channels::OPERATOR, "HB/lmpc"];

fn listen(network: &dyn Transport) -> Inbox {
    let inbox = Inbox::queue(1 << 20);
    network.subscribe(Filter::Only(ALL.map(str::to_owned).to_vec()), inbox.sink()).unwrap();
    inbox
}

fn drain(inbox: &Inbox) -> usize {
    std::iter::from_fn(|| inbox.take()).count()
}

/// Says one message of each kind until one is heard: the two know each other then.
fn meet(sender: &dyn Transport, inbox: &Inbox) -> i64 {
    let begun = Instant::now();
    for seq in 0.. {
        for (channel, bytes) in kinds(seq) {
            sender.publish(channel, &bytes).unwrap();
        }
        if drain(inbox) == kinds(0).len() {
            return seq + 1;
        }
        assert!(begun.elapsed() < Duration::from_secs(30), "the two never met");
        std::thread::sleep(Duration::from_millis(1));
    }
    0
}

#[test]
fn nothing_forged_or_recorded_is_heard() {
    let bus = Arc::<Bus>::default();
    // What an earlier start said to an earlier receiver, all of it recorded.
    let recorded = {
        let (sender, receiver) = (join(&bus, 1), join(&bus, 1));
        let inbox = listen(&receiver);
        let first = meet(&sender, &inbox);
        for seq in first..first + 100 {
            for (channel, bytes) in kinds(seq) {
                sender.publish(channel, &bytes).unwrap();
            }
        }
        assert_eq!(drain(&inbox), 500);
        [channels::HELLO].iter().chain(&ALL).map(|c| (*c, bus.said(c))).collect::<Vec<_>>()
    };
    let (sender, receiver) = (join(&bus, 1), join(&bus, 1));
    let (inbox, seal) = (listen(&receiver), receiver.seal());
    let mut seq = meet(&sender, &inbox);
    let signature_of = |channel: &str| {
        let last = bus.said(channel).pop().unwrap();
        (last.clone(), signature::split(&last).1.unwrap())
    };
    let stranger = key(2);
    for round in 0..TIMES {
        for (channel, bytes) in kinds(1_000_000 + round) {
            // Unsigned; signed with another key, as the sender's next; the last message's signature
            // behind another message; the last message with one bit changed; once more as it was.
            let (last, genuine) = signature_of(channel);
            bus.publish(channel, &bytes).unwrap();
            let (start, next) = (genuine.start, genuine.seq + 1_000_000);
            let tag = stranger.tag(channel, start, next, &bytes);
            let mut forged = bytes.clone();
            signature::Signature { start, seq: next, tag }.append_to(&mut forged);
            bus.publish(channel, &forged).unwrap();
            let mut moved = bytes.clone();
            genuine.append_to(&mut moved);
            bus.publish(channel, &moved).unwrap();
            let mut flipped = last.clone();
            let bit = usize::try_from(round).unwrap() % (8 * last.len());
            flipped[bit / 8] ^= 1 << (bit % 8);
            bus.publish(channel, &flipped).unwrap();
            bus.publish(channel, &last).unwrap();
            let elsewhere = ALL[(ALL.iter().position(|c| *c == channel).unwrap() + 1) % ALL.len()];
            bus.publish(elsewhere, &last).unwrap();
            // The genuine ones of now go; what was said must not pile up.
            let mut said = bus.said.lock().unwrap();
            said.clear();
            said.push((channel.to_owned(), last));
            drop(said);
            let old = &recorded.iter().find(|(c, _)| *c == channels::HELLO).unwrap().1;
            bus.publish(channels::HELLO, &old[usize::try_from(round).unwrap() % old.len()])
                .unwrap();
            for (channel, old) in recorded.iter().filter(|(c, _)| *c == channel) {
                bus.publish(channel, &old[usize::try_from(round).unwrap() % old.len()]).unwrap();
            }
            // Every channel's own last message is needed in the next round.
            for (channel, bytes) in kinds(seq) {
                sender.publish(channel, &bytes).unwrap();
            }
            seq += 1;
            assert_eq!(drain(&inbox), kinds(0).len(), "the genuine ones alone, round {round}");
        }
    }
    let Refusals { unsigned, forged, stranger, replayed } = seal.refusals();
    let each = 5 * u64::try_from(TIMES).unwrap();
    assert!(unsigned >= each && forged >= 3 * each, "{unsigned} {forged}");
    assert!(stranger >= each && replayed >= each, "{stranger} {replayed}");
}

#[test]
fn an_emergency_stop_is_heard_from_anybody_and_its_reset_is_not() {
    let bus = Arc::<Bus>::default();
    let receiver = join(&bus, 1);
    let inbox = listen(&receiver);
    let order = |command: i8, seq: i64| {
        let h = Header { seq, ..Header::default() };
        let mut bytes = Vec::new();
        OperatorCommand { h, command, ..Default::default() }.seal_into(&mut bytes).unwrap();
        bytes
    };
    for seq in 0..TIMES {
        bus.publish(channels::OPERATOR, &order(OperatorCommand::ESTOP, seq)).unwrap();
        for command in [OperatorCommand::ESTOP_RESET, OperatorCommand::START, OperatorCommand::ARM]
        {
            bus.publish(channels::OPERATOR, &order(command, seq)).unwrap();
        }
    }
    let heard: Vec<_> = std::iter::from_fn(|| inbox.take()).collect();
    assert_eq!(heard.len(), usize::try_from(TIMES).unwrap());
    for received in heard {
        let order = OperatorCommand::open(&received.payload).unwrap();
        assert_eq!(order.command, OperatorCommand::ESTOP);
    }
}

#[test]
fn who_knows_nothing_of_keys_decodes_what_is_signed() {
    let bus = Arc::<Bus>::default();
    let old = listen(&*bus);
    let sender = join(&bus, 1);
    for (channel, bytes) in kinds(3) {
        sender.publish(channel, &bytes).unwrap();
    }
    let heard: Vec<_> = std::iter::from_fn(|| old.take()).collect();
    assert_eq!(heard.len(), kinds(0).len());
    for (received, (_, bytes)) in heard.iter().zip(kinds(3)) {
        // The bytes of before stand first; decoders of LCM read no further.
        assert_eq!(received.payload[..bytes.len()], bytes);
        assert_eq!(received.payload.len(), bytes.len() + signature::SIZE);
    }
    assert_eq!(VehicleState::open(&heard[1].payload).unwrap().h.seq, 3);
    assert_eq!(Heartbeat::decode(&heard[4].payload).unwrap().h.seq, 3);
}

#[test]
fn a_cars_own_messages_pass_as_they_are() {
    let bus = Arc::<Bus>::default();
    let signed = join(&bus, 1);
    let inbox = Inbox::queue(4);
    signed.subscribe(Filter::channel("VICON_barc"), inbox.sink()).unwrap();
    bus.publish("VICON_barc", b"pose").unwrap();
    assert_eq!(inbox.take().unwrap().payload, b"pose");
    signed.publish("THROTTLE", b"0.1").unwrap();
    assert_eq!(bus.said("THROTTLE"), [b"0.1"]);
}

#[test]
fn the_code_is_that_of_rfc_2104() {
    // By Python's hmac, a second implementation: hmac.new(bytes([1] * 32), b"lmpc message 1\0" +
    // struct.pack(">Q", 8) + b"LMPC/CMD" + struct.pack(">qq", 7, 9) + b"abc", "sha256").
    let tag = key(1).tag("LMPC/CMD", 7, 9, b"abc");
    let hex: String = tag.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(hex, "9fd8b5d705aff8adbbf167caa11d9a36");
}

#[test]
fn a_key_comes_from_a_file_that_its_owner_alone_can_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("key");
    let made = Key::create(&path).unwrap();
    assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
    assert_eq!(Key::load(&path).unwrap().id(), made.id());
    assert!(!std::fs::read_to_string(&path).unwrap().contains(made.id()), "the id tells nothing");
    assert!(matches!(Key::create(&path), Err(KeyError::File { .. })), "never overwritten");
    for mode in [0o640, 0o604, 0o660, 0o602] {
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(mode)).unwrap();
        let error = Key::load(&path).unwrap_err();
        assert!(matches!(error, KeyError::Rights { mode: found, .. } if found == mode), "{error}");
    }
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o400)).unwrap();
    assert!(Key::load(&path).is_ok());
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o600)).unwrap();
    for text in ["", "lmpc-key-1", "lmpc-key-1 00", &format!("lmpc-key-1 {}", "0g".repeat(32))] {
        std::fs::write(&path, text).unwrap();
        assert!(matches!(Key::load(&path), Err(KeyError::Form { .. })), "{text}");
    }
    assert!(matches!(Key::load(folder.path()), Err(KeyError::File { .. })), "a folder");
}
