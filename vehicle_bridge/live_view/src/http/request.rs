//! One request, as far as it is needed.

use std::io::Read;
use std::time::{Duration, Instant};

use super::server::Refused;

/// Longest head of a request. \[B\]
const HEAD: usize = 16 << 10;
/// Headers of a request. \[-\]
const HEADERS: usize = 64;
/// Longest body: an order. \[B\]
const BODY: usize = 1024;
/// A whole request comes in this time.
const PATIENCE: Duration = Duration::from_secs(5);

/// A request.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Request {
    pub(super) method: String,
    pub(super) path: String,
    pub(super) host: String,
    pub(super) origin: Option<String>,
    /// `Sec-Fetch-Site`: where a browser says the request comes from.
    pub(super) site: Option<String>,
    /// `X-Lmpc-Token`, which a page of another origin cannot send.
    pub(super) token: Option<String>,
    pub(super) body: Vec<u8>,
}

/// Reads a request.
///
/// # Errors
/// [`Refused`] if it is too long, too slow, or no request of HTTP/1.1.
pub(super) fn read(stream: &mut impl Read) -> Result<Request, Refused> {
    let late = Instant::now() + PATIENCE;
    let mut bytes = Vec::new();
    let (mut request, head, length) = loop {
        more(stream, &mut bytes, late)?;
        if let Some(parsed) = parse(&bytes)? {
            break parsed;
        }
        if bytes.len() > HEAD {
            return Err(Refused::TooLong);
        }
    };
    if length > BODY {
        return Err(Refused::TooLong);
    }
    while bytes.len() < head + length {
        more(stream, &mut bytes, late)?;
    }
    request.body = bytes.get(head..head + length).unwrap_or_default().to_vec();
    Ok(request)
}

fn more(stream: &mut impl Read, bytes: &mut Vec<u8>, late: Instant) -> Result<(), Refused> {
    let mut part = [0; 2048];
    let count = stream.read(&mut part).map_err(|_| Refused::Gone)?;
    if count == 0 || Instant::now() > late {
        return Err(Refused::Gone);
    }
    bytes.extend_from_slice(part.get(..count).unwrap_or_default());
    Ok(())
}

/// The request without its body, the length of its head, and that of its body; `None` while the head is
/// not whole.
fn parse(bytes: &[u8]) -> Result<Option<(Request, usize, usize)>, Refused> {
    let mut headers = [httparse::EMPTY_HEADER; HEADERS];
    let mut parsed = httparse::Request::new(&mut headers);
    let head = match parsed.parse(bytes).map_err(|_| Refused::Malformed)? {
        httparse::Status::Complete(head) => head,
        httparse::Status::Partial => return Ok(None),
    };
    let all = |name: &str| -> Vec<String> {
        let named = parsed.headers.iter().filter(|h| h.name.eq_ignore_ascii_case(name));
        named.map(|h| String::from_utf8_lossy(h.value).trim().to_owned()).collect()
    };
    let one = |name: &str| -> Result<Option<String>, Refused> {
        match <[String; 1]>::try_from(all(name)) {
            Ok([value]) => Ok(Some(value)),
            Err(none) if none.is_empty() => Ok(None),
            Err(_) => Err(Refused::Malformed),
        }
    };
    if one("transfer-encoding")?.is_some() {
        return Err(Refused::Malformed);
    }
    let length = match one("content-length")? {
        Some(text) => text.parse().map_err(|_| Refused::Malformed)?,
        None => 0,
    };
    let request = Request {
        method: parsed.method.unwrap_or_default().to_owned(),
        path: parsed.path.unwrap_or_default().to_owned(),
        host: one("host")?.unwrap_or_default(),
        origin: one("origin")?,
        site: one("sec-fetch-site")?,
        token: one("x-lmpc-token")?,
        body: Vec::new(),
    };
    Ok(Some((request, head, length)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_read_from_parts_with_its_body() {
        let text = "POST /order HTTP/1.1\r\nHost: localhost:1\r\nContent-Length: 5\r\n\
                    X-LMPC-Token: abc\r\n\r\nhello and more";
        for split in 1..text.len() - 1 {
            let (first, second) = text.as_bytes().split_at(split);
            let read = read(&mut first.chain(second));
            let request = read.unwrap_or_default();
            assert_eq!(request.body, b"hello", "split at {split}");
            assert_eq!((request.method.as_str(), request.host.as_str()), ("POST", "localhost:1"));
            assert_eq!(request.token.as_deref(), Some("abc"));
        }
    }

    #[test]
    fn what_is_too_long_doubtful_or_cut_off_is_refused() {
        let long = format!("GET / HTTP/1.1\r\nHost: {}", "a".repeat(3 * HEAD));
        for (text, why) in [
            (long.as_str(), Refused::TooLong),
            ("POST / HTTP/1.1\r\nContent-Length: 99999\r\n\r\n", Refused::TooLong),
            ("GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", Refused::Malformed),
            ("POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n", Refused::Malformed),
            ("\u{1}\u{2}\r\n\r\n", Refused::Malformed),
            ("GET / HTTP/1.1\r\nHost", Refused::Gone),
            ("POST / HTTP/1.1\r\nContent-Length: 9\r\n\r\nshort", Refused::Gone),
        ] {
            assert_eq!(read(&mut text.as_bytes()), Err(why), "{text:.60}");
        }
    }
}
