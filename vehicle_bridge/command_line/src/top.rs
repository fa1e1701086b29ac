//! Options of `lmpc top`.

use clap::Args;

use super::NetworkArgs;

const EXAMPLES: &str = "\
Examples:
  lmpc top                                   redrawn in place until Ctrl-C
  lmpc top --once                            a snapshot, for a log or a mail
  lmpc top --json | jq .car.v_x_mps

Shows the car on its track, who drives it, the states of bridge, controller and operator, the time
of the controller's steps beside what they may take, and each channel's rate, age and losses.
It only listens. Exit code 1 if no message arrived.";

/// Options of `lmpc top`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct TopArgs {
    /// The network.
    #[command(flatten)]
    pub network: NetworkArgs,
    /// Listen, print once, and end; so it is where standard output is no terminal
    #[arg(long)]
    pub once: bool,
    /// Print once, as JSON
    #[arg(long)]
    pub json: bool,
    /// How long to listen before printing once
    #[arg(long, default_value_t = 1.5, value_name = "S",
          value_parser = seconds)]
    pub listen: f64,
    /// Times a second the view is drawn
    #[arg(long, default_value_t = 5, value_name = "HZ",
          value_parser = clap::value_parser!(u32).range(1..=30))]
    pub rate: u32,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (0.1..=3600.0).contains(&seconds) => Ok(seconds),
        _ => Err("expected 0.1 to 3600 seconds".to_owned()),
    }
}
