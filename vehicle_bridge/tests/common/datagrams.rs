//! Datagrams no LCM sender makes.
#![allow(dead_code, unused_imports, reason = "not every test sends them")]

use std::net::{Ipv4Addr, UdpSocket};

pub(crate) use hil_bench::malformed::{cases, fragment, short};

const GROUP: (Ipv4Addr, u16) = (Ipv4Addr::new(239, 255, 76, 67), 7667);

pub(crate) fn noise() -> UdpSocket {
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).unwrap();
    socket.connect(GROUP).unwrap();
    socket
}
