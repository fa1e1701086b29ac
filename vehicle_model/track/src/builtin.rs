//! The tracks that ship with the product.

use super::Track;

/// Name and text of each.
const BUILTIN: [(&str, &str); 2] = [
    ("l", include_str!("../../../tracks/l.toml")),
    ("road_course", include_str!("../../../tracks/road_course.toml")),
];

impl Track {
    /// Names of the tracks that ship with the product.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        BUILTIN.iter().map(|(name, _)| *name)
    }

    /// The track of this name that ships with the product, if there is one.
    #[must_use]
    pub fn builtin(name: &str) -> Option<Self> {
        let (_, text) = BUILTIN.iter().find(|(known, _)| *known == name)?;
        Self::from_toml(text).ok()
    }
}
