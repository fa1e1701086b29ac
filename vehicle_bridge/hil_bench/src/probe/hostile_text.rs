//! Control sequences in the texts of messages: none may reach the terminal of `top` or `operator`.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use hosting::worker::Worker;
use lcm_types::{Checked as _, Heartbeat, OperatorAck, OperatorCommand, channels};
use protocol::publisher::{Identity, Publisher};
use transport::{Filter, Inbox, Transport};

use super::Measured;

/// What a sender puts into every text it can choose: a cleared screen, a title, a line written over, a
/// reversed direction of writing, the eighth-bit form of an escape.
const HOSTILE: &str = "\x1b[2J\x1b]0;taken\x07\x1b[3A\rall is well\u{202e}\u{9b}2J";
/// What must not be in any output.
const RAW: [&str; 6] = ["\x1b[2J", "\x1b]0;", "\x07", "\x1b[3A", "\u{202e}", "\u{9b}"];
/// How the first of them is shown.
const SHOWN: &str = "\\u{1b}[2J";
const PERIOD: Duration = Duration::from_millis(50);

/// Sends hostile texts on the network `url` and looks at what `top`, once and in a terminal, and
/// `operator` write.
///
/// # Errors
/// If the network cannot be joined or a program not be started.
pub fn run(dir: &Path, url: &str) -> Result<Measured> {
    let network = transport::open(url, None)?;
    let _sender = sender(&network)?;
    let lmpc = std::env::current_exe()?.display().to_string();
    let once = output(Command::new(&lmpc).args(["top", "--once", "--listen", "1", "--url", url]))?;
    let order = output(Command::new(&lmpc).args(["operator", "arm", "--url", url]))?;
    // In a terminal of its own, which `script` makes and copies to a file.
    let (file, view) = (dir.join("terminal"), format!("'{lmpc}' top --url '{url}'"));
    let view = format!("stty cols 200 rows 60; timeout --foreground -s INT 2 {view}");
    output(Command::new("script").args(["-q", "-c", &view]).arg(&file))?;
    let screen = fs::read(&file).with_context(|| format!("cannot read {}", file.display()))?;
    let screen = String::from_utf8_lossy(&screen).into_owned();
    let raw = |text: &str| RAW.iter().map(|raw| text.matches(raw).count() as u64).sum::<u64>();
    let shown = |text: &str| text.matches(SHOWN).count() as u64;
    Ok(vec![
        ("raw_once", raw(&once)),
        ("raw_operator", raw(&order)),
        ("raw_terminal", raw(&screen)),
        ("shown_once", shown(&once)),
        ("shown_operator", shown(&order)),
        ("shown_terminal", shown(&screen)),
    ])
}

/// A bridge and a controller whose every text is hostile; it refuses every order.
fn sender(network: &Arc<dyn Transport>) -> Result<Worker> {
    let identity = Identity { sender: format!("bridge{HOSTILE}@here"), ..Identity::new("bridge") };
    let of = |channel: &str| Publisher::new(network, &identity, channel);
    let mut beats = ["HB/bridge", "HB/lmpc"].map(of);
    let mut acks = of(channels::OPERATOR_ACK);
    // A channel's name is a text too.
    let mut other = of(&format!("X{}", &HOSTILE[..12]));
    let orders = Inbox::queue(16);
    network.subscribe(Filter::channel(channels::OPERATOR), orders.sink())?;
    let worker = Worker::start("hostile", move |stop| {
        while !stop.load(Ordering::Relaxed) {
            for publisher in beats.iter_mut().chain([&mut other]) {
                let h = publisher.header();
                let (state, detail) = (Heartbeat::IDLE, HOSTILE.to_owned());
                // A message that is not sent is missed by the counts of what was shown.
                let _ = publisher.send(&Heartbeat { h, state, detail, ..Heartbeat::default() });
            }
            let next = Instant::now() + PERIOD;
            while let Some(received) = orders.wait_until(next) {
                let Ok(order) = OperatorCommand::open(&received.payload) else { continue };
                let answer = OperatorAck {
                    h: acks.header(),
                    request_id: order.request_id,
                    state: Heartbeat::IDLE,
                    detail: HOSTILE.to_owned(),
                    ..OperatorAck::default()
                };
                let _ = acks.send(&answer);
            }
        }
    })?;
    Ok(worker)
}

/// What a program writes; it may refuse.
fn output(command: &mut Command) -> Result<String> {
    let output = command.stdin(Stdio::null()).output().context("cannot start a program")?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Ok(text(&output.stdout) + &text(&output.stderr))
}
