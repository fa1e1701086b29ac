//! Cars x tracks x plants x seeds: which car stays on which track, and how close to the optimum.

mod axes;
mod book;
mod case;
mod cell;
mod drive;
mod optima;
mod page;
mod row;
mod summary;
mod thumbnail;

pub use axes::{Named, Refused, Tracks, cars, generated, tracks};
pub use book::Book;
pub use case::TracksCase;
pub use drive::{LAST_STEPS, Run, drive};
pub use optima::Optima;
pub use page::page;
pub use row::{TracksKey, TracksRow};
pub use summary::{Summary, summarize, text_table};
