//! States that went out: a command has to answer one of them.

use lcm_types::{MonoTime, SeqNumber};

/// States remembered; a source at 1 kHz fills them in the age that a command may have. \[-\]
const KEPT: usize = 128;

/// When the last states went out, by sequence number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Published {
    newest: Option<SeqNumber>,
    at: [MonoTime; KEPT],
}

impl Default for Published {
    fn default() -> Self {
        Self { newest: None, at: [MonoTime::EARLIEST; KEPT] }
    }
}

impl Published {
    /// Notes that the state with this sequence number went out.
    pub(super) fn note(&mut self, seq: SeqNumber, now: MonoTime) {
        if self.newest.is_none_or(|newest| seq > newest) {
            self.newest = Some(seq);
            if let Some(at) = self.at.get_mut(slot(seq)) {
                *at = now;
            }
        }
    }

    /// Whether this is the number of a state that went out at most `age_ns` ago.
    pub(super) fn is_recent(&self, seq: SeqNumber, now: MonoTime, age_ns: i64) -> bool {
        let known = self.newest.is_some_and(|newest| {
            (0..KEPT as i64).contains(&newest.get().saturating_sub(seq.get())) && seq.get() >= 0
        });
        let at = self.at.get(slot(seq)).copied().unwrap_or(MonoTime::EARLIEST);
        known && now.ns_since(at) <= age_ns
    }
}

fn slot(seq: SeqNumber) -> usize {
    usize::try_from(seq.get().rem_euclid(KEPT as i64)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_state_that_went_out_lately_is_answered() {
        let (number, at) = (SeqNumber::new, MonoTime::from_ns);
        let mut published = Published::default();
        assert!(!published.is_recent(number(0), at(0), i64::MAX), "nothing went out");
        for seq in 0..300 {
            published.note(number(seq), at(1000 + seq));
        }
        let recent = |seq: i64| published.is_recent(number(seq), at(1299), 50);
        assert!(recent(299) && recent(249));
        assert!(!recent(248), "too long ago");
        assert!(!recent(300) && !recent(-1) && !recent(i64::MIN) && !recent(i64::MAX));
        // Its place has been taken by a newer one.
        assert!(published.is_recent(number(172), at(1299), 200));
        assert!(!published.is_recent(number(171), at(1299), 200));
        published.note(number(5), at(1300));
        assert!(
            !published.is_recent(number(5), at(1300), 50),
            "a number that goes back is no new state"
        );
    }
}
