//! A log as MCAP for Foxglove: JSON messages with JSON schemas, and a scene drawn from them.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

use anyhow::{Context as _, Result};
use lcm_types::eventlog::Event;
use lcm_types::schema::Type;
use lcm_types::{Checked as _, Header, Message as _, Track, channels};
use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};
use serde_json::Value;

use super::json::Json;
use super::log::{self, Account, DecodedEvent};
use super::scene::{self, Scene};
use super::{Types, schema};

/// Channels of the file, made when their first message comes.
struct Book {
    out: Writer<BufWriter<File>>,
    /// Number and next sequence of each topic, by name and schema.
    topics: BTreeMap<(String, String), (u16, u32)>,
}

/// Writes the messages of `log` to `file` in the order of the log. Log time is when the logger
/// received a message, publish time when its header says that it was sent.
///
/// Beside the messages stand topics of Foxglove's own types, listed in [`scene::TOPICS`].
///
/// # Errors
/// If the log cannot be read, or the file not be written.
pub fn write(log: &Path, types: &Types, only: &[String], file: &Path) -> Result<Account> {
    let cannot = || format!("cannot write {}", file.display());
    let out = BufWriter::new(File::create(file).with_context(cannot)?);
    let options = WriteOptions::new().compression(None).library("lmpc export");
    let out = options.create(out).with_context(cannot)?;
    let mut book = Book { out, topics: BTreeMap::new() };
    // The track is sent once a second: messages before its first one are drawn on it, too.
    let mut scene = Scene::new(first_track(log)?);
    let account = log::read(log, types, only, |entry| {
        book.message(types, entry).with_context(cannot)?;
        for (topic, message) in scene.take(entry.event) {
            book.derived(topic, entry.event, &message).with_context(cannot)?;
        }
        Ok(())
    })?;
    book.out.finish().with_context(cannot)?;
    book.out.into_inner().flush().with_context(cannot)?;
    Ok(account)
}

fn first_track(log: &Path) -> Result<Option<Track>> {
    let mut found = None;
    let types = Types::load(&[])?;
    log::read(log, &types, &[channels::TRACK.to_owned()], |entry| {
        found = found.take().or_else(|| Track::open(&entry.event.data).ok());
        Ok(())
    })?;
    Ok(found)
}

impl Book {
    fn message(&mut self, types: &Types, entry: &DecodedEvent<'_>) -> Result<()> {
        let DecodedEvent { event, of, value } = entry;
        let name = of.full_name();
        let data = serde_json::to_vec(&Json::Message(types, of, value))?;
        let described = || schema::of(types, of);
        let sent = sent(entry).unwrap_or(event.utime);
        self.write(&event.channel, &name, described, (event.utime, sent), &data)
    }

    fn derived(&mut self, topic: &str, event: &Event, message: &Value) -> Result<()> {
        let name = scene::type_of(topic);
        let data = serde_json::to_vec(message)?;
        self.write(topic, name, || scene::schema(name), (event.utime, event.utime), &data)
    }

    fn write(
        &mut self,
        topic: &str,
        name: &str,
        schema: impl FnOnce() -> Value,
        (received, sent): (i64, i64),
        data: &[u8],
    ) -> Result<()> {
        let key = (topic.to_owned(), name.to_owned());
        if !self.topics.contains_key(&key) {
            let schema = serde_json::to_vec(&schema())?;
            let schema = self.out.add_schema(name, "jsonschema", &schema)?;
            let number = self.out.add_channel(schema, topic, "json", &BTreeMap::new())?;
            self.topics.insert(key.clone(), (number, 0));
        }
        let Some((channel_id, sequence)) = self.topics.get_mut(&key) else { return Ok(()) };
        let (log_time, publish_time) = (nanoseconds(received), nanoseconds(sent));
        let (channel_id, number) = (*channel_id, *sequence);
        *sequence = sequence.wrapping_add(1);
        let header = MessageHeader { channel_id, sequence: number, log_time, publish_time };
        Ok(self.out.write_to_known_channel(&header, data)?)
    }
}

/// What our own headers say, where a message has one. \[us\]
fn sent(entry: &DecodedEvent<'_>) -> Option<i64> {
    use lcm_types::value::Value::{Integer, Struct};
    let Struct(values) = entry.value else { return None };
    let header = entry
        .of
        .members
        .iter()
        .position(|m| m.name == "h" && m.kind == Type::Struct(Header::NAME.to_owned()))?;
    match values.get(header)? {
        Struct(header) => match header.first()? {
            Integer(utime) if *utime > 0 => Some(*utime),
            _ => None,
        },
        _ => None,
    }
}

/// Times before 1970 do not exist in MCAP.
fn nanoseconds(utime: i64) -> u64 {
    u64::try_from(utime).unwrap_or(0).saturating_mul(1000)
}
