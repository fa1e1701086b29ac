//! Pictures of a table of runs: any axis against any measure, medians with their range, failures
//! marked, small multiples for further axes, and the paper's figures as templates.

mod figure;
mod groups;
mod page;
mod samples;
mod table;
mod template;
mod words;

pub use figure::Figure;
pub use page::page;
pub use table::RunTable;
pub use template::{Template, usual};
