//! What a drive is measured against: the car's parameters and its time-optimal lap.

use optimum_store::Known;
use vehicle_model::CarParams;

/// The car that drives, and the fastest lap it could drive.
#[derive(Debug, Clone)]
pub struct Reference {
    /// The car, for its outline, the limits of its inputs and the use of its tyres.
    pub car: CarParams,
    /// Its time-optimal lap on this track, if one is known.
    pub optimum: Option<Known>,
}

/// What a network says of its car and track.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Wanted {
    /// CRC-32 of the track, as in `MAP/TRACK`. \[-\]
    pub track_id: i64,
    /// Name of the track.
    pub track: String,
    /// CRC-32 of the car, 0 where it is not known. \[-\]
    pub car_id: i64,
    /// Name of the car; empty where it is not known.
    pub car: String,
}

/// Finds the reference of a network, if this computer has it. Names come from the network: they must
/// not be opened as files.
pub type Resolve = Box<dyn Fn(&Wanted) -> Option<Reference> + Send>;
