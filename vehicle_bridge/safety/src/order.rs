//! The operator's orders.

use lcm_types::{ArmToken, BootId};

use super::doubt::Suspicion;

/// Highest speed cap taken. \[m/s\]
pub(super) const MAX_CAP: f64 = 1000.0;

/// What is ordered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OrderKind {
    /// Grant a token.
    Arm {
        /// Though the car moves.
        moving: bool,
        /// The controller, [`BootId::NONE`] for the only one.
        controller: BootId,
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
    /// The arm token it refers to.
    pub token: ArmToken,
    /// The dead man's switch is held. A START with it lasts only while it is repeated with it.
    pub deadman: bool,
    /// A random number, the grant if this order arms.
    pub fresh: ArmToken,
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
    /// No heartbeat.
    #[error("no heartbeat of the controller on HB/lmpc: is `lmpc serve` running?")]
    NoController,
    /// Two controllers are live and none was chosen.
    #[error(
        "two controllers are live, {0} and {1}: end one, or choose with \
         `lmpc operator arm --controller ID`"
    )]
    Controllers(BootId, BootId),
    /// The controller that was chosen is not live.
    #[error("controller {wanted} is not live; {heard} is")]
    OtherController {
        /// As ordered.
        wanted: BootId,
        /// One that is live.
        heard: BootId,
    },
    /// Its setup is not known.
    #[error("the controller has not sent its setup (LMPC/SETUP) yet")]
    NoSetup,
    /// Another car.
    #[error(
        "the controller was set up for another car (parameters {controller:08x}, here \
         {bridge:08x}): give both the same --car and --nominal-mu"
    )]
    Car {
        /// The controller's.
        controller: i64,
        /// The bridge's.
        bridge: i64,
    },
    /// Another period.
    #[error(
        "the controller's period is {controller_ms} ms, the bridge expects {bridge_ms} ms: give \
         both the same configuration"
    )]
    Period {
        /// The controller's. \[ms\]
        controller_ms: f64,
        /// The bridge's. \[ms\]
        bridge_ms: f64,
    },
    /// Another configuration.
    #[error(
        "the controller's configuration ({controller:08x}) is not the bridge's ({bridge:08x}): \
         give both the same --config, --preset and --set"
    )]
    Config {
        /// The controller's.
        controller: i64,
        /// The bridge's.
        bridge: i64,
    },
    /// Another track.
    #[error("the controller drives on track {controller:08x}, the car is on track {car:08x}")]
    Track {
        /// The controller's.
        controller: i64,
        /// The car's.
        car: i64,
    },
    /// The car is where it must not be driven from.
    #[error("{0}")]
    Place(Suspicion),
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
    BridgeState(&'static str),
    /// Not the grant in force.
    #[error("wrong arm token {found}")]
    Token {
        /// As given.
        found: ArmToken,
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
