//! Files that go into the FMUs' resources.

use crate::description::Resource;

/// The track files that ship, as examples of their format and to be edited in place.
pub(crate) const RESOURCES: [Resource; 3] = [
    Resource { name: "l.toml", bytes: include_bytes!("../../tracks/l.toml") },
    Resource { name: "road_course.toml", bytes: include_bytes!("../../tracks/road_course.toml") },
    Resource { name: "barc.toml", bytes: include_bytes!("../../cars/barc.toml") },
];
