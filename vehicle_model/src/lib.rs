//! Vehicle physics, race tracks and the frames between them.
//!
//! One source of equations for three users: the controller's nominal model, every simulated
//! car, and the vehicle FMU. Frames and signs follow ISO 8855: x forward, y left, z up; yaw,
//! steering, curvature and lateral deviation are positive to the left. All units are SI and
//! radians.
#![forbid(unsafe_code)]

pub mod state;
pub mod track;

pub use state::{GlobalState, Input, NU, NX, State};
pub use track::{Projection, Segment, Track, TrackError};
