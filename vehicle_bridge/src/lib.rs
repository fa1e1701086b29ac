//! `lmpc` is a thin binary over this library: the crate `command_line` defines the command line,
//! [`commands`] run it. The work is done by the crates beside this one, which `ARCHITECTURE.md` lists.

pub mod commands;
