//! A log, message by message, with an account of what could not be used.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use anyhow::{Context as _, Result};
use lcm_types::eventlog::{Event, EventReader};
use lcm_types::schema::Struct;
use lcm_types::value::Value;
use serde::Serialize;

use super::Types;

/// liblcm's test message at its start.
const SELF_TEST: &str = "LCM_SELF_TEST";

/// One type on one channel.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Stream {
    /// Channel.
    pub channel: String,
    /// Full name of the type.
    pub type_name: String,
}

/// What a log held.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
pub struct Account {
    /// Messages of each stream.
    #[serde(serialize_with = "as_list")]
    pub streams: BTreeMap<Stream, u64>,
    /// Messages of unknown types, by channel.
    pub unknown: BTreeMap<String, u64>,
    /// Messages of a known type that do not decode, by channel.
    pub unreadable: BTreeMap<String, u64>,
    /// Places where the log did not go on with an event. \[-\]
    pub damaged_places: u64,
    /// Bytes skipped there. \[B\]
    pub damaged_bytes: u64,
}

impl Account {
    /// Whether something was lost.
    #[must_use]
    pub fn is_damaged(&self) -> bool {
        self.damaged_bytes > 0 || !self.unreadable.is_empty()
    }
}

/// One message of a log.
#[derive(Debug)]
pub struct DecodedEvent<'a> {
    /// As logged.
    pub event: &'a Event,
    /// Its type.
    pub of: &'a Struct,
    /// Decoded.
    pub value: &'a Value,
}

/// Reads the log at `path` and gives every message of a known type to `take`; if `channels` names
/// any, of those channels only.
///
/// # Errors
/// If the log cannot be read, or `take` fails.
pub fn read(
    path: &Path,
    types: &Types,
    channels: &[String],
    mut take: impl FnMut(&DecodedEvent<'_>) -> Result<()>,
) -> Result<Account> {
    let shown = path.display();
    let file = File::open(path).with_context(|| format!("cannot read {shown}"))?;
    let mut reader = EventReader::new(BufReader::new(file));
    let mut account = Account::default();
    while let Some(event) = reader.next_event().with_context(|| format!("cannot read {shown}"))? {
        if event.channel == SELF_TEST || !(channels.is_empty() || channels.contains(&event.channel))
        {
            continue;
        }
        let Some(of) = types.of(&event.data) else {
            *account.unknown.entry(event.channel).or_default() += 1;
            continue;
        };
        let Ok(value) = types.decode(of, &event.data) else {
            *account.unreadable.entry(event.channel).or_default() += 1;
            continue;
        };
        take(&DecodedEvent { event: &event, of, value: &value })?;
        let stream = Stream { channel: event.channel, type_name: of.full_name() };
        *account.streams.entry(stream).or_default() += 1;
    }
    let damage = reader.damage();
    (account.damaged_places, account.damaged_bytes) = (damage.places, damage.bytes);
    Ok(account)
}

fn as_list<S: serde::Serializer>(
    streams: &BTreeMap<Stream, u64>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Row<'a> {
        #[serde(flatten)]
        stream: &'a Stream,
        messages: u64,
    }
    serializer.collect_seq(streams.iter().map(|(stream, &messages)| Row { stream, messages }))
}
