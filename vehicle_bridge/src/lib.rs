//! Hosts of the racing LMPC: the offline race and the studies of the paper, with everything a
//! person sees of them.
//!
//! `lmpc` is a thin binary over this library: [`cli`] defines the command line, [`commands`] run
//! it, [`race`] and [`study`] do the work, [`page`] and [`report`] draw it.

pub mod check;
pub mod cli;
pub mod commands;
pub mod console;
pub mod page;
pub mod parallel;
pub mod race;
pub mod report;
pub mod settings;
pub mod study;
