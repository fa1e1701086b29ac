//! The nearest known key in place of a list of all of them.

/// Least similarity (Jaro-Winkler) at which a key is proposed.
const SIMILAR: f64 = 0.8;

/// Replaces serde's "unknown field `x`, expected one of `a`, `b`, ..." within a message by the key that
/// is nearest to x; leaves any other message as it is.
#[must_use]
pub fn explain_unknown_key(message: &str) -> String {
    const BEGIN: &str = "unknown field `";
    let Some(start) = message.find(BEGIN) else { return message.to_owned() };
    let rest = &message[start..];
    let end = rest.find('\n').unwrap_or(rest.len());
    let mut names = rest[..end].split('`').skip(1).step_by(2);
    let Some(found) = names.next() else { return message.to_owned() };
    let nearest = names
        .map(|name| (similarity(found, name), name))
        .filter(|(similarity, _)| *similarity >= SIMILAR)
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let answer = match nearest {
        Some((_, name)) => format!("unknown key `{found}`, the nearest known one is `{name}`"),
        None => format!("unknown key `{found}`, and no known one here is like it"),
    };
    format!("{}{answer}{}", &message[..start], &rest[end..])
}

fn similarity(found: &str, name: &str) -> f64 {
    let alike = strsim::jaro_winkler(found, name);
    let part = found.len() >= 4 && name.contains(found);
    if part { alike.max(SIMILAR) } else { alike }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_key_is_proposed_or_none() {
        let known = "expected one of `mass_kg`, `delta_max_rad`, `power_max_w`\nmore";
        let say =
            |key: &str| explain_unknown_key(&format!("line 3: unknown field `{key}`, {known}"));
        assert_eq!(
            say("mass"),
            "line 3: unknown key `mass`, the nearest known one is `mass_kg`\nmore"
        );
        assert!(say("delta_max_deg").contains("`delta_max_rad`"));
        assert!(say("power").contains("`power_max_w`") && say("delta").contains("`delta_max_rad`"));
        assert!(say("colour").contains("no known one"));
        assert_eq!(explain_unknown_key("missing field `b`"), "missing field `b`");
    }
}
