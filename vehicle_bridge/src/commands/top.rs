//! `lmpc top`.

use std::io::{self, IsTerminal as _, Write as _};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use anstream::adapter::strip_str;
use anyhow::Result;

use super::Outcome;
use super::network::{connect, on_signal};
use command_line::TopArgs;
use network_watch::{Snapshot, Watch};
use terminal::top::draw;
use terminal::{Talk, harmless, result};
use transport::{Filter, ReceivedMessage};

/// Longest sleep, so that signals are seen.
const NAP: Duration = Duration::from_millis(50);
/// A screen beside the one with the shell's lines, without a cursor.
const ENTER: &str = "\x1b[?1049h\x1b[?25l";
const LEAVE: &str = "\x1b[?25h\x1b[?1049l";
const HOME: &str = "\x1b[H";
const CLEAR_LINE: &str = "\x1b[K";
const CLEAR_BELOW: &str = "\x1b[J";
/// Where the terminal does not report its size. \[characters, lines\]
const SIZE: (usize, usize) = (100, 40);

/// Shows the network until Ctrl-C, or once.
pub(super) fn run(args: &TopArgs, talk: Talk) -> Result<Outcome> {
    let url = args.network.url();
    let (network, notes, _) = connect(&args.network, false)?;
    for note in &notes {
        talk.say(note);
    }
    let watch = Arc::new(Mutex::new(Watch::default()));
    let entrance = Arc::clone(&watch);
    let take = move |message: &ReceivedMessage<'_>| {
        let mut watch = entrance.lock().unwrap_or_else(PoisonError::into_inner);
        watch.take(message.channel, message.payload, message.arrival.mono.as_ns());
    };
    network.subscribe(Filter::All, Box::new(take))?;
    let look = || -> Snapshot {
        let watch = watch.lock().unwrap_or_else(PoisonError::into_inner);
        watch.snapshot(transport::now().mono.as_ns())
    };
    let stop = on_signal()?;
    let wait = |until: Instant| {
        while !stop.load(Ordering::Relaxed) && Instant::now() < until {
            std::thread::sleep(NAP.min(until.saturating_duration_since(Instant::now())));
        }
    };
    if args.once || args.json || !io::stdout().is_terminal() {
        wait(Instant::now() + Duration::from_secs_f64(args.listen));
        let seen = look();
        if args.json {
            terminal::json(&seen)?;
        } else {
            for line in draw(&seen, &url, size().0) {
                result(&line)?;
            }
        }
        return Ok(if seen.channels.is_empty() { Outcome::Problems } else { Outcome::Done });
    }
    let period = Duration::from_secs(1) / args.rate;
    // Where colours are not wanted, the cursor's orders still are.
    let plain = anstream::AutoStream::choice(&io::stdout()) == anstream::ColorChoice::Never;
    let mut screen = io::stdout().lock();
    write!(screen, "{ENTER}")?;
    let drawn = loop {
        let (width, height) = size();
        let title = format!("lmpc top  {url}  Ctrl-C ends");
        let lines = draw(&look(), &title, width);
        let shown: Vec<String> = lines
            .iter()
            .take(height)
            .map(|line| harmless(line).replace('\n', "\\n"))
            .map(|line| if plain { strip_str(&line).to_string() } else { line })
            .map(|line| line + CLEAR_LINE)
            .collect();
        let painted = write!(screen, "{HOME}{}{CLEAR_BELOW}", shown.join("\r\n"));
        if let Err(error) = painted.and_then(|()| screen.flush()) {
            break Err(error);
        }
        wait(Instant::now() + period);
        if stop.load(Ordering::Relaxed) {
            break Ok(());
        }
    };
    // The shell's screen comes back, also after a failure.
    let left = write!(screen, "{LEAVE}").and_then(|()| screen.flush());
    drawn.and(left)?;
    Ok(if look().channels.is_empty() { Outcome::Problems } else { Outcome::Done })
}

fn size() -> (usize, usize) {
    terminal_size::terminal_size().map_or(SIZE, |(width, height)| (width.0.into(), height.0.into()))
}
