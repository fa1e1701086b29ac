//! The network: route, buffers, liblcm.

use std::time::Duration;

use super::Finding;
use transport::{Filter, Inbox, Url};

/// What a receive buffer should hold: a burst of telemetry. \[B\]
const BUFFER: u64 = 4 << 20;
/// A datagram on this host takes far less.
const PATIENCE: Duration = Duration::from_millis(500);
const PROBE: &str = "LMPC/DOCTOR";
const ROUTE: &str =
    "ip link set lo multicast on; ip route add 224.0.0.0/4 dev lo (or the car's interface)";

/// Whether a message to the group comes back.
pub(super) fn route(url: &str) -> Finding {
    const SUBJECT: &str = "multicast route";
    let inbox = Inbox::latest();
    let heard = || -> Result<bool, transport::Error> {
        let network = transport::open(url, None)?;
        network.subscribe(Filter::channel(PROBE), inbox.sink())?;
        network.publish(PROBE, b"?")?;
        Ok(inbox.wait(PATIENCE).is_some())
    };
    match heard() {
        Ok(true) => Finding::ok(SUBJECT, format!("{url}: heard own message")),
        Ok(false) => Finding::fail(SUBJECT, format!("{url}: own message did not come back"), ROUTE),
        Err(error) => {
            let fix = if is_taken(&error) { taken(url) } else { ROUTE.to_owned() };
            Finding::fail(SUBJECT, error.to_string(), fix)
        }
    }
}

/// Whether another program has the port and does not share it.
fn is_taken(error: &transport::Error) -> bool {
    use std::io::ErrorKind::AddrInUse;
    matches!(error, transport::Error::Socket { source, .. } if source.kind() == AddrInUse)
}

/// What to do about a port that is taken.
fn taken(url: &str) -> String {
    let options = Url::parse(url).and_then(|url| url.udpm_options());
    let port = options.map_or(7667, |options| options.group.port());
    format!(
        "`ss -ulpn sport = :{port}` names the program that has the port; end it, or choose another"
    )
}

/// Whether the kernel grants the receive buffer asked for.
pub(super) fn buffer(url: &str) -> Finding {
    const SUBJECT: &str = "receive buffer";
    const KEY: &str = "/proc/sys/net/core/rmem_max";
    let asked = Url::parse(url)
        .and_then(|url| url.udpm_options())
        .map_or(BUFFER, |options| options.recv_buf_size as u64);
    let text = std::fs::read_to_string(KEY).unwrap_or_default();
    match text.trim().parse::<u64>() {
        Ok(most) if most >= asked => Finding::ok(SUBJECT, format!("{most} bytes allowed")),
        Ok(most) => Finding::warn(
            SUBJECT,
            format!("{most} bytes allowed, {asked} are asked for: bursts will be lost"),
            format!("sysctl -w net.core.rmem_max={asked}"),
        ),
        // A namespace of its own does not show the key; the socket tells.
        Err(_) => match transport::open(url, None).map(|network| network.warnings().to_vec()) {
            Ok(warnings) if warnings.is_empty() => {
                Finding::ok(SUBJECT, format!("{asked} bytes granted"))
            }
            Ok(warnings) => Finding::warn(
                SUBJECT,
                warnings.join("; "),
                format!("sysctl -w net.core.rmem_max={asked}"),
            ),
            Err(error) => Finding::fail(SUBJECT, error.to_string(), ROUTE),
        },
    }
}

/// The version of liblcm that a URL other than `udpm://` would get, by the file it is loaded from.
pub(super) fn liblcm() -> Finding {
    const SUBJECT: &str = "liblcm";
    if !cfg!(feature = "liblcm") {
        let found = "not built in: only udpm:// works";
        return Finding::warn(SUBJECT, found, "build with --features liblcm");
    }
    #[cfg(feature = "liblcm")]
    if let Err(e) = transport::liblcm::available() {
        let found = format!("not found: only udpm:// works ({e})");
        return Finding::warn(SUBJECT, found, "apt-get install liblcm1");
    }
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap_or_default();
    let file = maps.split_whitespace().find(|word| word.contains("liblcm.so"));
    match file {
        Some(file) => Finding::ok(SUBJECT, format!("{file} (udpm:// does not use it)")),
        None => Finding::warn(SUBJECT, "not loaded", "apt-get install liblcm1"),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use std::net::UdpSocket;

    use super::*;
    use crate::Level;

    #[test]
    fn a_port_that_is_taken_is_no_missing_route() {
        // Bound without sharing it, as programs other than LCM's do.
        let owner = UdpSocket::bind("0.0.0.0:0").unwrap();
        let port = owner.local_addr().unwrap().port();
        let found = route(&format!("udpm://239.255.76.67:{port}?ttl=0"));
        assert_eq!(found.level, Level::Fail);
        assert!(found.fix.contains(&format!("ss -ulpn sport = :{port}")), "{found:?}");
        assert!(!found.fix.contains("ip route"), "{found:?}");
    }
}
