//! Programs on the network that should not be there: a second source of states, a second bridge,
//! several controllers.

use std::sync::Arc;
use std::time::{Duration, Instant};

use lcm_types::{BootId, Header};

/// A program not heard for this long is considered gone.
const SILENCE: Duration = Duration::from_secs(1);
/// Programs named. \[-\]
const MOST: usize = 8;

/// What a program sends that is noted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// `CAR/STATE`.
    Car,
    /// `HB/bridge`.
    Bridge,
    /// `HB/lmpc`.
    Controller,
}

#[derive(Debug, Clone, PartialEq)]
struct Program {
    role: Role,
    boot_id: BootId,
    sender: Arc<str>,
    heard: Instant,
}

/// The programs heard lately.
#[derive(Debug, Clone, Default)]
pub(super) struct Neighbours {
    own: BootId,
    programs: Vec<Program>,
    changed: bool,
}

impl Neighbours {
    /// Of the bridge with this boot id.
    pub(super) fn new(own: BootId) -> Self {
        Self { own, ..Self::default() }
    }

    /// Notes who sent a message.
    pub(super) fn note(&mut self, role: Role, h: &Header) {
        if h.sender_start() == self.own {
            return;
        }
        let known = |p: &&mut Program| (p.role, p.boot_id) == (role, h.sender_start());
        if let Some(program) = self.programs.iter_mut().find(known) {
            program.heard = Instant::now();
        } else if self.programs.len() < MOST {
            let (boot_id, sender, heard) =
                (h.sender_start(), h.sender.as_str().into(), Instant::now());
            self.programs.push(Program { role, boot_id, sender, heard });
            self.changed = true;
        }
    }

    /// What there is to report, if it changed since the last call.
    pub(super) fn news(&mut self) -> Option<Option<Arc<str>>> {
        let before = self.programs.len();
        self.programs.retain(|program| program.heard.elapsed() < SILENCE);
        self.changed |= self.programs.len() < before;
        std::mem::take(&mut self.changed).then(|| self.words().map(Into::into))
    }

    fn words(&self) -> Option<String> {
        let named = |role: Role| {
            let of = self.programs.iter().filter(|program| program.role == role);
            of.map(|p| format!("{} (boot id {})", p.sender, p.boot_id)).collect::<Vec<_>>()
        };
        let mut words = Vec::new();
        let (cars, bridges) = (named(Role::Car), named(Role::Bridge));
        if !bridges.is_empty() {
            words.push(format!("another bridge on this network: {}", bridges.join(", ")));
        }
        if !cars.is_empty() {
            words.push(format!("another sender of CAR/STATE: {}", cars.join(", ")));
        }
        let controllers = named(Role::Controller);
        if controllers.len() > 1 {
            words.push(format!("{} controllers: {}", controllers.len(), controllers.join(", ")));
        }
        (!words.is_empty()).then(|| words.join("; "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_should_not_be_there_is_named_once() {
        let mut neighbours = Neighbours::new(BootId::new(1));
        let h =
            |boot_id, sender: &str| Header { boot_id, sender: sender.into(), ..Header::default() };
        neighbours.note(Role::Car, &h(1, "bridge@here"));
        assert_eq!(neighbours.news(), None, "itself");
        neighbours.note(Role::Controller, &h(2, "lmpc@here"));
        assert_eq!(neighbours.news(), Some(None), "one controller is as it should be");
        neighbours.note(Role::Controller, &h(3, "lmpc@there"));
        neighbours.note(Role::Car, &h(4, "car@here"));
        neighbours.note(Role::Car, &h(4, "car@here"));
        let words = "another sender of CAR/STATE: car@here (boot id 4); 2 controllers: \
                     lmpc@here (boot id 2), lmpc@there (boot id 3)";
        assert_eq!(neighbours.news(), Some(Some(words.into())));
        assert_eq!(neighbours.news(), None);
    }
}
