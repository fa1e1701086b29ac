//! Commands as bytes, from the encoder of `lcm_types`, damaged on purpose.

use lcm_types::{ActuationCommand, Checked as _, Header, Message as _, crc};

use super::*;

const NOW: i64 = 10_000 * MS;
const HERE: &str = "here";
const BRIDGE: BootId = BootId::new(5);

fn rules_here() -> Rules {
    Rules { boot_id: BRIDGE, ..rules() }
}

fn command() -> ActuationCommand {
    ActuationCommand {
        h: Header {
            boot_id: CONTROLLER.get(),
            seq: 1,
            mono_ns: NOW - 4 * MS,
            sender: "lmpc@there".to_owned(),
            ..Header::default()
        },
        state_boot_id: BRIDGE.get(),
        state_seq: 7,
        state_mono_ns: NOW - 9 * MS,
        valid_for_us: 250_000,
        arm_token: 42,
        enable: true,
        mode: ActuationCommand::MODE_DRIVE,
        accel: 0.5,
        steer: 0.25,
        plan_dt: 0.5,
        plan_accel: vec![0.75, -1.0],
        plan_steer: vec![0.125, -0.25],
        ..ActuationCommand::default()
    }
}

fn bytes(command: &ActuationCommand) -> Vec<u8> {
    let mut command = command.clone();
    command.n_plan = i16::try_from(command.plan_accel.len()).unwrap();
    let mut bytes = Vec::new();
    command.seal_into(&mut bytes).unwrap();
    bytes
}

/// A core that runs by the grant 42 since `NOW`, after command number 0.
fn running(rules: &Rules) -> Safety {
    let order = |kind| Order { kind, token: token(42), deadman: false, fresh: token(42) };
    let first = DecodedCommand {
        boot_id: CONTROLLER,
        token: token(42),
        valid_for_ns: MS,
        ..DecodedCommand::default()
    };
    let first = DecodedCommand { arrival: time(NOW), since: time(NOW), ..first };
    let events = [
        (BridgeEvent::State(State::default(), 2), NOW - 100 * MS),
        (BridgeEvent::State(State::default(), 2), NOW),
        (BridgeEvent::Heartbeat(CONTROLLER), NOW),
        (BridgeEvent::Setup(CONTROLLER, rules.setup), NOW),
        (BridgeEvent::Published(number(6)), NOW - 9 * MS),
        (BridgeEvent::Published(number(7)), NOW - 8 * MS),
        (
            BridgeEvent::Order(order(OrderKind::Arm { moving: false, controller: BootId::NONE })),
            NOW,
        ),
        (BridgeEvent::Order(order(OrderKind::Start)), NOW),
        (BridgeEvent::Command(&first), NOW),
    ];
    let mut safety = Safety::default();
    for (event, now) in events {
        let (next, output) = step(rules, &safety, &event, now);
        assert!(!matches!(output.answer, Answer::Denied(_) | Answer::Rejected(_)), "{output:?}");
        safety = next;
    }
    assert_eq!(safety.bridge_state(), BridgeState::Running);
    safety
}

/// Everything a command goes through.
fn receive(bytes: &[u8]) -> Result<(), Reject> {
    let rules = rules_here();
    let offer = decode(bytes, time(NOW), &rules, HERE)?;
    let (safety, output) = step(&rules, &running(&rules), &BridgeEvent::Command(&offer), NOW);
    match output.answer {
        Answer::Rejected(reject) => {
            assert_eq!(safety.command(), None, "refused, yet in force");
            Err(reject)
        }
        _ => {
            assert_eq!(safety.command(), Some((CONTROLLER, offer.seq)));
            Ok(())
        }
    }
}

#[test]
fn a_whole_command_becomes_the_offer_it_says() {
    let offer = decode(&bytes(&command()), time(NOW), &rules_here(), HERE).unwrap();
    let mut plan = [Input::default(); PLAN];
    plan[0] = Input { a: 0.75, delta: 0.125 };
    plan[1] = Input { a: -1.0, delta: -0.25 };
    let expected = DecodedCommand {
        boot_id: CONTROLLER,
        seq: number(1),
        arrival: time(NOW),
        since: time(NOW - 9 * MS),
        answers: Some(number(7)),
        token: token(42),
        drives: true,
        estop: false,
        input: Input { a: 0.5, delta: 0.25 },
        valid_for_ns: 250 * MS,
        plan,
        n_plan: 2,
        plan_dt: 0.5,
    };
    assert_eq!(offer, expected);
    assert_eq!(receive(&bytes(&command())), Ok(()));
}

#[test]
fn it_drives_only_if_it_says_both() {
    let drives = |enable, mode| {
        let bytes = bytes(&ActuationCommand { enable, mode, ..command() });
        let offer = decode(&bytes, time(NOW), &rules_here(), HERE).unwrap();
        (offer.drives, offer.estop)
    };
    assert_eq!(drives(true, ActuationCommand::MODE_DRIVE), (true, false));
    assert_eq!(drives(false, ActuationCommand::MODE_DRIVE), (false, false));
    assert_eq!(drives(true, ActuationCommand::MODE_OFF), (false, false));
    assert_eq!(drives(true, ActuationCommand::MODE_SAFE_STOP), (false, false));
    assert_eq!(drives(true, ActuationCommand::MODE_ESTOP), (false, true));
}

#[test]
fn a_long_plan_is_cut_at_what_is_kept() {
    let plan = vec![0.5; 40];
    let (plan_accel, plan_steer) = (plan.clone(), plan);
    let bytes = bytes(&ActuationCommand { plan_accel, plan_steer, ..command() });
    let offer = decode(&bytes, time(NOW), &rules_here(), HERE).unwrap();
    assert_eq!((offer.n_plan, offer.plan().len()), (PLAN, PLAN));
}

#[test]
fn wrong_sizes() {
    let whole = bytes(&command());
    for length in 0..12 {
        assert_eq!(receive(&whole[..length]), Err(Reject::Size), "{length}");
    }
    assert_eq!(receive(&[0; 4097]), Err(Reject::Size));
    // Sizes that may be are looked into.
    assert_eq!(receive(&whole[..12]), Err(Reject::Crc));
    assert_eq!(receive(&[0; 4096]), Err(Reject::Fingerprint));
}

#[test]
fn another_type_is_named_before_its_checksum_is() {
    let mut other = bytes(&command());
    other[7] ^= 1;
    assert_eq!(receive(&other), Err(Reject::Fingerprint));
    crc::seal(&mut other);
    assert_eq!(receive(&other), Err(Reject::Fingerprint));
}

#[test]
fn a_flipped_bit_or_a_cut_end_anywhere() {
    let whole = bytes(&command());
    for bit in 64..8 * whole.len() {
        let mut flipped = whole.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(receive(&flipped), Err(Reject::Crc), "bit {bit}");
    }
    for length in 12..whole.len() {
        let mut cut = whole[..length].to_vec();
        assert_eq!(receive(&cut), Err(Reject::Crc), "{length}");
        // Also with a checksum that fits.
        crc::seal(&mut cut);
        assert_eq!(receive(&cut), Err(Reject::Crc), "{length}, sealed");
    }
    let mut longer = whole;
    longer.push(0);
    crc::seal(&mut longer);
    assert_eq!(receive(&longer), Err(Reject::Crc));
}

#[test]
fn ages_by_every_stamp_of_this_host_and_none_of_another() {
    let aged = |sender: &str, boot: BootId, sent_ms: i64, state_ms: i64| {
        let mut c = command();
        c.h.sender = sender.to_owned();
        (c.h.mono_ns, c.state_mono_ns) = (NOW - sent_ms * MS, NOW - state_ms * MS);
        c.state_boot_id = boot.get();
        receive(&bytes(&c))
    };
    let stale = Err(Reject::Stale);
    assert_eq!(aged("lmpc@here", BRIDGE, 100, 100), Ok(()));
    assert_eq!(aged("lmpc@here", BRIDGE, 101, 0), stale, "its own stamp");
    assert_eq!(aged("lmpc@there", BRIDGE, 101, 0), Ok(()), "another host's clock");
    assert_eq!(aged("lmpc@there", BRIDGE, 0, 101), stale, "the state it answers");
    assert_eq!(
        aged("lmpc@there", BootId::new(6), 0, 101),
        Err(Reject::Unanswered),
        "another bridge's"
    );
    // A stamp from the future makes nothing younger.
    let offer = |c: &ActuationCommand| decode(&bytes(c), time(NOW), &rules_here(), HERE).unwrap();
    let mut c = command();
    (c.h.sender, c.h.mono_ns, c.state_mono_ns) = ("lmpc@here".to_owned(), NOW + MS, NOW + MS);
    assert_eq!(offer(&c).since, time(NOW));
}

#[test]
fn each_check_names_what_it_found() {
    type Damage = fn(&mut ActuationCommand);
    let cases: [(Damage, Reject); 23] = [
        (|c| c.accel = f64::NAN, Reject::NotFinite),
        (|c| c.steer = f64::INFINITY, Reject::NotFinite),
        (|c| c.plan_accel[1] = f32::NAN, Reject::NotFinite),
        (|c| c.plan_steer[0] = f32::NEG_INFINITY, Reject::NotFinite),
        (|c| c.plan_dt = f32::NAN, Reject::NotFinite),
        (|c| c.accel = 100.0, Reject::Range),
        (|c| c.accel = -100.0, Reject::Range),
        (|c| c.steer = 1.0, Reject::Range),
        (|c| c.steer = -1.0, Reject::Range),
        (|c| c.plan_accel[1] = 100.0, Reject::Range),
        (|c| c.plan_dt = -0.1, Reject::Range),
        (|c| c.valid_for_us = 0, Reject::Range),
        (|c| c.valid_for_us = -1, Reject::Range),
        (|c| c.valid_for_us = 8_000, Reject::Stale),
        (|c| c.h.boot_id = OTHER.get(), Reject::Boot),
        (|c| c.h.seq = 0, Reject::Sequence),
        (|c| c.h.seq = 101, Reject::Sequence),
        (|c| c.arm_token = 41, Reject::Token),
        (|c| c.state_boot_id = 6, Reject::Unanswered),
        (|c| c.state_boot_id = 0, Reject::Unanswered),
        (|c| c.state_seq = 8, Reject::Unanswered),
        (|c| c.state_seq = 5, Reject::Unanswered),
        (|c| c.state_seq = -121, Reject::Unanswered),
    ];
    for (n, (damage, expected)) in cases.into_iter().enumerate() {
        let mut c = command();
        damage(&mut c);
        assert_eq!(receive(&bytes(&c)), Err(expected), "case {n}");
        // What is checked before is named before.
        c.plan_dt = f32::NAN;
        assert_eq!(receive(&bytes(&c)), Err(Reject::NotFinite), "case {n}");
    }
    let mut c = command();
    c.h.seq = 100;
    assert_eq!(receive(&bytes(&c)), Ok(()), "the end of the window");
    assert_eq!(ActuationCommand::NAME, "lmpc.actuation_command_t");
}
