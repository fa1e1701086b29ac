//! A publisher and a subscriber on the transport: the Rust side of the latency and loss
//! measurement. The C side, `tests/interop/lcm_load.c`, speaks the same.
//!
//! `lcm_load sub` takes messages on the receiving thread, `lcm_load inbox` through an inbox, and both
//! print `received lost p50 p99 max`, latencies in µs. `lcm_load pub COUNT RATE SIZE` sends. The
//! network is that of `LCM_LOAD_URL`.

use std::error::Error;
use std::io::Write;
use std::sync::mpsc::channel;
use std::time::Duration;

use nix::sys::time::TimeSpec;
use nix::time::{ClockId, ClockNanosleepFlags, clock_nanosleep};
use transport::{Filter, Inbox, ReceivedMessage, Transport};

fn main() -> Result<(), Box<dyn Error>> {
    let url = std::env::var("LCM_LOAD_URL").unwrap_or_else(|_| transport::DEFAULT_URL.to_owned());
    #[cfg(feature = "liblcm")]
    transport::liblcm::enter_environment(&url)?;
    let network = transport::open(&url, None)?;
    for warning in network.warnings() {
        writeln!(std::io::stderr(), "warning: {warning}")?;
    }
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["sub"] => subscribe(&*network),
        ["inbox"] => inbox(&*network),
        ["pub", count, rate, size] => {
            publish(&*network, count.parse()?, rate.parse()?, size.parse()?)
        }
        _ => Err("expected sub, inbox, or pub COUNT RATE SIZE (12 or more)".into()),
    }
}

/// What a subscriber saw.
#[derive(Default)]
struct Seen {
    latency_us: Vec<f64>,
    highest: u32,
}

impl Seen {
    /// Counts a message: its number, its time of sending, and padding.
    fn add(&mut self, payload: &[u8]) {
        let now = transport::now().mono.as_ns();
        let Some((number, rest)) = payload.split_first_chunk() else { return };
        let Some(sent) = rest.first_chunk() else { return };
        self.latency_us.push((now - i64::from_ne_bytes(*sent)) as f64 / 1000.0);
        self.highest = self.highest.max(u32::from_ne_bytes(*number));
    }

    fn print(mut self) -> Result<(), Box<dyn Error>> {
        let received = self.latency_us.len();
        if received == 0 {
            return Err("nothing received".into());
        }
        self.latency_us.sort_by(f64::total_cmp);
        let lost = self.highest as usize + 1 - received;
        let at = |share: usize| self.latency_us[(received * share / 100).min(received - 1)];
        let (p50, p99, max) = (at(50), at(99), at(100));
        Ok(writeln!(std::io::stdout(), "{received} {lost} {p50:.1} {p99:.1} {max:.1}")?)
    }
}

fn subscribe(network: &dyn Transport) -> Result<(), Box<dyn Error>> {
    let (end, ended) = channel();
    let mut seen = Seen::default();
    let sink = move |message: &ReceivedMessage<'_>| match message.channel {
        "LOAD" => seen.add(message.payload),
        // The main thread is gone after the first end: nobody is left to be told.
        _ => drop(end.send(std::mem::take(&mut seen))),
    };
    let channels = Filter::Only(vec!["LOAD".to_owned(), "LOAD_END".to_owned()]);
    network.subscribe(channels, Box::new(sink))?;
    ended.recv()?.print()
}

fn inbox(network: &dyn Transport) -> Result<(), Box<dyn Error>> {
    let messages = Inbox::queue(100_000);
    let channels = Filter::Only(vec!["LOAD".to_owned(), "LOAD_END".to_owned()]);
    network.subscribe(channels, messages.sink())?;
    let mut seen = Seen::default();
    while let Some(received) = messages.wait(Duration::from_secs(60)) {
        if received.channel == "LOAD_END" {
            return seen.print();
        }
        seen.add(&received.payload);
        messages.recycle(received);
    }
    Err("no message for 60 s".into())
}

fn publish(
    network: &dyn Transport,
    count: u32,
    rate: f64,
    size: usize,
) -> Result<(), Box<dyn Error>> {
    let mut message = vec![0; size.max(12)];
    let begin = transport::now().mono.as_ns();
    for number in 0..count {
        let due = begin + (f64::from(number) * 1e9 / rate) as i64;
        let due = TimeSpec::new(due / 1_000_000_000, due % 1_000_000_000);
        clock_nanosleep(ClockId::CLOCK_MONOTONIC, ClockNanosleepFlags::TIMER_ABSTIME, &due)?;
        message[..4].copy_from_slice(&number.to_ne_bytes());
        message[4..12].copy_from_slice(&transport::now().mono.as_ns().to_ne_bytes());
        network.publish("LOAD", &message)?;
    }
    for _ in 0..5 {
        std::thread::sleep(Duration::from_millis(100));
        network.publish("LOAD_END", &[])?;
    }
    Ok(())
}
