//! What a receiver demands of a stream before it believes it. Pure: the host brings the time.

use lcm_types::{Checked, Header};

/// Numbers this far ahead of the last are believed; a greater leap is no loss of messages. \[-\]
const WINDOW: i64 = 100;

/// Why a message is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// Malformed, another type, failed checksum, or values that cannot be.
    Bad,
    /// Repeated, out of order, or from a sender that is not the one listened to.
    Old,
    /// Too old on arrival.
    Stale,
}

/// Counts of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Accepted. \[-\]
    pub ok: i64,
    /// Refused as [`Refusal::Bad`]. \[-\]
    pub bad: i64,
    /// Refused as [`Refusal::Old`]. \[-\]
    pub old: i64,
    /// Refused as [`Refusal::Stale`]. \[-\]
    pub stale: i64,
    /// Missing by the numbers. \[-\]
    pub lost: i64,
}

/// One stream: a channel with one sender.
#[derive(Debug, Clone)]
pub struct Guard {
    /// Oldest message believed. \[ns\]
    pub max_age_ns: i64,
    /// A new sender, or a sender started again, is believed after this silence. Only where there is
    /// no bridge: there a controller's start is believed by its grant (`docs/safety.md`). \[ns\]
    pub silence_ns: i64,
    /// Name of this host, as in the end of `sender`: its clock is ours.
    pub host: String,
    /// Counts so far.
    pub counts: Counts,
    last: Option<Last>,
}

#[derive(Debug, Clone, Copy)]
struct Last {
    boot_id: i64,
    seq: i64,
    arrival_ns: i64,
}

/// A message that was believed.
#[derive(Debug, Clone, PartialEq)]
pub struct Accepted<M> {
    /// The message.
    pub message: M,
    /// The first of its sender's start.
    pub fresh_start: bool,
}

impl Guard {
    /// Listens to whoever speaks first.
    #[must_use]
    pub fn new(max_age_ns: i64, silence_ns: i64, host: &str) -> Self {
        let counts = Counts::default();
        Self { max_age_ns, silence_ns, host: host.to_owned(), counts, last: None }
    }

    /// Checks in this order: checksum, type, `sane`, age, sender, number.
    ///
    /// # Errors
    /// Why the message is refused; it is counted.
    pub fn check<M: Checked>(
        &mut self,
        bytes: &[u8],
        (arrival_ns, now_ns): (i64, i64),
        header: impl Fn(&M) -> &Header,
        sane: impl Fn(&M) -> bool,
    ) -> Result<Accepted<M>, Refusal> {
        let checked = self.examine(bytes, arrival_ns, now_ns, header, sane);
        match checked {
            Ok(_) => self.counts.ok += 1,
            Err(Refusal::Bad) => self.counts.bad += 1,
            Err(Refusal::Old) => self.counts.old += 1,
            Err(Refusal::Stale) => self.counts.stale += 1,
        }
        checked
    }

    fn examine<M: Checked>(
        &mut self,
        bytes: &[u8],
        arrival_ns: i64,
        now_ns: i64,
        header: impl Fn(&M) -> &Header,
        sane: impl Fn(&M) -> bool,
    ) -> Result<Accepted<M>, Refusal> {
        let message = M::open(bytes).map_err(|_| Refusal::Bad)?;
        if !sane(&message) {
            return Err(Refusal::Bad);
        }
        let h = header(&message);
        let local = h.sender.rsplit('@').next() == Some(self.host.as_str());
        // Another host's clock says nothing here: then the arrival has to do.
        let since = if local { h.mono_ns.min(arrival_ns) } else { arrival_ns };
        if now_ns.saturating_sub(since) > self.max_age_ns {
            return Err(Refusal::Stale);
        }
        let fresh_start = match self.last {
            None => true,
            Some(last) => {
                let next = last.boot_id == h.boot_id
                    && (last.seq + 1..=last.seq + WINDOW).contains(&h.seq);
                let silent = arrival_ns.saturating_sub(last.arrival_ns) > self.silence_ns;
                if !next && !silent {
                    return Err(Refusal::Old);
                }
                if next {
                    self.counts.lost += h.seq - last.seq - 1;
                }
                !next && last.boot_id != h.boot_id
            }
        };
        self.last = Some(Last { boot_id: h.boot_id, seq: h.seq, arrival_ns });
        Ok(Accepted { message, fresh_start })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lcm_types::VehicleState;

    const MS: i64 = 1_000_000;

    fn guard() -> Guard {
        Guard::new(100 * MS, 1000 * MS, "here")
    }

    fn bytes(boot_id: i64, seq: i64, mono_ns: i64, sender: &str) -> Vec<u8> {
        let sender = sender.to_owned();
        let h = Header { boot_id, seq, mono_ns, sender, ..Header::default() };
        let mut bytes = Vec::new();
        VehicleState { h, ..VehicleState::default() }.seal_into(&mut bytes).unwrap();
        bytes
    }

    fn at(guard: &mut Guard, bytes: &[u8], now: i64) -> Result<bool, Refusal> {
        let sane = |state: &VehicleState| state.vx.is_finite();
        let checked = guard.check(bytes, (now, now), |state: &VehicleState| &state.h, sane);
        checked.map(|accepted| accepted.fresh_start)
    }

    #[test]
    fn repeated_swapped_and_replayed_messages_are_old() {
        let mut guard = guard();
        let mut say = |seq| at(&mut guard, &bytes(7, seq, 0, "car@there"), 0);
        assert_eq!(say(5), Ok(true));
        assert_eq!((say(5), say(6), say(8)), (Err(Refusal::Old), Ok(false), Ok(false)));
        assert_eq!(
            (say(7), say(6), say(500)),
            (Err(Refusal::Old), Err(Refusal::Old), Err(Refusal::Old))
        );
        let expected = Counts { ok: 3, old: 4, lost: 1, ..Counts::default() };
        assert_eq!(guard.counts, expected);
    }

    #[test]
    fn a_second_sender_is_refused_until_the_first_is_silent() {
        let mut guard = guard();
        assert_eq!(at(&mut guard, &bytes(7, 0, 0, "car@there"), 0), Ok(true));
        assert_eq!(at(&mut guard, &bytes(8, 0, 0, "car@there"), 900 * MS), Err(Refusal::Old));
        assert_eq!(at(&mut guard, &bytes(8, 1, 0, "car@there"), 1100 * MS), Ok(true));
        assert_eq!(at(&mut guard, &bytes(7, 1, 0, "car@there"), 1200 * MS), Err(Refusal::Old));
    }

    #[test]
    fn only_this_hosts_clock_tells_the_age() {
        let mut guard = guard();
        let late = bytes(7, 0, 0, "car@here");
        assert_eq!(at(&mut guard, &late, 300 * MS), Err(Refusal::Stale));
        assert_eq!(at(&mut guard, &bytes(7, 0, 0, "car@there"), 300 * MS), Ok(true));
    }

    #[test]
    fn a_flipped_bit_is_bad_wherever_it_is() {
        let mut guard = guard();
        let good = bytes(7, 0, 0, "car@there");
        for bit in 0..8 * good.len() {
            let mut flipped = good.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(at(&mut guard, &flipped, 0), Err(Refusal::Bad), "bit {bit}");
        }
        assert_eq!(at(&mut guard, &good, 0), Ok(true));
    }
}
