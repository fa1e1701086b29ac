//! Messages as a drive makes them, for the tools that look at a network: `lcm_traffic SECONDS` sends
//! states at 100 Hz, commands at 50 Hz and heartbeats at 10 Hz on the network of `LCM_DEFAULT_URL`.

use std::error::Error;
use std::time::Duration;

use lcm_types::{ActuationCommand, Checked, Header, Heartbeat, Message, VehicleState, channels};
use transport::Transport;

fn main() -> Result<(), Box<dyn Error>> {
    let seconds: i64 = std::env::args().nth(1).ok_or("expected SECONDS")?.parse()?;
    let url = std::env::var("LCM_DEFAULT_URL").unwrap_or(transport::DEFAULT_URL.to_owned());
    let network = transport::open(&url, None)?;
    let mut bytes = Vec::new();
    for tick in 0..seconds * 100 {
        send(&*network, tick, &mut bytes)?;
        std::thread::sleep(Duration::from_millis(10));
    }
    Ok(())
}

/// A car on a circle of 5 m radius at 2 m/s.
fn send(network: &dyn Transport, tick: i64, bytes: &mut Vec<u8>) -> Result<(), Box<dyn Error>> {
    let now = transport::now();
    let header = |seq| Header {
        utime: now.utime,
        mono_ns: now.mono.as_ns(),
        seq,
        boot_id: 1,
        sender: "traffic@example".to_owned(),
    };
    let (t, radius, speed) = (tick as f64 * 0.01, 5.0, 2.0);
    let angle = speed * t / radius;
    let state = VehicleState {
        h: header(tick),
        valid: VehicleState::POSE | VehicleState::VEL,
        quality: 2,
        x: radius * angle.sin(),
        y: radius * (1.0 - angle.cos()),
        yaw: angle,
        vx: speed,
        yaw_rate: speed / radius,
        ..VehicleState::default()
    };
    state.seal_into(bytes)?;
    network.publish(channels::STATE, bytes)?;
    if tick % 2 == 0 {
        let mode = ActuationCommand::MODE_DRIVE;
        let command = ActuationCommand { h: header(tick / 2), mode, ..Default::default() };
        command.seal_into(bytes)?;
        network.publish(channels::COMMAND, bytes)?;
    }
    if tick % 10 == 0 {
        let state = Heartbeat::RUNNING;
        let heartbeat =
            Heartbeat { h: header(tick / 10), state, uptime_s: t, ..Default::default() };
        heartbeat.encode_into(bytes)?;
        network.publish(&format!("{}traffic", channels::HEARTBEAT), bytes)?;
    }
    Ok(())
}
