//! Which way a quantity counts, from the words of its name and its description.

use std::f64::consts::FRAC_PI_2;

/// What the words say.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Sense {
    /// Theirs is positive where ours is negative.
    pub(super) reversed: bool,
    /// Added to theirs, of the other sense if it is. \[rad\]
    pub(super) offset: f64,
    /// What cannot be known.
    pub(super) doubt: Option<String>,
}

/// Words of a name that say a sense and nothing of the quantity.
pub(super) const WORDS: [&str; 10] = [
    "right",
    "left",
    "cw",
    "ccw",
    "clockwise",
    "counterclockwise",
    "north",
    "ned",
    "enu",
    "compass",
];

/// Quantities that count to one side.
const SIDED: [&str; 8] = ["delta", "v_y", "side_slip", "omega_z", "psi", "e_psi", "e_y", "y"];

const LEFT: [&str; 11] = [
    "counter-clockwise",
    "counterclockwise",
    "counter clockwise",
    "anticlockwise",
    "anti-clockwise",
    "ccw",
    "to the left",
    "left positive",
    "positive left",
    "left is positive",
    "iso 8855",
];
const RIGHT: [&str; 9] = [
    "clockwise",
    "cw",
    "to the right",
    "right positive",
    "positive right",
    "right is positive",
    "left-handed",
    "left-hand",
    "sae j670",
];
const NORTH: [&str; 4] = ["from north", "compass", "azimuth", "north is zero"];

/// The sense of a quantity by what its variable is called and described as.
pub(super) fn sense(quantity: &str, name: &str, description: &str) -> Sense {
    if !SIDED.contains(&quantity) {
        return Sense::default();
    }
    let text = format!("{} {description}", spaced(name)).to_lowercase();
    let says = |all: &[&str], text: &str| all.iter().any(|words| has(text, words));
    let left = says(&LEFT, &text);
    // Every word for the left in which one for the right stands is taken out first.
    let rest = LEFT.iter().fold(text.clone(), |rest, words| rest.replace(words, " "));
    let right = says(&RIGHT, &rest) || has(&spaced(name).to_lowercase(), "right");
    let left = left || has(&spaced(name).to_lowercase(), "left");
    let north = quantity == "psi" && says(&NORTH, &text);
    let mut sense = Sense { reversed: right && !left, ..Sense::default() };
    if north {
        // From north clockwise: ours is a quarter turn less theirs. From north to the left: more.
        sense.reversed = !left;
        sense.offset = FRAC_PI_2;
        if !left && !right {
            sense.doubt = Some("from north, taken for clockwise".to_owned());
        }
    } else if left && right {
        sense.doubt =
            Some("left and right are both named: taken for positive to the left".to_owned());
    } else if !left && !right {
        sense.doubt = Some("its sense is not stated: taken for positive to the left".to_owned());
    }
    // y of a world frame is no side of the car.
    if quantity == "y" {
        let down = has(&text, "ned") || sense.reversed;
        sense = Sense { reversed: down, ..Sense::default() };
    }
    sense
}

/// A name in words: `steerRight_deg` is `steer Right deg`.
fn spaced(name: &str) -> String {
    let mut out = String::new();
    let mut lower = false;
    for c in name.chars() {
        if c.is_uppercase() && lower {
            out.push(' ');
        }
        lower = c.is_lowercase();
        out.push(if c.is_alphanumeric() { c } else { ' ' });
    }
    out
}

/// Whether the words stand in the text, not as a part of longer ones.
fn has(text: &str, words: &str) -> bool {
    text.match_indices(words).any(|(at, _)| {
        let free = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric());
        free(text[..at].chars().next_back()) && free(text[at + words.len()..].chars().next())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_say_which_way_a_quantity_counts() {
        for (quantity, name, description, reversed, offset, sure) in [
            ("delta", "steer", "road wheel angle, positive to the right", true, 0.0, true),
            ("delta", "steeringRight", "", true, 0.0, true),
            ("delta", "steer", "left positive", false, 0.0, true),
            ("delta", "steer", "", false, 0.0, false),
            ("omega_z", "yaw_rate_cw", "", true, 0.0, true),
            ("omega_z", "r", "counter-clockwise", false, 0.0, true),
            ("omega_z", "r", "anticlockwise seen from above", false, 0.0, true),
            ("psi", "hdg", "clockwise from north", true, FRAC_PI_2, true),
            ("psi", "hdg", "compass heading", true, FRAC_PI_2, false),
            ("psi", "hdg", "counter-clockwise from north", false, FRAC_PI_2, true),
            ("psi", "yaw", "in a left-hand frame", true, 0.0, true),
            ("v_y", "vy", "clockwork of the right-angled box", false, 0.0, false),
            ("v_x", "v", "", false, 0.0, true),
            ("y", "pos_y", "", false, 0.0, true),
        ] {
            let found = sense(quantity, name, description);
            let expected = (reversed, offset, sure);
            let found = (found.reversed, found.offset, found.doubt.is_none());
            assert_eq!(found, expected, "{quantity} {name} {description}");
        }
    }
}
