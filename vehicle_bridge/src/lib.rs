//! Hosts of the racing LMPC: the offline race, the studies of the paper, and
//! programs on an LCM network, with everything a person sees of them.
//!
//! `lmpc` is a thin binary over this library: [`cli`] defines the command line, [`commands`] run
//! it, [`race`], [`study`] and [`network`] do the work, [`page`] and [`report`] draw it.

pub mod bench;
pub mod check;
pub mod cli;
pub mod commands;
pub mod console;
pub mod doctor;
pub mod export;
pub mod hil;
pub mod laps;
pub mod mapping;
pub mod network;
pub mod optimal;
pub mod page;
pub mod parallel;
pub mod race;
pub mod report;
pub mod safety;
pub mod settings;
pub mod shutdown;
pub mod study;
pub mod top;
pub mod transport;
pub mod vehicle;
mod worker;
