//! The stream of one page: server-sent events, at most so many a second.

use std::io::Write;
use std::time::{Duration, Instant};

use super::server::Shared;
use crate::frame::Cursor;

/// Frames a second to a page, at most. \[-\]
const RATE: u32 = 60;
/// Between two messages that show the states of all programs.
const STATUS: Duration = Duration::from_millis(250);
/// After this time a page asks again. \[ms\]
const RETRY_MS: u32 = 500;

/// Writes events until the page is gone or the server ends.
pub(super) fn run(shared: &Shared, out: &mut impl Write) -> std::io::Result<()> {
    write!(
        out,
        "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n{}Connection: close\r\n\r\n\
         retry: {RETRY_MS}\n\n",
        super::server::HEADERS
    )?;
    let hello = serde_json::json!({
        "version": env!("CARGO_PKG_VERSION"),
        "source": shared.view.source(),
        "operator": shared.options.orders.is_some(),
    });
    write!(out, "event: hello\ndata: {hello}\n\n")?;
    let mut cursor = Cursor::default();
    let (mut known, mut next_status) = (u64::MAX, Instant::now());
    loop {
        let begun = Instant::now();
        let status = begun >= next_status;
        if status {
            next_status = begun + STATUS;
        }
        let mut text = String::new();
        for (name, data) in shared.view.events(&mut cursor, status) {
            text.push_str(&format!("event: {name}\ndata: {data}\n\n"));
        }
        out.write_all(text.as_bytes())?;
        out.flush()?;
        std::thread::sleep((Duration::from_secs(1) / RATE).saturating_sub(begun.elapsed()));
        known = shared.view.wait(known, next_status.saturating_duration_since(Instant::now()));
    }
}
