#![allow(clippy::unwrap_used, reason = "code of tests")]

use lcm_types::{
    ActuationReport, Frenet, Header, Heartbeat, MpcTelemetry, OperatorAck, OperatorCommand, Track,
    VehicleState, channels,
};

use super::*;
use network_watch::Watch;

const MS: i64 = 1_000_000;

fn header(sender: &str, seq: i64) -> Header {
    Header { sender: format!("{sender}@here"), seq, boot_id: 7, ..Header::default() }
}

fn sealed(message: &impl lcm_types::Checked) -> Vec<u8> {
    let mut bytes = Vec::new();
    message.seal_into(&mut bytes).unwrap();
    bytes
}

fn plain(message: &impl lcm_types::Message) -> Vec<u8> {
    let mut bytes = Vec::new();
    message.encode_into(&mut bytes).unwrap();
    bytes
}

/// Ten metres straight to the east, then a left turn to the north.
fn track() -> Track {
    Track {
        h: header("lmpc", 0),
        track_id: 3,
        name: "bend".to_owned(),
        length: 20.0,
        n: 3,
        s: vec![0.0, 5.0, 10.0],
        x: vec![0.0, 5.0, 10.0],
        y: vec![0.0, 0.0, 0.0],
        yaw: vec![0.0, 0.0, 0.5],
        kappa: vec![0.0, 0.0, 0.5],
        w_left: vec![0.5, 0.6, 0.7],
        w_right: vec![0.8, 0.9, 1.0],
        ..Track::default()
    }
}

fn state(seq: i64) -> VehicleState {
    VehicleState {
        h: header("bridge", seq),
        quality: 2,
        valid: VehicleState::POSE | VehicleState::VEL | VehicleState::FRENET,
        x: 6.0,
        y: 0.25,
        vx: 2.5,
        frenet: Frenet { s: 6.0, e_y: 0.25, track_id: 3, lap: 4, ..Frenet::default() },
        ..VehicleState::default()
    }
}

fn busy() -> Watch {
    let mut watch = Watch::default();
    watch.take(channels::TRACK, &sealed(&track()), 0);
    for n in 0..100 {
        // One in ten is lost on the way.
        if n % 10 != 5 {
            watch.take(channels::STATE, &sealed(&state(n)), n * 10 * MS);
        }
    }
    let report = ActuationReport {
        h: header("bridge", 0),
        source: ActuationReport::PLAN,
        accel: -1.5,
        limited: ActuationReport::ACCELERATION_RATE | ActuationReport::SPEED_CAP,
        ..Default::default()
    };
    watch.take(channels::ACTUATION, &sealed(&report), 980 * MS);
    let detail = "2 ticks missed; a command was refused".to_owned();
    let beat = Heartbeat {
        h: header("bridge", 1),
        state: Heartbeat::RUNNING,
        stop_reason: Heartbeat::STOP_COMMANDS,
        arm_token: 9,
        rx_stale: 11,
        detail,
        ..Default::default()
    };
    watch.take("HB/bridge", &plain(&beat), 900 * MS);
    let beat = Heartbeat { h: header("lmpc", 1), state: Heartbeat::IDLE, ..Default::default() };
    watch.take("HB/lmpc", &plain(&beat), 0);
    let order = OperatorCommand {
        h: header("operator", 0),
        command: OperatorCommand::START,
        request_id: 5,
        deadman: true,
        ..Default::default()
    };
    watch.take(channels::OPERATOR, &sealed(&order), 500 * MS);
    let ack = OperatorAck {
        h: header("bridge", 1),
        request_id: 5,
        detail: "not armed".to_owned(),
        ..Default::default()
    };
    watch.take(channels::OPERATOR_ACK, &plain(&ack), 510 * MS);
    let step = MpcTelemetry {
        h: header("lmpc", 3),
        total_us: 25_000,
        deadline_us: 100_000,
        overruns: 1,
        action: MpcTelemetry::RECOVERING,
        reason: MpcTelemetry::OFF_TRACK,
        grip: [0.9, 0.8],
        road_grip: 0.75,
        delay: 0.043,
        lag: 0.1,
        response_found: true,
        delay_change: 0.1,
        filtered: true,
        state_sigma: [0.0, 0.0, 0.0, 0.002, 0.0, 0.003],
        noise_sigma: [0.0, 0.0, 0.0, 0.011, 0.0, 0.012],
        ..Default::default()
    };
    watch.take(channels::TELEMETRY, &plain(&MpcTelemetry { total_us: 60_000, ..step.clone() }), 0);
    watch.take(channels::TELEMETRY, &plain(&step), 0);
    watch.take("CAR/OWN", b"whatever", 0);
    watch.take(channels::COMMAND, b"no command", 0);
    watch
}

#[test]
fn a_snapshot_says_what_was_heard() {
    let seen = busy().snapshot(1000 * MS);
    let car = seen.car.as_ref().unwrap();
    assert_eq!((car.s_m, car.e_y_m, car.lap), (Some(6.0), Some(0.25), 4));
    let (left, right) = car.width_m.unwrap();
    assert!((left - 0.6).abs() < 1e-6 && (right - 0.9).abs() < 1e-6);
    assert_eq!((car.driven_by.as_str(), car.limited), ("plan", 0x18));
    assert_eq!(seen.last_stop.as_deref(), Some("no valid command in time"));
    let [bridge, lmpc] = &seen.programs[..] else { unreachable!("{:?}", seen.programs) };
    assert_eq!((bridge.state.as_str(), bridge.alive, bridge.stale), ("RUNNING", true, 11));
    assert!(!lmpc.alive, "its heartbeat is a second old");
    let order = seen.order.as_ref().unwrap();
    assert_eq!((order.order.as_str(), order.deadman, order.answers.len()), ("start", true, 1));
    let step = seen.step.as_ref().unwrap();
    assert_eq!((step.total_ms, step.worst_ms, step.overruns), (25.0, 60.0, 1));
    let channel = |name: &str| seen.channels.iter().find(|c| c.name == name).unwrap();
    let states = channel("CAR/STATE");
    assert_eq!((states.count, states.lost, states.senders), (90, 10, 1));
    assert!((states.rate_hz - 89.0 / 0.99).abs() < 1e-9, "{states:?}");
    assert_eq!(channel("CAR/OWN").unreadable, 0);
    assert_eq!(channel("LMPC/CMD").unreadable, 1);
}

#[test]
fn a_car_that_only_says_its_pose_is_found_on_the_track() {
    let mut watch = busy();
    let mut pose = state(200);
    pose.valid = VehicleState::POSE | VehicleState::VEL;
    watch.take(channels::STATE, &sealed(&pose), 1000 * MS);
    let car = watch.snapshot(1000 * MS).car.unwrap();
    assert!((car.s_m.unwrap() - 6.0).abs() < 1e-6 && (car.e_y_m.unwrap() - 0.25).abs() < 1e-6);
}

#[test]
fn the_view_fits_its_width_and_shows_the_car_where_it_is() {
    let seen = busy().snapshot(1000 * MS);
    for width in [60, 80, 120] {
        let lines: Vec<String> = draw(&seen, "a title", width)
            .iter()
            .map(|line| anstream::adapter::strip_str(line).to_string())
            .collect();
        for line in &lines {
            assert!(line.chars().count() <= width, "{width}: {line}");
        }
        // 6 of 20 m; the last third of the points, and so of the strip, turns left.
        let strip: Vec<char> = lines[2].chars().collect();
        let cells = (strip.len() - 2) as f64;
        let at = strip.iter().position(|c| *c == '●').unwrap() as f64 - 1.0;
        assert!((at - 0.3 * cells).abs() <= 1.0, "{}", lines[2]);
        assert!(lines[2].ends_with("((|") && lines[2].starts_with("|--"), "{}", lines[2]);
        let all = lines.join("\n");
        for word in [
            "RUNNING",
            "silent",
            "jerk, speed cap",
            "last stop: no valid command",
            "e_y +0.250 m",
            "recovering (off track)",
            "grip 0.90 0.80 of nominal, road 0.75  delay 43 ms, lag 100 ms estimated",
            "filter 3 mm 2 mrad of 12 mm 11 mrad",
            "commands act 100 ms later",
        ] {
            assert!(all.contains(word) || width < 120, "{word} in {all}");
        }
    }
}

#[test]
fn nothing_heard_is_said() {
    let all = draw(&Watch::default().snapshot(0), "", 80).join("\n");
    assert!(all.contains("nothing is said") && all.contains("no state of the car"), "{all}");
}

#[test]
fn actions_and_reasons_have_one_code_and_one_name() {
    use controller::{Action, Reason};
    use network_watch::{action_name, reason_name};
    use racing::words::{action_word, reason_word};
    let code = |code: u8| i8::try_from(code).unwrap();
    for action in [
        Action::WarmUp,
        Action::Learned,
        Action::ShiftedPlan,
        Action::Tracking,
        Action::Braking,
        Action::Recovering,
    ] {
        assert_eq!(action_name(code(action.code())), action_word(action));
    }
    for reason in [
        Reason::None,
        Reason::SolverFailed,
        Reason::NonFinite,
        Reason::TimeNotAdvancing,
        Reason::TimeGap,
        Reason::Jump,
        Reason::OffTrack,
        Reason::WrongWay,
        Reason::Standstill,
        Reason::NoSafeSet,
        Reason::Spin,
        Reason::Askew,
    ] {
        assert_eq!(reason_name(code(reason.code())), reason_word(reason));
    }
}
