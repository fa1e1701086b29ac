//! Datagrams of an LCM network as they are, for the fault proxy: nothing is decoded or reassembled.

use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};

use socket2::{Domain, Protocol, Socket, Type};

use transport::UdpmOptions;

const BUFFER: usize = 4 << 20;
const SHORT_HEADER: usize = 8;

/// A multicast group, for sending and receiving whole datagrams.
#[derive(Debug)]
pub(super) struct Wire {
    receiver: UdpSocket,
    sender: UdpSocket,
    group: SocketAddrV4,
    own_port: u16,
}

impl Wire {
    /// Joins the group; what it sends does not leave this host.
    pub(super) fn join(options: &UdpmOptions) -> io::Result<Self> {
        let receiver = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
        receiver.set_reuse_address(true)?;
        // Granted as far as the system allows; `lmpc doctor` says how far.
        receiver.set_recv_buffer_size(BUFFER)?;
        receiver.bind(&options.group.into())?;
        receiver.join_multicast_v4(options.group.ip(), &options.interface)?;
        receiver.set_nonblocking(true)?;
        let sender = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
        sender.set_multicast_ttl_v4(options.ttl)?;
        sender.set_multicast_loop_v4(true)?;
        let own_port = sender.local_addr()?.port();
        Ok(Self { receiver: receiver.into(), sender, group: options.group, own_port })
    }

    /// The next datagram that is not this proxy's own; `None` if none waits.
    pub(super) fn receive<'b>(&self, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
        loop {
            match self.receiver.recv_from(buffer) {
                Ok((_, SocketAddr::V4(from))) if from.port() == self.own_port => {}
                Ok((length, _)) => return Some(&buffer[..length]),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => return None,
            }
        }
    }

    /// Sends a datagram. A proxy loses what the network refuses, as the network would.
    pub(super) fn send(&self, datagram: &[u8]) {
        let _ = self.sender.send_to(datagram, self.group);
    }

    /// The receiving socket, to wait on.
    pub(super) fn socket(&self) -> &UdpSocket {
        &self.receiver
    }
}

/// Channel and message of a short datagram.
pub(super) fn parts(datagram: &[u8]) -> Option<(&str, &[u8])> {
    let rest = datagram.strip_prefix(b"LC02")?.get(SHORT_HEADER - 4..)?;
    let end = rest.iter().take(64).position(|byte| *byte == 0)?;
    Some((std::str::from_utf8(&rest[..end]).ok()?, &rest[end + 1..]))
}

/// A short datagram.
pub(super) fn datagram(sequence: u32, channel: &str, message: &[u8]) -> Vec<u8> {
    let mut bytes = b"LC02".to_vec();
    bytes.extend(sequence.to_be_bytes());
    bytes.extend(channel.as_bytes());
    bytes.push(0);
    bytes.extend(message);
    bytes
}

/// One fragment: `number` of `count` at `offset` of a message of `size` bytes.
pub(super) fn fragment(
    sequence: u32,
    (size, offset): (u32, u32),
    (number, count): (u16, u16),
    content: &[u8],
) -> Vec<u8> {
    let mut bytes = b"LC03".to_vec();
    bytes.extend(sequence.to_be_bytes());
    bytes.extend(size.to_be_bytes());
    bytes.extend(offset.to_be_bytes());
    bytes.extend(number.to_be_bytes());
    bytes.extend(count.to_be_bytes());
    bytes.extend(content);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_datagram_comes_apart_as_it_was_made() {
        let made = datagram(7, "CAR/STATE", b"abc");
        assert_eq!(parts(&made), Some(("CAR/STATE", &b"abc"[..])));
        assert_eq!(parts(&made[..12]), None);
    }
}
