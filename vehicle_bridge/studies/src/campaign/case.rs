//! One run of a campaign.

use racing::RaceOptions;

use super::file::Assignments;
use super::key::text;
use crate::runs::fingerprint;

/// One run to be done. What it does depends on nothing else.
#[derive(Debug, Clone)]
pub struct CampaignCase {
    /// Its number, from 0.
    pub number: usize,
    /// Values of the axes as in the table.
    pub axes: Vec<String>,
    /// Its seed.
    pub seed: u64,
    /// Fingerprint of everything that is set but the seed.
    pub settings: String,
    /// The race.
    pub options: RaceOptions,
}

impl CampaignCase {
    /// Adds every seed of a cell.
    pub(super) fn of_cell(
        all: &mut Vec<Self>,
        varied: &Assignments,
        options: &RaceOptions,
        seeds: &[u64],
    ) {
        let settings = fingerprint(options);
        let axes: Vec<String> = varied.iter().map(|(_, value)| text(value)).collect();
        for &seed in seeds {
            let options = options.clone().with_seed(seed);
            let (axes, settings) = (axes.clone(), settings.clone());
            all.push(Self { number: all.len(), axes, seed, settings, options });
        }
    }

    /// The run in a few words, for messages.
    #[must_use]
    pub fn title(&self, axes: &[String]) -> String {
        let mut parts: Vec<String> =
            axes.iter().zip(&self.axes).map(|(key, value)| format!("{key} {value}")).collect();
        parts.push(format!("seed {}", self.seed));
        format!("run {}: {}", self.number, parts.join(", "))
    }
}
