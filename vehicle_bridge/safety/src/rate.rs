//! How much a sender may say.

use lcm_types::{BootId, MonoTime};

/// Senders told apart; the one silent longest makes room. \[-\]
const SENDERS: usize = 8;
/// Length of a window. \[ns\]
const WINDOW_NS: i64 = 100_000_000;
/// Messages a sender may send in a window: ten times 100 Hz. \[-\]
const MOST: u32 = 100;

/// One sender's window.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Window {
    boot_id: BootId,
    begun: MonoTime,
    count: u32,
}

/// Messages of each sender in its current window.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Rate([Window; SENDERS]);

impl Rate {
    /// Counts a message; false if it is one too many.
    pub(super) fn admit(&mut self, boot_id: BootId, now: MonoTime) -> bool {
        let known = self.0.iter().position(|w| w.boot_id == boot_id && w.count > 0);
        let oldest = || {
            let windows = self.0.iter().enumerate();
            windows.min_by_key(|(_, w)| (w.count > 0, w.begun)).map_or(0, |(i, _)| i)
        };
        let index = known.unwrap_or_else(oldest);
        let Some(window) = self.0.get_mut(index) else { return false };
        if known.is_none() || now.ns_since(window.begun) >= WINDOW_NS {
            *window = Window { boot_id, begun: now, count: 0 };
        }
        window.count = window.count.saturating_add(1);
        window.count <= MOST
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sender_in_a_storm_is_cut_off_and_no_other() {
        let mut rate = Rate::default();
        let admitted = |rate: &mut Rate, id, n: i64, from: i64| {
            (0..n)
                .filter(|i| rate.admit(BootId::new(id), MonoTime::from_ns(from + i * 1000)))
                .count()
        };
        assert_eq!(admitted(&mut rate, 1, 1000, 0), 100);
        assert_eq!(admitted(&mut rate, 2, 30, 0), 30);
        assert_eq!(admitted(&mut rate, 1, 1, 50_000_000), 0);
        assert_eq!(admitted(&mut rate, 1, 10, WINDOW_NS), 10);
    }

    #[test]
    fn a_window_begins_with_its_senders_first_message() {
        for id in [0, 1] {
            let mut rate = Rate::default();
            let mut say =
                |now_ms: i64| rate.admit(BootId::new(id), MonoTime::from_ns(now_ms * 1_000_000));
            assert!((0..100).all(|_| say(50)));
            assert!(!say(149), "{id}");
            assert!(say(150), "{id}");
        }
    }

    #[test]
    fn the_sender_silent_longest_makes_room() {
        let mut rate = Rate::default();
        let mut say = |id: i64, now_ms: i64| {
            rate.admit(BootId::new(id), MonoTime::from_ns(now_ms * 1_000_000))
        };
        for id in 1..=8 {
            assert!((0..100).all(|_| say(id, 10 + id)));
        }
        assert!(say(9, 20), "the ninth takes the place of the first");
        assert!((2..=8).all(|id| !say(id, 21)), "the others are still counted");
        assert!(say(1, 22), "and the first begins anew");
    }
}
