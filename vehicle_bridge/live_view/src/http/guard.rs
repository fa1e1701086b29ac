//! Which requests are answered: those of a page that this program itself handed out.
//!
//! A page of the web that a person has open can make a browser send requests here, and can give its own
//! name this computer's address (DNS rebinding). Neither can change the headers looked at here.

use std::net::{IpAddr, SocketAddr};

use super::request::Request;
use super::server::Refused;

/// Whether a request to this address may be answered at all.
///
/// # Errors
/// [`Refused::Foreign`].
pub(super) fn check(request: &Request, bound: SocketAddr) -> Result<(), Refused> {
    let named = is_ours(&request.host, bound);
    let origin = format!("http://{}", request.host);
    let same = request.origin.as_ref().is_none_or(|found| *found == origin);
    // A link on another page may open the page itself, which cannot be put in a frame.
    let opens = request.method == "GET" && request.path == "/";
    let site = request.site.as_deref().unwrap_or("none");
    if named && same && (opens || matches!(site, "none" | "same-origin")) {
        return Ok(());
    }
    Err(Refused::Foreign)
}

/// Whether a `Host` names this server by an address or as `localhost`: any other name could be
/// anybody's.
fn is_ours(host: &str, bound: SocketAddr) -> bool {
    let Some((name, port)) = host.rsplit_once(':') else { return false };
    if port != bound.port().to_string() {
        return false;
    }
    if name.eq_ignore_ascii_case("localhost") {
        return true;
    }
    let bare = name.strip_prefix('[').and_then(|n| n.strip_suffix(']')).unwrap_or(name);
    let Ok(address) = bare.parse::<IpAddr>() else { return false };
    address == bound.ip() || address.is_loopback() || bound.ip().is_unspecified()
}

/// Whether two tokens are equal; takes as long wherever they differ.
pub(super) fn equal(one: &str, other: &str) -> bool {
    let differ = one.bytes().zip(other.bytes()).fold(0, |all, (a, b)| all | (a ^ b));
    one.len() == other.len() && differ == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asks(host: &str, origin: Option<&str>, site: Option<&str>, path: &str) -> Request {
        Request {
            method: "GET".to_owned(),
            path: path.to_owned(),
            host: host.to_owned(),
            origin: origin.map(str::to_owned),
            site: site.map(str::to_owned),
            ..Request::default()
        }
    }

    #[test]
    fn only_a_page_from_here_is_answered() {
        let bound: SocketAddr = ([127, 0, 0, 1], 80).into();
        let fine = [
            asks("127.0.0.1:80", None, None, "/stream"),
            asks("localhost:80", Some("http://localhost:80"), Some("same-origin"), "/stream"),
            asks("[::1]:80", None, Some("none"), "/"),
            asks("127.0.0.1:80", None, Some("cross-site"), "/"),
        ];
        for request in fine {
            assert_eq!(check(&request, bound), Ok(()), "{request:?}");
        }
        let foreign = [
            asks("evil.example:80", None, None, "/"),
            asks("evil.example:80", Some("http://evil.example:80"), Some("same-origin"), "/stream"),
            asks("127.0.0.1:81", None, None, "/"),
            asks("127.0.0.1", None, None, "/"),
            asks("", None, None, "/"),
            asks("192.168.1.5:80", None, None, "/"),
            asks("127.0.0.1:80", Some("http://evil.example"), None, "/stream"),
            asks("127.0.0.1:80", Some("null"), None, "/"),
            asks("127.0.0.1:80", None, Some("cross-site"), "/stream"),
            asks("127.0.0.1:80", None, Some("same-site"), "/stream"),
        ];
        for request in foreign {
            assert_eq!(check(&request, bound), Err(Refused::Foreign), "{request:?}");
        }
        let everywhere: SocketAddr = ([0, 0, 0, 0], 80).into();
        assert_eq!(check(&asks("192.168.1.5:80", None, None, "/"), everywhere), Ok(()));
        let named = asks("car.local:80", None, None, "/");
        assert_eq!(check(&named, everywhere), Err(Refused::Foreign));
    }

    #[test]
    fn tokens_are_equal_only_as_a_whole() {
        assert!(equal("abc", "abc"));
        assert!(!equal("abc", "abd") && !equal("abc", "ab") && !equal("", "a"));
    }
}
