//! Studies over many seeds: those of the paper, cars on tracks, and campaigns over any axes.

pub mod campaign;
mod csv_file;
mod definition;
mod ledger;
pub mod picture;
mod plots;
mod runs;
mod table;
pub mod tracks;

pub use definition::{Cell, Definition, Paper, StudyName};
pub use ledger::{Ledger, RunRow, StudyLap};
pub use plots::page;
pub use runs::{StudyCase, run_one};
pub use table::{CellSummary, summarize, text_table};
