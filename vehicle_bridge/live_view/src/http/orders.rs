//! Orders of a person at the page, where the program was started for that.

use serde::Deserialize;

/// An order, named as `lmpc operator` names it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrderRequest {
    /// `arm`, `disarm`, `start`, `stop`, `estop`, `reset` or `speed-cap`.
    pub order: String,
    /// Of `speed-cap` the speed; 0 takes it away. \[m/s\]
    #[serde(default)]
    pub value: f64,
}

/// Gives an order to the network and returns the answers, or why it was not followed.
pub type Give = Box<dyn Fn(&OrderRequest) -> Result<String, String> + Send + Sync>;

/// Who may order, and who carries it out.
pub struct Orders {
    /// What a page has to know: it stands in the address that is printed at the start.
    pub token: String,
    /// How an order is given.
    pub give: Give,
}
