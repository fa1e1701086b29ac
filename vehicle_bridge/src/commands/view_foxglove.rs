//! `lmpc view --foxglove`: the topics of `lmpc export --mcap`, served to the Foxglove app as they come.

use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use anyhow::{Context as _, Result};
use foxglove::{Context, PartialMetadata, RawChannel, Schema};
use lcm_types::channels;
use lcm_types::eventlog::Event;
use log_export::json::Json;
use log_export::scene::{self, Scene};
use log_export::{Types, schema};
use serde::Serialize;
use serde_json::Value;

/// Topics that are served at most: names on a network are anybody's. \[-\]
const TOPICS: usize = 256;
/// Channels that the scene is drawn from, beside the track's.
const DRAWN: [&str; 2] = [channels::STATE, channels::TELEMETRY];

/// A server for the Foxglove app; it takes nothing from whoever connects. It ends with the program.
pub(super) struct App {
    address: SocketAddr,
    topics: Mutex<Topics>,
}

impl App {
    /// Begins to serve at `address`; port 0 is any free one.
    pub(super) fn serve(address: SocketAddr) -> Result<Self> {
        let host = match address.ip() {
            IpAddr::V4(ip) => ip.to_string(),
            IpAddr::V6(ip) => format!("[{ip}]"),
        };
        let context = Context::new();
        let server = context.websocket_server().name("lmpc view").bind(host, address.port());
        let server = server.start_blocking().with_context(|| {
            format!("cannot serve Foxglove at {address}; --foxglove PORT chooses another port")
        })?;
        let address = SocketAddr::new(address.ip(), server.port());
        let types = Arc::new(Types::load(&[])?);
        let mut topics = Topics { types, scene: Scene::new(None), context, open: BTreeMap::new() };
        for topic in scene::TOPICS {
            let name = scene::type_of(topic);
            topics.open(topic, name, || scene::schema(name))?;
        }
        Ok(Self { address, topics: Mutex::new(topics) })
    }

    /// Where it serves.
    pub(super) fn address(&self) -> SocketAddr {
        self.address
    }

    /// Takes a message that was received at `utime` \[us since 1970\].
    pub(super) fn take(&self, channel: &str, payload: &[u8], utime: i64) {
        let mut topics = self.topics();
        // What is no message, or a topic too many, is not shown: a network may hold anything.
        let _ = topics.message(channel, payload, utime);
        let _ = topics.scene(channel, payload, utime);
    }

    fn topics(&self) -> MutexGuard<'_, Topics> {
        self.topics.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What is served.
struct Topics {
    types: Arc<Types>,
    scene: Scene,
    context: Arc<Context>,
    /// Each topic by name and type.
    open: BTreeMap<(String, String), Arc<RawChannel>>,
}

impl Topics {
    /// A topic; none if there are too many.
    fn open(
        &mut self,
        topic: &str,
        name: &str,
        schema: impl FnOnce() -> Value,
    ) -> Result<Option<Arc<RawChannel>>> {
        let key = (topic.to_owned(), name.to_owned());
        if let Some(known) = self.open.get(&key) {
            return Ok(Some(Arc::clone(known)));
        }
        if self.open.len() >= TOPICS {
            return Ok(None);
        }
        let schema = Schema::new(name, "jsonschema", serde_json::to_vec(&schema())?);
        let builder = self.context.channel_builder(topic).message_encoding("json");
        let opened = builder.schema(schema).build_raw()?;
        self.open.insert(key, Arc::clone(&opened));
        Ok(Some(opened))
    }

    /// The message itself.
    fn message(&mut self, channel: &str, payload: &[u8], utime: i64) -> Result<()> {
        let types = Arc::clone(&self.types);
        let Some(of) = types.of(payload) else { return Ok(()) };
        let topic = self.open(channel, &of.full_name(), || schema::of(&types, of))?;
        if let Some(topic) = topic.filter(|topic| topic.has_sinks()) {
            let value = types.decode(of, payload)?;
            log(&topic, &Json::Message(&types, of, &value), utime)?;
        }
        Ok(())
    }

    /// What the scene draws of it.
    fn scene(&mut self, channel: &str, payload: &[u8], utime: i64) -> Result<()> {
        let asked =
            |topic: &Arc<RawChannel>| scene::TOPICS.contains(&topic.topic()) && topic.has_sinks();
        if channel == channels::TRACK {
            // Whoever has connected since the last one has no track yet.
            self.scene.redraw();
        } else if !DRAWN.contains(&channel) || !self.open.values().any(asked) {
            return Ok(());
        }
        let (channel, data) = (channel.to_owned(), payload.to_vec());
        for (topic, message) in self.scene.take(&Event { number: 0, utime, channel, data }) {
            let name = scene::type_of(topic);
            if let Some(topic) = self.open(topic, name, || scene::schema(name))? {
                log(&topic, &message, utime)?;
            }
        }
        Ok(())
    }
}

/// Sends a message to those that asked for its topic.
fn log(topic: &RawChannel, message: &impl Serialize, utime: i64) -> Result<()> {
    let nanoseconds = u64::try_from(utime).unwrap_or(0).saturating_mul(1000);
    let time = PartialMetadata::with_log_time(nanoseconds);
    topic.log_with_meta(&serde_json::to_vec(message)?, time);
    Ok(())
}
