//! Campaigns: races over any axes, as a file describes them.
//!
//! A run is a pure function of its row's axes and seed, so that shards on different machines give the
//! rows of one machine.

mod axis;
mod case;
mod drive;
mod file;
mod key;
mod limits;
mod merge;
mod parts;
mod record;
mod rows;
mod slurm;
mod summary;

pub use case::CampaignCase;
pub use drive::drive;
pub use file::Campaign;
pub use limits::Limits;
pub use merge::{Merged, merge};
pub use record::CampaignMeasure;
pub use rows::{CampaignColumns, CampaignRow, Rows, Shard, Sheet};
pub use slurm::script;
pub use summary::by_axis;
pub(crate) use summary::{distinct, ranges, ranges_of, short};
