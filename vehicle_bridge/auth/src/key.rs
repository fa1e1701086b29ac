//! The key and its file.

use std::fmt;
use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Write as _};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::{Path, PathBuf};

use hmac::{Hmac, KeyInit as _, Mac as _};
use lcm_types::signature::TAG;
use sha2::Sha256;

/// What the file begins with.
const NAME: &str = "lmpc-key-1";
/// Bytes of a key. \[B\]
const SIZE: usize = 32;
/// A key's file is far shorter. \[B\]
const LONGEST: u64 = 4096;

/// Why there is no key.
#[derive(Debug, thiserror::Error)]
pub enum KeyError {
    /// The file cannot be read or written.
    #[error("key file {}: {source}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Others than its owner may read or change it.
    #[error(
        "key file {}: its rights are {mode:04o}, others than the owner can read or change it; \
         run `chmod 600 {}`, and make a new key if it was readable for long",
        path.display(), path.display()
    )]
    Rights {
        /// Which.
        path: PathBuf,
        /// Its rights.
        mode: u32,
    },
    /// It belongs to somebody else.
    #[error(
        "key file {}: it belongs to user {owner}, expected user {user} or root; run `chown {user} {}`",
        path.display(), path.display()
    )]
    Owner {
        /// Which.
        path: PathBuf,
        /// Its owner.
        owner: u32,
        /// Who runs this program.
        user: u32,
    },
    /// It holds no key.
    #[error(
        "key file {}: expected one line, `{NAME}` and 64 hexadecimal digits; `lmpc key new FILE` \
         makes one",
        path.display()
    )]
    Form {
        /// Which.
        path: PathBuf,
    },
    /// The system gives no random numbers.
    #[error("no random numbers from /dev/urandom: {0}")]
    Random(io::Error),
}

/// A key: whoever holds it can send what its holders obey.
#[derive(Clone)]
pub struct Key {
    /// With the key taken in; copied for each message.
    code: Hmac<Sha256>,
    id: String,
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Key({})", self.id)
    }
}

impl Key {
    /// A key of these bytes.
    #[must_use]
    pub fn from_bytes(bytes: &[u8; SIZE]) -> Self {
        // A key of a hash's length is always taken.
        let code =
            Hmac::<Sha256>::new_from_slice(bytes).unwrap_or_else(|_| Hmac::new(&[0; 64].into()));
        let mut known = code.clone();
        known.update(b"lmpc key id");
        let id = known.finalize().into_bytes().iter().take(4).map(|b| format!("{b:02x}")).collect();
        Self { code, id }
    }

    /// Eight digits that differ between keys and tell nothing of them: to compare two computers.
    #[must_use]
    pub fn id(&self) -> &str {
        &self.id
    }

    /// Reads a key, whose file its owner alone may read.
    ///
    /// # Errors
    /// [`KeyError`].
    pub fn load(path: &Path) -> Result<Self, KeyError> {
        let failed = |source| KeyError::File { path: path.to_owned(), source };
        let file = File::open(path).map_err(failed)?;
        // Of what was opened, not of what the name means by now.
        let metadata = file.metadata().map_err(failed)?;
        let (mode, owner) = (metadata.mode() & 0o7777, metadata.uid());
        if !metadata.is_file() {
            return Err(failed(io::Error::other("not a regular file")));
        }
        if mode & 0o077 != 0 {
            return Err(KeyError::Rights { path: path.to_owned(), mode });
        }
        let user = nix::unistd::geteuid().as_raw();
        if owner != user && owner != 0 {
            return Err(KeyError::Owner { path: path.to_owned(), owner, user });
        }
        let mut text = String::new();
        file.take(LONGEST).read_to_string(&mut text).map_err(failed)?;
        let bytes = parse(&text).ok_or_else(|| KeyError::Form { path: path.to_owned() })?;
        Ok(Self::from_bytes(&bytes))
    }

    /// Makes a new key and its file, which is not there yet; its owner alone may read it.
    ///
    /// # Errors
    /// [`KeyError::File`], also if the file is there; [`KeyError::Random`].
    pub fn create(path: &Path) -> Result<Self, KeyError> {
        let failed = |source| KeyError::File { path: path.to_owned(), source };
        let bytes: [u8; SIZE] = random()?;
        let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        let mut options = OpenOptions::new();
        let mut file =
            options.write(true).create_new(true).mode(0o600).open(path).map_err(failed)?;
        writeln!(file, "{NAME} {digits}").and_then(|()| file.sync_all()).map_err(failed)?;
        Ok(Self::from_bytes(&bytes))
    }

    /// The code of a message.
    pub(super) fn tag(&self, channel: &str, start: i64, seq: i64, message: &[u8]) -> [u8; TAG] {
        let mut tag = [0; TAG];
        let whole = self.taken(channel, start, seq, message).finalize().into_bytes();
        tag.iter_mut().zip(whole).for_each(|(to, from)| *to = from);
        tag
    }

    /// Whether a code is that of a message; takes as long whichever bit is wrong.
    pub(super) fn holds(
        &self,
        channel: &str,
        (start, seq): (i64, i64),
        message: &[u8],
        tag: &[u8; TAG],
    ) -> bool {
        self.taken(channel, start, seq, message).verify_truncated_left(tag).is_ok()
    }

    /// Everything the code is over; no two different messages give the same bytes.
    fn taken(&self, channel: &str, start: i64, seq: i64, message: &[u8]) -> Hmac<Sha256> {
        let mut code = self.code.clone();
        code.update(b"lmpc message 1\0");
        code.update(&(channel.len() as u64).to_be_bytes());
        code.update(channel.as_bytes());
        code.update(&start.to_be_bytes());
        code.update(&seq.to_be_bytes());
        code.update(message);
        code
    }
}

fn parse(text: &str) -> Option<[u8; SIZE]> {
    let digits = text.trim().strip_prefix(NAME)?.strip_prefix(' ')?.trim().as_bytes();
    if digits.len() != 2 * SIZE {
        return None;
    }
    let mut bytes = [0; SIZE];
    for (byte, pair) in bytes.iter_mut().zip(digits.chunks(2)) {
        let pair =
            std::str::from_utf8(pair).ok().filter(|p| p.bytes().all(|b| b.is_ascii_hexdigit()))?;
        *byte = u8::from_str_radix(pair, 16).ok()?;
    }
    Some(bytes)
}

/// Random bytes that nobody can foresee.
///
/// # Errors
/// [`KeyError::Random`].
pub(super) fn random<const N: usize>() -> Result<[u8; N], KeyError> {
    let mut bytes = [0; N];
    let mut source = File::open("/dev/urandom").map_err(KeyError::Random)?;
    source.read_exact(&mut bytes).map_err(KeyError::Random)?;
    Ok(bytes)
}
