//! A bridge that a busy computer holds up between the tick that makes an input and the car.
#![allow(clippy::unwrap_used, reason = "code of tests")]

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use hosting::shutdown::Shutdown;
use lcm_types::{ActuationReport, Checked as _, channels};
use safety::Rules;
use services::bridge::Bridge;
use services::map_file;
use services::side::CarSide;
use transport::{Error, Filter, Sink, Statistics, Transport};
use vehicle_model::{CarParams, Track};

/// Jerk at which the brake takes longer than the test to be pressed. \[m/s^3\]
const JERK: f64 = 0.2;
/// Reports that are looked at.
const REPORTS: usize = 60;

/// Passes every second message to the car on late; keeps the reports.
struct Late {
    car: String,
    sent: AtomicUsize,
    reports: Mutex<Vec<ActuationReport>>,
    stop: Shutdown,
}

impl Transport for Late {
    fn publish(&self, channel: &str, payload: &[u8]) -> Result<(), Error> {
        if channel == self.car && self.sent.fetch_add(1, Ordering::Relaxed).is_multiple_of(2) {
            std::thread::sleep(Duration::from_millis(6));
        }
        if channel == channels::ACTUATION {
            let mut reports = self.reports.lock().unwrap();
            reports.push(ActuationReport::open(payload).unwrap());
            if reports.len() >= REPORTS {
                self.stop.request();
            }
        }
        Ok(())
    }

    fn subscribe(&self, _: Filter, _: Box<dyn Sink>) -> Result<(), Error> {
        Ok(())
    }

    fn statistics(&self) -> Statistics {
        Statistics::default()
    }

    fn warnings(&self) -> &[String] {
        &[]
    }
}

#[test]
fn what_the_car_gets_late_is_not_followed_faster_than_it_may_be() {
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/lcm/car.toml");
    let mapping = map_file::load(&map).unwrap();
    let late = Arc::new(Late {
        car: mapping.command_channel().to_owned(),
        sent: AtomicUsize::new(0),
        reports: Mutex::default(),
        stop: Shutdown::default(),
    });
    let network: Arc<dyn Transport> = Arc::<Late>::clone(&late);
    let track = Arc::new(Track::builtin("l").unwrap());
    let mut car = CarParams::builtin("barc").unwrap();
    car.a_rate_max = Some(JERK);
    let rules = Rules::new(&car, &track, 50_000_000);
    let side = CarSide::mapped(mapping, &track, &network);
    // Nothing is known of the car: it is held, the brake pressed as fast as it may be.
    Bridge::new(rules, side, Vec::new(), &network).unwrap().run(&late.stop, &mut |_, _| {});
    let reports = late.reports.lock().unwrap();
    for pair in reports.windows(2) {
        let dt = (pair[1].h.mono_ns - pair[0].h.mono_ns) as f64 * 1e-9;
        let change = (pair[1].accel - pair[0].accel).abs();
        assert!(change <= JERK * dt + 1e-9, "{change} m/s^2 in {dt} s");
    }
    let (first, last) = (reports.first().unwrap(), reports.last().unwrap());
    let dt = (last.h.mono_ns - first.h.mono_ns) as f64 * 1e-9;
    assert!(first.accel - last.accel > 0.5 * JERK * dt, "it is pressed all the same");
}
