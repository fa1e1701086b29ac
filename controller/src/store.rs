//! Learned data as bytes: magic, version, length, checksum, then fingerprints and laps.

use std::sync::Arc;

use actuators::Response;
use postcard::ser_flavors::Flavor;
use serde::{Deserialize, Serialize};

use crate::config::Config;
use crate::error::DataError;
use crate::learning::dataset::Lap;

const MAGIC: &[u8; 8] = b"LMPCDATA";
const VERSION: u32 = 4;
/// Magic, version, length, checksum.
const HEADER: usize = 8 + 4 + 8 + 4;

/// What is kept from one day to the next. Taking it shares the laps: it is cheap whatever was learned.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Learned {
    pub(crate) identity: Identity,
    pub(crate) grip: [f64; 2],
    /// Delay and lag of the actuators where they were found.
    pub(crate) response: Option<Response>,
    /// Ridge weight that the noise of the laps asks for.
    pub(crate) ridge: f64,
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
        Self { car, track, config: toml::to_string(&config.identity()).unwrap_or_default() }
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
    /// Gives magic, version, length, checksum and content to `out`, piece by piece: nothing the size of
    /// the whole is ever in memory.
    ///
    /// # Errors
    /// The first of `out`.
    pub fn write<E>(&self, mut out: impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        // Once for the header, which stands before the content, once for the content.
        let (mut length, mut checksum) = (0, crc32fast::Hasher::new());
        let mut measure = |bytes: &[u8]| -> Result<(), E> {
            length += bytes.len() as u64;
            checksum.update(bytes);
            Ok(())
        };
        encode(self, &mut measure)?;
        out(MAGIC)?;
        out(&VERSION.to_le_bytes())?;
        out(&length.to_le_bytes())?;
        out(&checksum.finalize().to_le_bytes())?;
        encode(self, &mut out)
    }
}

/// Hands the encoder's bytes on and keeps the receiver's error, which the encoder cannot carry.
struct Sink<'a, F, E> {
    out: &'a mut F,
    error: &'a mut Option<E>,
}

impl<E, F: FnMut(&[u8]) -> Result<(), E>> Flavor for Sink<'_, F, E> {
    type Output = ();

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.try_extend(&[byte])
    }

    fn try_extend(&mut self, bytes: &[u8]) -> postcard::Result<()> {
        (self.out)(bytes).map_err(|error| {
            *self.error = Some(error);
            postcard::Error::SerializeBufferFull
        })
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}

fn encode<E>(
    content: &impl Serialize,
    out: &mut impl FnMut(&[u8]) -> Result<(), E>,
) -> Result<(), E> {
    let mut error = None;
    // Encoding plain structs of numbers has no way to fail but the receiver's.
    let _ = postcard::serialize_with_flavor(content, Sink { out, error: &mut error });
    error.map_or(Ok(()), Err)
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
