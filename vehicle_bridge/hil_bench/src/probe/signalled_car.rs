//! `lmpc vehicle car` ended by a signal while a car with messages of its own drives: it stands afterwards.

use std::fs;
use std::path::Path;
use std::process::Child;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use lcm_types::schema::Schema;
use lcm_types::value::{Path as Field, Value};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use transport::{Filter, Inbox};

use super::Measured;
use super::damaged_log::start;
use crate::fault::EndSignal;
use crate::process::{ended, signal_of};

/// The example's map and types.
const FILES: [(&str, &str); 3] = [
    ("car.toml", include_str!("../../../../examples/lcm/car.toml")),
    ("bot_core.lcm", include_str!("../../../../examples/lcm/bot_core.lcm")),
    ("driving.lcm", include_str!("../../../../examples/lcm/driving.lcm")),
];
const POSE: &str = "bot_core.pose_t";
const COMMAND: &str = "example.driving_command_t";
const PERIOD: Duration = Duration::from_millis(20);
const PATIENCE: Duration = Duration::from_secs(10);
/// Full pedal, as the map has it. \[m/s^2\]
const PEDAL: f64 = 2.0;
/// The signal comes at this speed. \[m/s\]
const FAST: f64 = 1.0;
/// Driven on after the program's end, with the last command received.
const AFTER: Duration = Duration::from_secs(2);

/// A car on a straight line: speed by its pedals, which stay where the last command left them.
struct ForeignCar {
    schema: Schema,
    x: f64,
    v_x: f64,
    throttle: f64,
    brake: f64,
    utime: i64,
}

impl ForeignCar {
    fn pose(&self) -> Result<Vec<u8>> {
        let mut message = self.schema.zero(POSE)?;
        for (name, value) in [
            ("utime", Value::Integer(self.utime)),
            ("pos[0]", Value::Double(self.x)),
            ("vel[0]", Value::Double(self.v_x)),
            ("orientation[0]", Value::Double(1.0)),
        ] {
            let field = Field::parse(&self.schema, POSE, name)?;
            *field.get_mut(&mut message).context(name)? = value;
        }
        let mut bytes = Vec::new();
        self.schema.encode_into(POSE, &message, &mut bytes)?;
        Ok(bytes)
    }

    fn obey(&mut self, bytes: &[u8]) -> Result<()> {
        let message = self.schema.decode(COMMAND, bytes)?;
        let number = |name: &str| -> Result<f64> {
            let field = Field::parse(&self.schema, COMMAND, name)?;
            field.get(&message).and_then(Value::number).context(name.to_owned())
        };
        (self.throttle, self.brake) = (number("throttle")?, number("brake")?);
        Ok(())
    }

    fn drive(&mut self, dt: f64) {
        self.v_x = (self.v_x + PEDAL * (self.throttle - self.brake) * dt).max(0.0);
        self.x += self.v_x * dt;
        self.utime += 20_000;
    }
}

/// Drives such a car on the network `url`, ends `lmpc vehicle car` by the signal and drives on.
///
/// # Errors
/// If a program cannot be started, or the car is not driven.
pub fn run(dir: &Path, url: &str, signal: EndSignal) -> Result<Measured> {
    for (name, text) in FILES {
        fs::write(dir.join(name), text).with_context(|| format!("cannot write {name}"))?;
    }
    let types = [FILES[1], FILES[2]];
    let schema = Schema::parse(&types).context("the example's types")?;
    let map = dir.join(FILES[0].0).display().to_string();
    let mut bridge = start(&["vehicle", "car", "--map", &map, "--url", url])?;
    let driver = start(&["hil", "drive", "--url", url]);
    let driven = driver.and_then(|mut driver| {
        let driven = drive(schema, &mut bridge, url, signal_of(signal));
        driver.kill()?;
        driver.wait()?;
        driven
    });
    // It may have ended.
    let _ = bridge.kill();
    let code = ended(bridge.wait()?);
    let (car, way) = driven?;
    let thousandths = |x: f64| (x * 1e3).round().abs() as u64;
    Ok(vec![
        ("speed_at_the_end_mmps", thousandths(car.v_x)),
        ("last_throttle_permille", thousandths(car.throttle)),
        ("last_brake_permille", thousandths(car.brake)),
        ("stop_distance_mm", thousandths(way)),
        ("bridge_exit_code", code.unsigned_abs().into()),
    ])
}

/// The car at the end, and its way from the signal on. \[m\]
fn drive(
    schema: Schema,
    bridge: &mut Child,
    url: &str,
    signal: Signal,
) -> Result<(ForeignCar, f64)> {
    let network = transport::open(url, None)?;
    let commands = Inbox::queue(64);
    network.subscribe(Filter::channel("DRIVING_COMMAND"), commands.sink())?;
    let mut car = ForeignCar { schema, x: 0.0, v_x: 0.0, throttle: 0.0, brake: 1.0, utime: 1 };
    let (mut begun, mut signalled_at, mut since) = (Instant::now(), None, None);
    let mut due = Instant::now();
    while since.is_none_or(|since: Instant| since.elapsed() < AFTER) {
        network.publish("POSE", &car.pose()?)?;
        due += PERIOD;
        while let Some(received) = commands.wait_until(due) {
            car.obey(&received.payload)?;
        }
        car.drive(PERIOD.as_secs_f64());
        if signalled_at.is_none() && car.v_x >= FAST {
            kill(Pid::from_raw(bridge.id().cast_signed()), signal)?;
            (signalled_at, begun) = (Some(car.x), Instant::now());
        }
        if signalled_at.is_some() && since.is_none() && bridge.try_wait()?.is_some() {
            since = Some(Instant::now());
        }
        if since.is_none() && begun.elapsed() > PATIENCE {
            bail!("after {PATIENCE:?}: {:.2} m/s, signalled: {}", car.v_x, signalled_at.is_some());
        }
    }
    let way = signalled_at.map_or(0.0, |from| car.x - from);
    Ok((car, way))
}
