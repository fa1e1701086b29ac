//! `lmpc` is a thin binary over this library: [`cli`] defines the command line, [`commands`] run it.
//! The work is done by the crates beside this one, which `ARCHITECTURE.md` lists.

pub mod check;
pub mod cli;
pub mod commands;
pub mod console;
pub mod doctor;
pub mod top;
