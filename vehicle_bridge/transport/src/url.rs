//! LCM URLs: `provider://network?option=value&option=value`.

use std::fmt;
use std::net::{Ipv4Addr, SocketAddrV4};

use super::Error;

/// LCM's usual group, on this host only.
pub const DEFAULT_URL: &str = "udpm://239.255.76.67:7667?ttl=0";

const DEFAULT_NETWORK: &str = "239.255.76.67:7667";
const DEFAULT_RECEIVE_BUFFER: usize = 4 << 20;
const LIBLCM_PREFIX: &str = "liblcm+";

/// A parsed LCM URL.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Url {
    text: String,
    liblcm: bool,
    provider: String,
    network: String,
    options: Vec<(String, String)>,
}

/// What `udpm://` needs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UdpmOptions {
    /// Multicast group and port.
    pub group: SocketAddrV4,
    /// Networks a datagram may cross: 0 stays on this host, 1 on the local network. [-]
    pub ttl: u32,
    /// Size of the kernel's receive buffer. \[B\]
    pub recv_buf_size: usize,
    /// Address of the interface to use; 0.0.0.0 leaves it to the routes.
    pub interface: Ipv4Addr,
}

impl Url {
    /// Parses `provider://network?option=value&…`; the prefix `liblcm+` asks for liblcm.
    ///
    /// # Errors
    /// [`Error::Url`] without a provider, or with an option that is not `name=value`.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let wrong = |reason: String| Error::Url { url: text.to_owned(), reason };
        let (liblcm, plain) =
            text.strip_prefix(LIBLCM_PREFIX).map_or((false, text), |rest| (true, rest));
        let Some((provider, rest)) = plain.split_once("://") else {
            return Err(wrong("expected provider://network?option=value".into()));
        };
        if provider.is_empty() || !provider.chars().all(|c| c.is_ascii_lowercase()) {
            return Err(wrong(format!("provider `{provider}`, expected one like `udpm`")));
        }
        let (network, options) = rest.split_once('?').unwrap_or((rest, ""));
        let option = |part: &str| {
            let (name, value) = part.split_once('=')?;
            Some((name.to_owned(), value.to_owned()))
        };
        let options = options
            .split('&')
            .filter(|part| !part.is_empty())
            .map(|part| option(part).ok_or_else(|| wrong(format!("`{part}`, expected name=value"))))
            .collect::<Result<_, _>>()?;
        let (provider, network) = (provider.to_owned(), network.to_owned());
        Ok(Self { text: text.to_owned(), liblcm, provider, network, options })
    }

    /// True if the Rust implementation of `udpm` is meant.
    #[must_use]
    pub fn is_udpm(&self) -> bool {
        self.provider == "udpm" && !self.liblcm
    }

    /// The URL as liblcm takes it.
    #[must_use]
    pub fn for_liblcm(&self) -> &str {
        self.text.strip_prefix(LIBLCM_PREFIX).unwrap_or(&self.text)
    }

    /// Group and options of a `udpm` URL; what is not given has LCM's default, and `recv_buf_size`
    /// is 4 MiB.
    ///
    /// # Errors
    /// [`Error::Url`] for a group that is no multicast address and for unknown or wrong options.
    pub fn udpm_options(&self) -> Result<UdpmOptions, Error> {
        let wrong = |reason: String| Error::Url { url: self.text.clone(), reason };
        let network = if self.network.is_empty() { DEFAULT_NETWORK } else { &self.network };
        let group: SocketAddrV4 = network
            .parse()
            .map_err(|_| wrong(format!("network `{network}`, expected address:port")))?;
        if !group.ip().is_multicast() || group.port() == 0 {
            return Err(wrong(format!("{group}, expected a multicast address and a port")));
        }
        let mut parsed = UdpmOptions {
            group,
            ttl: 0,
            recv_buf_size: DEFAULT_RECEIVE_BUFFER,
            interface: Ipv4Addr::UNSPECIFIED,
        };
        for (name, value) in &self.options {
            let bad = |expected: &str| wrong(format!("{name}={value}, expected {expected}"));
            match name.as_str() {
                "ttl" => {
                    let ttl = value.parse().ok().filter(|ttl| *ttl <= 255);
                    parsed.ttl = ttl.ok_or_else(|| bad("0 to 255"))?;
                }
                "recv_buf_size" => {
                    let size = value.parse().ok().filter(|size| (1..=1 << 30).contains(size));
                    parsed.recv_buf_size = size.ok_or_else(|| bad("1 to 1073741824 bytes"))?;
                }
                "interface" => {
                    parsed.interface = value.parse().map_err(|_| bad("an IPv4 address"))?;
                }
                _ => return Err(bad("ttl, recv_buf_size or interface")),
            }
        }
        Ok(parsed)
    }
}

impl fmt::Display for Url {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_url_without_details_is_lcm_s_default() {
        for text in ["udpm://", DEFAULT_URL] {
            let url = Url::parse(text).unwrap();
            assert!(url.is_udpm());
            let options = url.udpm_options().unwrap();
            assert_eq!(options.group.to_string(), DEFAULT_NETWORK);
            assert_eq!((options.ttl, options.recv_buf_size), (0, DEFAULT_RECEIVE_BUFFER));
        }
    }

    #[test]
    fn options_are_read() {
        let text = "udpm://239.1.2.3:99?ttl=1&recv_buf_size=2000000&interface=192.168.0.2";
        let options = Url::parse(text).unwrap().udpm_options().unwrap();
        assert_eq!((options.ttl, options.recv_buf_size), (1, 2_000_000));
        assert_eq!(options.interface, Ipv4Addr::new(192, 168, 0, 2));
        let asked = Url::parse("liblcm+udpm://239.1.2.3:99?ttl=0").unwrap();
        assert!(!asked.is_udpm());
        assert_eq!(asked.for_liblcm(), "udpm://239.1.2.3:99?ttl=0");
    }

    #[test]
    fn a_wrong_url_says_what_is_expected() {
        for (text, expected) in [
            ("239.255.76.67:7667", "expected provider://network?option=value"),
            ("UDPM://", "provider `UDPM`, expected one like `udpm`"),
            ("udpm://127.0.0.1:7667", "127.0.0.1:7667, expected a multicast address and a port"),
            ("udpm://?ttl", "`ttl`, expected name=value"),
            ("udpm://?ttl=300", "ttl=300, expected 0 to 255"),
            ("udpm://?ttll=3", "ttll=3, expected ttl, recv_buf_size or interface"),
            ("udpm://?recv_buf_size=0", "recv_buf_size=0, expected 1 to 1073741824 bytes"),
            ("udpm://here", "network `here`, expected address:port"),
        ] {
            let error = Url::parse(text).and_then(|url| url.udpm_options()).unwrap_err();
            assert_eq!(error.to_string(), format!("LCM URL `{text}`: {expected}"));
        }
    }
}
