//! How far a study is: a bar with the time left, failures as they come.

use std::io::IsTerminal as _;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::{BAD, Talk, paint};

/// Where there is no terminal, time between two lines on how far the study is.
const EVERY: Duration = Duration::from_secs(60);

/// A bar at `done` of `runs`.
pub fn bar(runs: u64, done: u64, talk: Talk) -> ProgressBar {
    let target =
        if talk.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(Some(runs), target);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {eta} {wide_msg}") {
        bar.set_style(style);
    }
    bar.set_position(done);
    bar
}

/// How far a study is whose runs may fail.
pub struct Progress {
    bar: ProgressBar,
    talk: Talk,
    begun: Instant,
    spoken: Instant,
    /// Runs to be done now.
    runs: usize,
    count: usize,
    failed: usize,
    live: bool,
}

impl Progress {
    /// Of all runs, those done before, and those of them that failed.
    pub fn new((all, done, failed): (usize, usize, usize), talk: Talk) -> Self {
        let (begun, live) = (Instant::now(), std::io::stderr().is_terminal());
        Self {
            bar: bar(all as u64, done as u64, talk),
            talk,
            begun,
            spoken: begun,
            runs: all - done,
            count: 0,
            failed,
            live,
        }
    }

    /// A run is done; one that failed with its reason.
    pub fn done(&mut self, title: &str, failure: Option<&str>) {
        if let Some(reason) = failure {
            self.failed += 1;
            let text = format!("{title}: {reason}");
            self.bar.suspend(|| self.talk.say(&paint(BAD, &text)));
        }
        self.count += 1;
        self.bar.set_message(format!("{} failed; {title}", self.failed));
        if !self.live && self.spoken.elapsed() > EVERY {
            self.spoken = Instant::now();
            let left = self.begun.elapsed().as_secs_f64() * (self.runs - self.count) as f64
                / self.count as f64;
            self.talk.say(&format!(
                "{} of {} runs done, {} failed, about {:.0} min left",
                self.count,
                self.runs,
                self.failed,
                left / 60.0
            ));
        }
        self.bar.inc(1);
    }

    /// Takes the bar away.
    pub fn end(self) {
        self.bar.finish_and_clear();
    }
}
