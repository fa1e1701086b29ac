//! Options of `lmpc car`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

const EXAMPLES: &str = "\
Examples:
  lmpc car new my_car --like barc            writes my_car.toml with every key, unit and meaning
  lmpc car new rental --like kart.toml --out cars/rental.toml
  lmpc car show kart                         every parameter, and what follows from them
  lmpc car random --seed 7                   writes random_7.toml, a car that no setting was chosen for
  lmpc check my_car.toml                     every mistake, or what lmpc makes of it

The keys, and how data sheets give them, stand in docs/cars.md.";

/// Options of `lmpc car`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct CarFileArgs {
    /// What to do.
    #[command(subcommand)]
    pub action: CarAction,
}

/// What `lmpc car` does.
#[derive(Debug, Subcommand)]
pub enum CarAction {
    /// Write a car file with every key, its unit and its meaning
    New(NewCarArgs),
    /// Print every parameter of a car, its unit and its meaning, and what follows from them
    Show(ShowCarArgs),
    /// Write a car of random numbers, neutral to understeering, from a model car's size to a road car's
    Random(RandomCarArgs),
}

/// Options of `lmpc car show`.
#[derive(Debug, Args)]
pub struct ShowCarArgs {
    /// Car: a name or a file
    #[arg(value_name = "NAME|FILE")]
    pub car: String,
}

/// Options of `lmpc car new`.
#[derive(Debug, Args)]
pub struct NewCarArgs {
    /// Name of the car
    #[arg(value_name = "NAME")]
    pub name: String,
    /// Car whose numbers it begins with: a name or a file
    #[arg(long, default_value = "barc", value_name = "NAME|FILE")]
    pub like: String,
    /// File to write, which must not be there yet; by default NAME.toml
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Options of `lmpc car random`.
#[derive(Debug, Args)]
pub struct RandomCarArgs {
    /// Seed; the same seed gives the same car
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// File to write, which must not be there yet; by default random_SEED.toml
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}
