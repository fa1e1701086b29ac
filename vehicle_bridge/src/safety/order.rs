//! The operator's orders.

/// Highest speed cap taken. \[m/s\]
pub(super) const MAX_CAP: f64 = 1000.0;

/// What is ordered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OrderKind {
    /// Grant a token.
    Arm {
        /// Though the car moves.
        moving: bool,
    },
    /// Take the grant away.
    Disarm,
    /// Obey the controller.
    Start,
    /// Stop safely.
    Stop,
    /// Emergency stop.
    Estop,
    /// End an emergency stop or a fault.
    Reset,
    /// Not to be passed; 0 for none. \[m/s\]
    SpeedCap(f64),
    /// An order of no known kind.
    Unknown(i8),
}

/// An order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order {
    /// What.
    pub kind: OrderKind,
    /// The grant it refers to. \[-\]
    pub token: i64,
    /// The dead man's switch is held. A START with it lasts only while it is repeated with it.
    pub deadman: bool,
    /// A random number, the grant if this order arms. \[-\]
    pub fresh: i64,
}

/// Why an order is not obeyed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Denied {
    /// Nothing is known of the car.
    #[error("no state of the car yet")]
    NoState,
    /// The last state is too old.
    #[error("the car's state is not fresh")]
    NotFresh,
    /// States have not been good for long enough.
    #[error("the car's state has been good (quality 2) for {good_s:.1} s, 1.0 s is needed")]
    NotGood {
        /// So far. \[s\]
        good_s: f64,
    },
    /// No life sign.
    #[error("no life sign of the controller on HB/lmpc: is `lmpc serve` running?")]
    NoController,
    /// It has not said which track it drives on.
    #[error("the controller has not said which track it drives on (MAP/TRACK)")]
    NoTrack,
    /// Another track.
    #[error("the controller drives on track {controller:08x}, the car is on track {car:08x}")]
    Track {
        /// The controller's.
        controller: i64,
        /// The car's.
        car: i64,
    },
    /// Needs standstill.
    #[error("the car moves at {speed:.2} m/s; it must stand")]
    Moves {
        /// Its speed. \[m/s\]
        speed: f64,
    },
    /// Needs ARM first.
    #[error("not armed: the state is {0}, ARM comes first")]
    NotArmed(&'static str),
    /// Needs a stop first.
    #[error("not possible in state {0}")]
    Phase(&'static str),
    /// Not the grant in force.
    #[error("wrong arm token {found}")]
    Token {
        /// As given.
        found: i64,
    },
    /// Only reset leaves it.
    #[error("{0}: only `reset` at standstill ends it")]
    Latched(&'static str),
    /// Nothing to reset.
    #[error("there is no emergency stop and no fault to end")]
    NothingToReset,
    /// Not a speed.
    #[error("speed cap {found}: expected 0 to {MAX_CAP} m/s")]
    Cap {
        /// As given.
        found: f64,
    },
    /// Not known.
    #[error("order {0} is not known")]
    Unknown(i8),
}
