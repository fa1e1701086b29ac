//! Learned data as bytes: magic, version, length, checksum, then fingerprints and laps.

use std::io::{self, Write};
use std::sync::Arc;

use postcard::ser_flavors::Flavor;
use serde::{Deserialize, Serialize};

use crate::config::Config;
use crate::error::DataError;
use crate::learning::dataset::Lap;

const MAGIC: &[u8; 8] = b"LMPCDATA";
const VERSION: u32 = 1;
/// Magic, version, length, checksum.
const HEADER: usize = 8 + 4 + 8 + 4;

/// What is kept from one day to the next. Taking it shares the laps: it is cheap whatever was learned.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Learned {
    pub(crate) identity: Identity,
    pub(crate) grip: [f64; 2],
    pub(crate) laps: Vec<Arc<Lap>>,
}

/// What the data belong to.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Identity {
    pub(crate) car: u64,
    pub(crate) track: u64,
    /// The configuration as TOML, without the seed.
    pub(crate) config: String,
}

impl Identity {
    pub(crate) fn new(car: u64, track: u64, config: &Config) -> Self {
        let mut config = config.clone();
        // Another seed is another trial of the same thing.
        config.warm_up.seed = 0;
        Self { car, track, config: toml::to_string(&config).unwrap_or_default() }
    }

    /// Refuses data that belong to something else.
    pub(crate) fn accept(&self, other: &Self) -> Result<(), DataError> {
        let differ = |what, ours: u64, theirs: u64| {
            let detail = format!("fingerprint {theirs:016x} in the data, {ours:016x} here");
            Err(DataError::Mismatch { what, detail })
        };
        if self.car != other.car {
            return differ("car", self.car, other.car);
        }
        if self.track != other.track {
            return differ("track", self.track, other.track);
        }
        if self.config != other.config {
            let detail = first_difference(&self.config, &other.config);
            return Err(DataError::Mismatch { what: "configuration", detail });
        }
        Ok(())
    }
}

/// The lines in which two configurations differ.
fn first_difference(ours: &str, theirs: &str) -> String {
    let mut section = "";
    for (here, there) in ours.lines().zip(theirs.lines()) {
        if here.starts_with('[') {
            section = here;
        }
        if here != there {
            return format!("{section} `{there}` in the data, `{here}` here");
        }
    }
    "one has more keys than the other".to_owned()
}

impl Learned {
    /// Writes magic, version, length, checksum and content, piece by piece: nothing the size of the whole
    /// is ever in memory. Give it a buffered writer.
    ///
    /// # Errors
    /// The writer's own.
    pub fn write(&self, out: &mut impl Write) -> io::Result<()> {
        // Once for the header, which stands before the content, once for the content.
        let mut measured = Measured::default();
        encode(self, &mut measured)?;
        out.write_all(MAGIC)?;
        out.write_all(&VERSION.to_le_bytes())?;
        out.write_all(&measured.length.to_le_bytes())?;
        out.write_all(&measured.checksum.finalize().to_le_bytes())?;
        encode(self, out)?;
        out.flush()
    }
}

/// Length and checksum of what is written to it.
#[derive(Default)]
struct Measured {
    length: u64,
    checksum: crc32fast::Hasher,
}

impl Write for Measured {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.length += bytes.len() as u64;
        self.checksum.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Sends the encoder's bytes to a writer and keeps the writer's error, which the encoder cannot carry.
struct Sink<'a, W> {
    out: &'a mut W,
    error: &'a mut Option<io::Error>,
}

impl<W: Write> Flavor for Sink<'_, W> {
    type Output = ();

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.try_extend(&[byte])
    }

    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        self.out.write_all(bytes).map_err(|error| {
            *self.error = Some(error);
            postcard::Error::SerializeBufferFull
        })
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}

fn encode(content: &impl Serialize, out: &mut impl Write) -> io::Result<()> {
    let mut error = None;
    let sink = Sink { out, error: &mut error };
    let encoded = postcard::serialize_with_flavor(content, sink);
    encoded.map_err(|other| error.unwrap_or_else(|| io::Error::other(other)))
}

/// Checks and decodes what [`Learned::write`] wrote.
pub(crate) fn open<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<T, DataError> {
    let found = &bytes[..bytes.len().min(MAGIC.len())];
    let (Some(header), Some(content)) = (bytes.get(..HEADER), bytes.get(HEADER..)) else {
        if found == MAGIC {
            return Err(DataError::Length { found: 0, expected: HEADER as u64 });
        }
        return Err(DataError::Magic { found: found.to_vec() });
    };
    if found != MAGIC {
        return Err(DataError::Magic { found: found.to_vec() });
    }
    let version = u32::from_le_bytes(array(header, 8));
    if version != VERSION {
        return Err(DataError::Version { found: version, expected: VERSION });
    }
    let expected = u64::from_le_bytes(array(header, 12));
    if content.len() as u64 != expected {
        return Err(DataError::Length { found: content.len(), expected });
    }
    let expected = u32::from_le_bytes(array(header, 20));
    let found = crc32fast::hash(content);
    if found != expected {
        return Err(DataError::Checksum { found, expected });
    }
    postcard::from_bytes(content).map_err(|error| DataError::Content(error.to_string()))
}

/// `N` bytes of the header at `at`.
fn array<const N: usize>(header: &[u8], at: usize) -> [u8; N] {
    let mut out = [0; N];
    out.copy_from_slice(&header[at..at + N]);
    out
}
