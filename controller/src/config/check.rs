//! Which values a configuration may have.

use super::keys::{ConfigKey, ConfigValue, ValueKind};
use super::{Config, ConfigProblem, SECTIONS};

impl Config {
    /// Every value that is out of range.
    #[must_use]
    pub fn problems(&self) -> Vec<ConfigProblem> {
        let mut problems: Vec<ConfigProblem> = SECTIONS
            .iter()
            .flat_map(|section| section.keys)
            .flat_map(|k| of_key(k, self))
            .collect();
        if self.regression.metric.iter().sum::<f64>() <= 0.0 {
            let message = "all weights are 0; at least one must be positive".to_owned();
            problems.push(ConfigProblem { key: "regression.metric".to_owned(), message });
        }
        let (least, most) = (self.envelope.growth_least, self.envelope.growth_most);
        if most < least {
            let message = format!("{most} is below envelope.growth_least, which is {least}");
            problems.push(ConfigProblem { key: "envelope.growth_most".to_owned(), message });
        }
        problems
    }
}

fn of_key(key: &ConfigKey, config: &Config) -> Vec<ConfigProblem> {
    let Some([least, most]) = key.range else { return Vec::new() };
    let check = |name: String, found: f64| {
        let message = format!("{found} is out of range; allowed is {least} to {most}");
        (!(least..=most).contains(&found)).then_some(ConfigProblem { key: name, message })
    };
    match (key.value(config), key.kind) {
        (ConfigValue::Count(found), _) => check(key.dotted(), found as f64).into_iter().collect(),
        (ConfigValue::Number(found), _) => check(key.dotted(), found).into_iter().collect(),
        (ConfigValue::Numbers(found), ValueKind::Numbers(labels)) => {
            let entry = |(label, found): (&&str, &f64)| {
                check(format!("{} ({label})", key.dotted()), *found)
            };
            labels.iter().zip(found).filter_map(entry).collect()
        }
        _ => Vec::new(),
    }
}
