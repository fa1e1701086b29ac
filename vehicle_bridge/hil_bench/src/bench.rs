//! Content of a bench file: processes, scenarios, faults, expectations.

use std::collections::BTreeSet;

use serde::Deserialize;

use super::fault::{Fault, FaultKind};
use super::measure::{Expectation, Name};

/// A bench file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bench {
    /// Heading of the verdict.
    pub title: String,
    /// Car: a name, or a file beside the bench file or from here.
    #[serde(default = "small_car")]
    pub car: String,
    /// Track: likewise.
    #[serde(default = "short_track")]
    pub track: String,
    /// Runs of each scenario, each with a seed of its own, unless the scenario says otherwise. \[-\]
    #[serde(default = "once")]
    pub repeats: u32,
    /// Seed of the first run. \[-\]
    #[serde(default)]
    pub seed: u64,
    /// Whether the car side wants to be armed and started by the operator first.
    #[serde(default)]
    pub arming: bool,
    /// Processes a scenario may start.
    #[serde(default, rename = "process")]
    pub processes: Vec<Process>,
    /// Scenarios.
    #[serde(rename = "scenario")]
    pub scenarios: Vec<Scenario>,
}

/// A program on the network.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Process {
    /// What faults call it.
    pub name: String,
    /// Arguments; `{lmpc}` is this program, `{car_url}` and `{control_url}` the two networks with
    /// the fault proxy between them, `{dir}` a folder that lives as long as the run, `{seed}` the
    /// run's seed.
    pub command: Vec<String>,
    /// It is ready once a message arrived on this channel, for example `HB/bridge`.
    pub ready: Option<String>,
    /// Event log written by this process. If set, measures are read from it after the run instead of
    /// from the network. For runs in which the network is down.
    pub log: Option<String>,
}

/// Who commands the car.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// The harness: centre-line tracking at a speed, with the real protocol.
    #[default]
    Light,
    /// One of the processes, for example `lmpc serve`; the harness is only the operator.
    Process,
}

/// One scenario.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name in the verdict.
    pub name: String,
    /// Row of the fault table it covers.
    pub row: Option<u32>,
    /// What the row expects, in words.
    #[serde(default)]
    pub expected: String,
    /// Runs; the bench's unless given. \[-\]
    pub repeats: Option<u32>,
    /// A program that is the whole scenario, in the words of a process's command: each line
    /// `name value` it prints is a measure, beside `exit_code` (0 unless expected otherwise) and
    /// `duration_s`.
    #[serde(default)]
    pub program: Vec<String>,
    /// Text that the program's output must contain.
    #[serde(default)]
    pub says: Vec<String>,
    /// Whether no other run goes on at the same time: for faults that take the whole computer.
    #[serde(default)]
    pub alone: bool,
    /// Whether the operator holds a dead man's switch.
    #[serde(default)]
    pub deadman: bool,
    /// Whether the network has a key, `{dir}/key`: the harness signs, and its processes do with
    /// `--key {dir}/key`.
    #[serde(default)]
    pub key: bool,
    /// Processes to start, by name, in this order.
    #[serde(default)]
    pub processes: Vec<String>,
    /// Who commands the car.
    #[serde(default)]
    pub source: Source,
    /// Speed the reference driver drives at. \[m/s\]
    #[serde(default = "two")]
    pub speed_mps: f64,
    /// When the faults begin to count; unless given, at 1 m/s after 0.8 s.
    #[serde(default = "rolling")]
    pub when: When,
    /// How long is observed from there on. \[s\]
    #[serde(default = "observe")]
    pub observe_s: f64,
    /// Longest time until `when` holds, or the program has ended; longer is a failure of the run.
    /// \[s\]
    #[serde(default = "patience")]
    pub patience_s: f64,
    /// Faults.
    #[serde(default, rename = "fault")]
    pub faults: Vec<Fault>,
    /// Size of a file system of the run's own, `{dir}/disk`, that `fill_disk` fills. \[MB\]
    pub disk_mb: Option<u32>,
    /// What has to hold.
    #[serde(default, rename = "expect")]
    pub expectations: Vec<Expectation>,
}

/// When faults begin: every condition given has to hold.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct When {
    /// Instead of all others: the car side refuses an order, with this in its words.
    pub refused: Option<String>,
    /// Time since the first command was applied, and up to 0.1 s more by the seed. \[s\]
    pub driving_s: f64,
    /// Speed. \[m/s\]
    pub speed_mps: f64,
    /// Position along the centre line, from here on and within 1 m. \[m\]
    pub s_m: Option<f64>,
    /// Laps begun. \[-\]
    pub lap: i32,
}

impl Scenario {
    /// Whether a fault takes the network away.
    #[must_use]
    pub fn is_alone(&self) -> bool {
        self.faults.iter().any(|fault| matches!(fault.action, FaultKind::NetworkDown {}))
    }

    /// What is wrong with its file system.
    fn disk_problem(&self) -> Option<String> {
        let fills = self.faults.iter().any(|f| matches!(f.action, FaultKind::FillDisk {}));
        match self.disk_mb {
            None if fills => Some("fault fill_disk: the scenario has no disk_mb".to_owned()),
            Some(mb) if !(1..=1024).contains(&mb) => {
                Some(format!("disk_mb is {mb}, expected 1 to 1024"))
            }
            _ => None,
        }
    }

    /// What does not go with a program, or not without one.
    fn program_problems(&self) -> Vec<String> {
        let printed = self.expectations.iter().filter_map(|e| match &e.measure {
            Name::Printed(name) => Some(name),
            Name::Observed(_) => None,
        });
        if self.program.is_empty() {
            let unknown = printed.map(|name| {
                format!("measure `{name}` is not known; only a `program` prints its own")
            });
            let says = (!self.says.is_empty()).then(|| "says: only with `program`".to_owned());
            return unknown.chain(says).collect();
        }
        let driven = !self.processes.is_empty() || !self.faults.is_empty();
        let mixed = driven.then(|| "program: not together with processes and faults".to_owned());
        mixed.into_iter().collect()
    }
}

impl Bench {
    /// Every value that is out of range or names nothing.
    #[must_use]
    pub fn problems(&self) -> Vec<String> {
        let mut problems = Vec::new();
        let names: BTreeSet<&str> = self.processes.iter().map(|p| p.name.as_str()).collect();
        if names.len() < self.processes.len() {
            problems.push("process: two have the same name".to_owned());
        }
        if self.scenarios.is_empty() {
            problems.push("scenario: found none; expected at least one [[scenario]]".to_owned());
        }
        let mut seen = BTreeSet::new();
        for scenario in &self.scenarios {
            let at = format!("scenario `{}`", scenario.name);
            if !seen.insert(&scenario.name) {
                problems.push(format!("{at}: the name is taken by another scenario"));
            }
            for name in &scenario.processes {
                if !names.contains(name.as_str()) {
                    problems.push(format!("{at}: process `{name}` is not defined"));
                }
            }
            if scenario.expectations.is_empty() {
                problems.push(format!("{at}: expects nothing; add [[scenario.expect]]"));
            }
            problems.extend(scenario.disk_problem().map(|p| format!("{at}: {p}")));
            problems.extend(scenario.program_problems().into_iter().map(|p| format!("{at}: {p}")));
            let positive = [
                ("observe_s", scenario.observe_s),
                ("patience_s", scenario.patience_s),
                ("speed_mps", scenario.speed_mps),
            ];
            for (key, value) in positive {
                if !(value > 0.0 && value <= 3600.0) {
                    problems
                        .push(format!("{at}: {key} is {value}, expected above 0, at most 3600"));
                }
            }
            for fault in &scenario.faults {
                problems.extend(
                    fault.problems(&scenario.processes).into_iter().map(|p| format!("{at}: {p}")),
                );
            }
            problems.extend(
                scenario
                    .expectations
                    .iter()
                    .filter_map(Expectation::problem)
                    .map(|p| format!("{at}: {p}")),
            );
        }
        problems
    }

    /// Runs of a scenario. \[-\]
    #[must_use]
    pub fn repeats(&self, scenario: &Scenario) -> u32 {
        scenario.repeats.unwrap_or(self.repeats)
    }

    /// The process of this name.
    #[must_use]
    pub fn process(&self, name: &str) -> Option<&Process> {
        self.processes.iter().find(|process| process.name == name)
    }
}

fn small_car() -> String {
    "barc".to_owned()
}

fn short_track() -> String {
    "l".to_owned()
}

fn once() -> u32 {
    1
}

fn two() -> f64 {
    2.0
}

fn rolling() -> When {
    When { driving_s: 0.8, speed_mps: 1.0, ..When::default() }
}

fn observe() -> f64 {
    0.6
}

fn patience() -> f64 {
    15.0
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "code of tests")]
    use serde::de::DeserializeOwned;

    use super::*;
    use crate::fault::Field;
    use crate::measure::Measure;

    /// The names a type knows, as its refusal of another one lists them.
    fn known<T: DeserializeOwned>(wrong: &str) -> Vec<String> {
        let refusal = serde_json::from_str::<T>(wrong).err().unwrap().to_string();
        let names = refusal.split('`').skip(3).step_by(2).map(str::to_owned).collect::<Vec<_>>();
        assert!(names.len() > 2, "{refusal}");
        names
    }

    #[test]
    fn the_page_names_everything_a_bench_file_can_say() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/bench.md");
        let page = std::fs::read_to_string(path).unwrap();
        let words: BTreeSet<&str> = page
            .split('`')
            .skip(1)
            .step_by(2)
            .flat_map(|code| code.split(|c: char| !c.is_ascii_alphanumeric() && c != '_'))
            .collect();
        let all = [
            known::<Bench>(r#"{"no": 1}"#),
            known::<Process>(r#"{"no": 1}"#),
            known::<Scenario>(r#"{"no": 1}"#),
            known::<When>(r#"{"no": 1}"#),
            known::<Fault>(r#"{"no": 1}"#),
            known::<FaultKind>(r#"{"no": {}}"#),
            known::<Field>(r#""no""#),
            known::<Measure>(r#""no""#),
            known::<Expectation>(r#"{"no": 1}"#),
        ];
        let missing: Vec<_> =
            all.iter().flatten().filter(|name| !words.contains(name.as_str())).collect();
        assert!(missing.is_empty(), "docs/bench.md does not name {missing:?}");
    }
}
