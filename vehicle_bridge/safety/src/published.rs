//! States that went out: a command has to answer one of them.

/// States remembered; a source at 1 kHz fills them in the age that a command may have. \[-\]
const KEPT: usize = 128;

/// When the last states went out, by sequence number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Published {
    newest: Option<i64>,
    at_ns: [i64; KEPT],
}

impl Default for Published {
    fn default() -> Self {
        Self { newest: None, at_ns: [i64::MIN; KEPT] }
    }
}

impl Published {
    /// Notes that the state with this sequence number went out.
    pub(super) fn note(&mut self, seq: i64, now_ns: i64) {
        if self.newest.is_none_or(|newest| seq > newest) {
            self.newest = Some(seq);
            if let Some(at) = self.at_ns.get_mut(slot(seq)) {
                *at = now_ns;
            }
        }
    }

    /// Whether this is the number of a state that went out at most `age_ns` ago.
    pub(super) fn is_recent(&self, seq: i64, now_ns: i64, age_ns: i64) -> bool {
        let known = self.newest.is_some_and(|newest| {
            (0..KEPT as i64).contains(&newest.saturating_sub(seq)) && seq >= 0
        });
        let at = self.at_ns.get(slot(seq)).copied().unwrap_or(i64::MIN);
        known && now_ns.saturating_sub(at) <= age_ns
    }
}

fn slot(seq: i64) -> usize {
    usize::try_from(seq.rem_euclid(KEPT as i64)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_state_that_went_out_lately_is_answered() {
        let mut published = Published::default();
        assert!(!published.is_recent(0, 0, i64::MAX), "nothing went out");
        for seq in 0..300 {
            published.note(seq, 1000 + seq);
        }
        let recent = |seq: i64| published.is_recent(seq, 1299, 50);
        assert!(recent(299) && recent(249));
        assert!(!recent(248), "too long ago");
        assert!(!recent(300) && !recent(-1) && !recent(i64::MIN) && !recent(i64::MAX));
        // Its place has been taken by a newer one.
        assert!(published.is_recent(172, 1299, 200) && !published.is_recent(171, 1299, 200));
        published.note(5, 1300);
        assert!(!published.is_recent(5, 1300, 50), "a number that goes back is no new state");
    }
}
