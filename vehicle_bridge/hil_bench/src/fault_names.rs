//! Names that faults take: orders, signals, grants, messages, fields.

use serde::{Deserialize, Serialize};

/// Orders of the operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BenchOrder {
    /// Emergency stop, repeated every 10 ms until it is acknowledged.
    Estop,
    /// Stop.
    Stop,
    /// Start, by the grant of before, again and again.
    Start,
    /// Speed not to be passed.
    SpeedCap,
}

/// Signals at which a program ends by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EndSignal {
    /// SIGINT, as by Ctrl-C.
    #[default]
    Int,
    /// SIGTERM, as by systemd.
    Term,
    /// SIGHUP, as by a terminal that is closed.
    Hup,
    /// SIGQUIT.
    Quit,
}

impl std::str::FromStr for EndSignal {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "int" => Ok(Self::Int),
            "term" => Ok(Self::Term),
            "hup" => Ok(Self::Hup),
            "quit" => Ok(Self::Quit),
            other => Err(format!("`{other}` is no signal; expected int, term, hup or quit")),
        }
    }
}

/// Messages that are forged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Forged {
    /// Heartbeats of another controller.
    Heartbeat,
    /// Orders of another operator: end of an emergency stop, arming and start, in turn.
    Order,
    /// States with the bridge's start and next numbers, 0.3 m to the left, to the controller.
    State,
}

/// The grant a second controller claims.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Token {
    /// None.
    #[default]
    None,
    /// A number drawn for each command.
    Guessed,
    /// The source's, as read from its commands.
    Stolen,
    /// The source's, and its start and numbers too: the command passes for its own.
    Impostor,
}

/// Fields of states and commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Field {
    /// Acceleration of a command. \[m/s^2\]
    Accel,
    /// Steering angle of a command. \[rad\]
    Steer,
    /// Speed of a state. \[m/s\]
    Vx,
    /// Lateral speed of a state. \[m/s\]
    Vy,
    /// Yaw rate of a state. \[rad/s\]
    YawRate,
    /// Lateral position of a state. \[m\]
    EY,
    /// Heading error of a state. \[rad\]
    EPsi,
    /// Position of a state along the centre line. \[m\]
    S,
    /// Position of a state, world frame, east. \[m\]
    X,
    /// Position of a state, world frame, north. \[m\]
    Y,
    /// Heading of a state, world frame. \[rad\]
    Yaw,
}
