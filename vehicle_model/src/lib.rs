//! Vehicle physics. Race tracks and the frames on them are those of the crate [`track`].
//!
//! One source of equations for three users: the controller's nominal model, every simulated
//! car, and the vehicle FMU. Frames and signs follow ISO 8855: x forward, y left, z up; yaw,
//! steering, curvature and lateral deviation are positive to the left. All units are SI and
//! radians.
#![forbid(unsafe_code)]
// The same bits on every machine: no function of the platform's mathematical library.
#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

pub mod discretized;
pub mod error;
pub mod limiter;
pub mod model;
pub mod normal;
mod number;
pub mod outline;
pub mod params;
pub mod plant;
pub mod road;
pub mod slip;
pub mod state;
mod tracking;
mod unknown_key;

pub use track;

pub use discretized::{Discretized, Linearization};
pub use error::ModelError;
pub use limiter::{Limit, Limited, Limiter};
pub use model::{
    AxleForces, Model, ModelKind, PoseConvention, SPATIAL_RATES, SPATIAL_VARIABLES,
    SpatialExpansion,
};
pub use outline::Outline;
pub use params::{
    CAR_KEYS, CarDefault, CarGroup, CarKey, CarParams, CarRange, GRAVITY, ParamProblem, Secant,
    Tyre,
};
pub use plant::{Disturbance, GripChange, Plant, PlantParams, PlantState, SensorNoise};
pub use road::{Road, RoadPoint, Surface};
pub use slip::SlipAngles;
pub use state::{GlobalState, Input, NU, NX, State};
pub use track::{Projection, Segment, Track, TrackError, fingerprint};
pub use tracking::Tracker;
pub use unknown_key::explain_unknown_key;
