//! A car's own messages to ours and back, as described by a map file. Pure: the host reads the files, keeps
//! the time and owns the network.
//!
//! [`MapFile`] is the file as written; [`Mapping::new`] resolves every name in it against the `.lcm`
//! types it refers to, or says everything that is wrong and on which line. [`Mapping::take`] turns
//! their bytes into a [`VehicleState`](lcm_types::VehicleState), [`Mapping::command`] our input into
//! their bytes. `examples/lcm/car.toml` shows every key that most cars need.

mod command;
mod file;
mod resolve;
mod state;
#[cfg(test)]
mod tests;
mod unit;

pub use command::CarRequest;
pub use file::MapFile;
pub use resolve::MapProblem;
pub use state::CarMessageCounts;
pub use unit::{Quantity, factor};

use lcm_types::schema::Schema;

/// A map file, resolved: all names are known to exist.
#[derive(Debug, Clone)]
pub struct Mapping {
    schema: Schema,
    state: state::StateMap,
    command: command::CommandMap,
}

impl Mapping {
    /// Resolves a map file against the types it names.
    ///
    /// `text` is the file's text, from which lines are counted.
    ///
    /// # Errors
    /// Everything that is wrong.
    pub fn new(file: &MapFile, text: &str, schema: Schema) -> Result<Self, Vec<MapProblem>> {
        let mut resolver = resolve::Resolver::new(text, &schema);
        let state = state::StateMap::resolve(file, &mut resolver);
        let command = command::CommandMap::resolve(&file.command, &mut resolver);
        match (resolver.problems.is_empty(), state, command) {
            (true, Some(state), Some(command)) => Ok(Self { schema, state, command }),
            _ => Err(resolver.problems),
        }
    }

    /// Channels the car's state comes on.
    #[must_use]
    pub fn state_channels(&self) -> Vec<String> {
        self.state.channels()
    }

    /// Channel the car takes commands on.
    #[must_use]
    pub fn command_channel(&self) -> &str {
        &self.command.channel
    }

    /// Longest time between two commands to the car. \[s\]
    #[must_use]
    pub fn command_period(&self) -> f64 {
        self.command.period
    }
}
