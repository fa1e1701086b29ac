//! What every generated type can do.

use crate::wire::{Reader, Wire, Writer};
use crate::{Error, crc, signature};

/// A message type: its fingerprint, and its way to bytes and back.
pub trait Message: Wire {
    /// Full name, `package.type`.
    const NAME: &'static str;

    /// The eight bytes every message of the type begins with, as `lcm-gen` computes them.
    const FINGERPRINT: u64;

    /// Replaces the contents of `out` with the encoded message.
    ///
    /// # Errors
    /// [`Error::Count`] if an array and its length field disagree, [`Error::Nul`] if a string holds
    /// a NUL; `out` is then empty.
    fn encode_into(&self, out: &mut Vec<u8>) -> Result<(), Error> {
        out.clear();
        out.extend_from_slice(&Self::FINGERPRINT.to_be_bytes());
        let written = self.write(&mut Writer::new(out));
        if written.is_err() {
            out.clear();
        }
        written
    }

    /// The message in `bytes`, which must hold it and nothing else but a [`signature`].
    ///
    /// # Errors
    /// Any of the decoding variants of [`Error`].
    fn decode(bytes: &[u8]) -> Result<Self, Error> {
        let (bytes, _) = signature::split(bytes);
        let mut reader = Reader::new(bytes, Self::NAME);
        let found = reader.fingerprint()?;
        if found != Self::FINGERPRINT {
            let expected = Self::FINGERPRINT;
            return Err(Error::Fingerprint { name: Self::NAME.into(), found, expected });
        }
        let message = Self::read(&mut reader)?;
        match reader.left() {
            0 => Ok(message),
            bytes => Err(Error::Trailing { name: Self::NAME.into(), bytes }),
        }
    }
}

/// A message whose last field is a CRC-32 of all bytes before it.
pub trait Checked: Message {
    /// [`Message::encode_into`], then the checksum into the last field, whatever the value held.
    ///
    /// # Errors
    /// As [`Message::encode_into`].
    fn seal_into(&self, out: &mut Vec<u8>) -> Result<(), Error> {
        self.encode_into(out)?;
        crc::seal(out);
        Ok(())
    }

    /// Checks the checksum before anything else, then decodes.
    ///
    /// # Errors
    /// [`Error::Crc`], and as [`Message::decode`].
    fn open(bytes: &[u8]) -> Result<Self, Error> {
        let (bytes, _) = signature::split(bytes);
        crc::check(Self::NAME, bytes)?;
        Self::decode(bytes)
    }
}
