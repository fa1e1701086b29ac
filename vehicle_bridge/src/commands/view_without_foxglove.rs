//! `lmpc view --foxglove` of a program that was built without it.

use std::net::SocketAddr;

use anyhow::{Result, bail};
use hosting::settings::Usage;

/// The command that builds a program with the server.
const COMMAND: &str = "cargo install --locked --path vehicle_bridge --features foxglove";

/// No server: there is no value of it.
pub(super) enum App {}

impl App {
    /// Says how to get the server.
    pub(super) fn serve(_: SocketAddr) -> Result<Self> {
        bail!(Usage(format!(
            "this lmpc was built without the server for Foxglove; in the source tree, `{COMMAND}` \
             builds one with it"
        )))
    }

    /// Where it would serve.
    pub(super) fn address(&self) -> SocketAddr {
        match *self {}
    }

    /// What it would take.
    pub(super) fn take(&self, _: &str, _: &[u8], _: i64) {
        match *self {}
    }
}
