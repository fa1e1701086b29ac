//! What `lmpc view` shows besides a network: a log, or a race that it drives itself.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use controller::Controller;
use lcm_types::eventlog::EventReader;
use lcm_types::{MonoTime, channels};
use vehicle_model::{Plant, PlantParams, State};

use super::network::{PATIENCE, setup_message};
use super::view::{Audience, is_set, subscribe};
use command_line::ViewArgs;
use hosting::rule::FailureRule;
use live_view::Clock;
use racing::RaceOptions;
use services::car::{CarOptions, SimulatedCar};
use services::service::{Service, ServiceOptions};
use transport::{Arrival, Error, Filter, Local, Sink, Statistics, Transport};

/// A silence of a log longer than this is passed over. \[us\]
const SILENCE_US: i64 = 10_000_000;
/// Events at the start of a log among which its track and setup are looked for. \[-\]
const BEGINNING: usize = 20_000;
/// Longest sleep, so that signals are seen.
const NAP: Duration = Duration::from_millis(50);

/// A log that is played.
pub(super) struct Log {
    path: PathBuf,
    speed: f64,
    /// What lies before is shown at once. \[s\]
    ahead: f64,
    /// Its time now. \[ns\]
    now_ns: Arc<AtomicI64>,
}

impl Log {
    /// The log and the clock of what it shows.
    pub(super) fn open(path: &Path, speed: f64, ahead: f64) -> Result<(Self, Clock)> {
        File::open(path).with_context(|| format!("cannot read {}", path.display()))?;
        let now_ns = Arc::new(AtomicI64::new(0));
        let clock = Arc::clone(&now_ns);
        let log = Self { path: path.to_owned(), speed, ahead, now_ns };
        Ok((log, Box::new(move || clock.load(Ordering::Relaxed))))
    }

    pub(super) fn title(&self) -> String {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        if self.speed == 1.0 {
            format!("log {name}")
        } else {
            format!("log {name} x {}", self.speed)
        }
    }

    fn events(&self) -> Result<EventReader<BufReader<File>>> {
        let shown = self.path.display();
        let file = File::open(&self.path).with_context(|| format!("cannot read {shown}"))?;
        Ok(EventReader::new(BufReader::new(file)))
    }

    /// Shows every message when it is due.
    pub(super) fn play(&self, audience: &Audience, stop: &AtomicBool) -> Result<()> {
        self.prepare(audience)?;
        let mut events = self.events()?;
        let (mut begun, mut first) = (Instant::now(), None);
        let (mut last_us, mut ahead) = (0, self.ahead);
        while let Some(event) = events.next_event()? {
            let start = *first.get_or_insert(event.utime);
            if event.utime - last_us > SILENCE_US && last_us != 0 {
                // Over a silence at once: as if it had begun so much later.
                ahead -= (last_us - start).max(0) as f64 * 1e-6;
                (begun, first) = (Instant::now(), Some(event.utime));
            } else {
                let at = (event.utime - start).max(0) as f64 * 1e-6 - ahead.max(0.0);
                let due = begun + Duration::from_secs_f64(at.max(0.0) / self.speed);
                while let Some(left) = due.checked_duration_since(Instant::now()) {
                    if is_set(stop) {
                        return Ok(());
                    }
                    std::thread::sleep(left.min(NAP));
                }
            }
            if is_set(stop) {
                return Ok(());
            }
            last_us = event.utime;
            self.now_ns.store(arrival(event.utime).mono.as_ns(), Ordering::Relaxed);
            audience.take(&event.channel, &event.data, arrival(event.utime));
        }
        audience.end("end of the log");
        Ok(())
    }

    /// Track and setup are sent once a second: they are shown from the start.
    fn prepare(&self, audience: &Audience) -> Result<()> {
        let mut wanted = vec![channels::SETUP, channels::TRACK];
        let (mut events, mut first) = (self.events()?, None);
        for _ in 0..BEGINNING {
            let Some(event) = events.next_event()? else { break };
            let start = *first.get_or_insert(event.utime);
            let before = wanted.len();
            wanted.retain(|channel| *channel != event.channel);
            if wanted.len() < before {
                audience.take(&event.channel, &event.data, arrival(start));
            }
            if wanted.is_empty() {
                break;
            }
        }
        Ok(())
    }
}

/// When a message was logged; a log has one clock. \[us\]
fn arrival(utime: i64) -> Arrival {
    Arrival { utime, mono: MonoTime::from_ns(utime.saturating_mul(1000)) }
}

/// A race: the service and a simulated car in lock-step, on a network within this program.
pub(super) struct RaceSource {
    options: RaceOptions,
    setup: lcm_types::Setup,
    speed: f64,
}

impl RaceSource {
    pub(super) fn new(mut options: RaceOptions, args: &ViewArgs) -> Result<Self> {
        options.seed = args.seed;
        options.config.warm_up.seed = args.seed;
        let car = &options.plant.car.name;
        let setup = setup_message(&args.controller, &options.config, &options.track, car)?;
        Ok(Self { options, setup, speed: args.speed })
    }

    pub(super) fn title(&self) -> String {
        let (car, track) = (&self.options.plant.car.name, self.options.track.name());
        let faster = if self.speed == 1.0 { String::new() } else { format!(" x {}", self.speed) };
        format!("race of {car} on {track}, seed {}{faster}", self.options.seed)
    }

    pub(super) fn clock(&self) -> Clock {
        Box::new(|| transport::now().mono.as_ns())
    }

    /// Drives until the laps are done; each period takes as long as the speed says.
    pub(super) fn drive(self, audience: &Arc<Audience>, stop: &AtomicBool) -> Result<()> {
        let Self { options, setup, speed } = self;
        let period = options.config.horizon.period;
        let network: Arc<dyn Transport> = Arc::new(Paced {
            network: Local::default(),
            period: Duration::from_secs_f64(period / speed),
            begun: OnceLock::new(),
            periods: AtomicI64::new(0),
        });
        subscribe(&network, audience)?;
        let controller = Controller::new(
            options.config.clone(),
            options.nominal.clone(),
            Arc::clone(&options.track),
        )?;
        let service = ServiceOptions {
            dry_run: false,
            wait_for_start: false,
            valid_for: 1e3,
            notes: Vec::new(),
            setup,
            log: None,
            seal: None,
            overrun: None,
        };
        let mut service = Service::new(service, controller, None, &network)?;
        let start = State { v_x: options.config.warm_up.speed, ..State::default() };
        let plant = PlantParams { seed: options.seed, ..options.plant.clone() };
        let vehicle = Box::new(Plant::new(plant, Arc::clone(&options.track), start)?);
        let warm_up = u32::try_from(options.config.warm_up.laps).unwrap_or(u32::MAX);
        let car = CarOptions {
            period,
            lock_step: true,
            steps: None,
            laps: Some(warm_up.saturating_add(options.laps)),
            patience: PATIENCE,
        };
        let rule =
            FailureRule::new(&options.config, &options.track, &options.plant.car, options.limit);
        let mut car = SimulatedCar::new(car, vehicle, rule, &network)?;
        let over = Arc::new(AtomicBool::new(false));
        let served = Arc::clone(&over);
        let server = std::thread::Builder::new()
            .name("lmpc-service".to_owned())
            .spawn(move || service.run(&served, &mut |_, _| {}))?;
        let drive = car.run(stop, &mut |_, _, _| {});
        over.store(true, Ordering::Relaxed);
        // It ends by itself now; a panic in it has been printed.
        let _ = server.join();
        drive?;
        audience.end("race over");
        Ok(())
    }
}

/// A network on which the car's periods take time: it waits after the report that ends each.
struct Paced {
    network: Local,
    period: Duration,
    begun: OnceLock<Instant>,
    periods: AtomicI64,
}

impl Transport for Paced {
    fn publish(&self, channel: &str, payload: &[u8]) -> Result<(), Error> {
        self.network.publish(channel, payload)?;
        if channel == channels::ACTUATION {
            let begun = *self.begun.get_or_init(Instant::now);
            let periods = self.periods.fetch_add(1, Ordering::Relaxed);
            let due = begun + self.period.mul_f64(periods as f64);
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
        }
        Ok(())
    }

    fn subscribe(&self, filter: Filter, sink: Box<dyn Sink>) -> Result<(), Error> {
        self.network.subscribe(filter, sink)
    }

    fn statistics(&self) -> Statistics {
        self.network.statistics()
    }

    fn warnings(&self) -> &[String] {
        self.network.warnings()
    }
}
