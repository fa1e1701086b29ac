//! Checks of a received stream: sequence, sender, age. Pure: the caller passes the time.

use lcm_types::{BootId, Checked, Error, Header, MonoTime, SeqNumber};

/// Why a message is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RejectReason {
    /// Malformed, failed checksum, or values that cannot be.
    Bad,
    /// Another type, or another version of it.
    WrongType,
    /// Repeated, out of order, or from a sender that is not the one listened to.
    Old,
    /// Too old on arrival.
    Stale,
}

/// Counts of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StreamCounts {
    /// Accepted. \[-\]
    pub ok: i64,
    /// Refused as [`RejectReason::Bad`] or as [`RejectReason::WrongType`]. \[-\]
    pub bad: i64,
    /// Refused as [`RejectReason::WrongType`]. \[-\]
    pub wrong_type: i64,
    /// Refused as [`RejectReason::Old`]. \[-\]
    pub old: i64,
    /// Refused as [`RejectReason::Stale`]. \[-\]
    pub stale: i64,
    /// Missing by the numbers. \[-\]
    pub lost: i64,
}

/// One stream: a channel with one sender.
#[derive(Debug, Clone)]
pub struct StreamFilter {
    /// Oldest message accepted. \[ns\]
    pub max_age_ns: i64,
    /// A new sender, or a sender started again, is believed after this silence. Only where there is
    /// no bridge: there a controller's start is believed by its grant (`docs/safety.md`). \[ns\]
    pub silence_ns: i64,
    /// Name of this host, as in the end of `sender`: its clock is ours.
    pub host: String,
    /// Counts so far.
    pub counts: StreamCounts,
    last: Option<Last>,
}

#[derive(Debug, Clone, Copy)]
struct Last {
    boot_id: BootId,
    seq: SeqNumber,
    arrival: MonoTime,
}

/// An accepted message.
#[derive(Debug, Clone, PartialEq)]
pub struct Accepted<M> {
    /// The message.
    pub message: M,
    /// The first of its sender's start.
    pub fresh_start: bool,
}

impl StreamFilter {
    /// Listens to whoever speaks first.
    #[must_use]
    pub fn new(max_age_ns: i64, silence_ns: i64, host: &str) -> Self {
        let counts = StreamCounts::default();
        Self { max_age_ns, silence_ns, host: host.to_owned(), counts, last: None }
    }

    /// Checks in this order: checksum, type, `sane`, age, sender, number.
    ///
    /// # Errors
    /// Why the message is refused; it is counted.
    pub fn check<M: Checked>(
        &mut self,
        bytes: &[u8],
        (arrival, now): (MonoTime, MonoTime),
        header: impl Fn(&M) -> &Header,
        sane: impl Fn(&M) -> bool,
    ) -> Result<Accepted<M>, RejectReason> {
        let checked = self.examine(bytes, arrival, now, header, sane);
        match checked {
            Ok(_) => self.counts.ok += 1,
            Err(RejectReason::Bad) => self.counts.bad += 1,
            Err(RejectReason::WrongType) => {
                self.counts.bad += 1;
                self.counts.wrong_type += 1;
            }
            Err(RejectReason::Old) => self.counts.old += 1,
            Err(RejectReason::Stale) => self.counts.stale += 1,
        }
        checked
    }

    fn examine<M: Checked>(
        &mut self,
        bytes: &[u8],
        arrival: MonoTime,
        now: MonoTime,
        header: impl Fn(&M) -> &Header,
        sane: impl Fn(&M) -> bool,
    ) -> Result<Accepted<M>, RejectReason> {
        let message = M::open(bytes).map_err(|error| match error {
            Error::Fingerprint { .. } => RejectReason::WrongType,
            _ => RejectReason::Bad,
        })?;
        if !sane(&message) {
            return Err(RejectReason::Bad);
        }
        let h = header(&message);
        let local = h.sender.rsplit('@').next() == Some(self.host.as_str());
        // Another host's clock says nothing here: then the arrival has to do.
        let since = if local { h.sent().min(arrival) } else { arrival };
        if now.ns_since(since) > self.max_age_ns {
            return Err(RejectReason::Stale);
        }
        let fresh_start = match self.last {
            None => true,
            Some(last) => {
                let next = last.boot_id == h.sender_start() && h.number().follows(last.seq);
                let silent = arrival.ns_since(last.arrival) > self.silence_ns;
                if !next && !silent {
                    return Err(RejectReason::Old);
                }
                if next {
                    self.counts.lost += h.number().missing_after(last.seq);
                }
                !next && last.boot_id != h.sender_start()
            }
        };
        self.last = Some(Last { boot_id: h.sender_start(), seq: h.number(), arrival });
        Ok(Accepted { message, fresh_start })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lcm_types::VehicleState;

    const MS: i64 = 1_000_000;

    fn filter() -> StreamFilter {
        StreamFilter::new(100 * MS, 1000 * MS, "here")
    }

    fn bytes(boot_id: i64, seq: i64, mono_ns: i64, sender: &str) -> Vec<u8> {
        let sender = sender.to_owned();
        let h = Header { boot_id, seq, mono_ns, sender, ..Header::default() };
        let mut bytes = Vec::new();
        VehicleState { h, ..VehicleState::default() }.seal_into(&mut bytes).unwrap();
        bytes
    }

    fn at(filter: &mut StreamFilter, bytes: &[u8], now: i64) -> Result<bool, RejectReason> {
        let sane = |state: &VehicleState| state.vx.is_finite();
        let checked = filter.check(
            bytes,
            (MonoTime::from_ns(now), MonoTime::from_ns(now)),
            |state: &VehicleState| &state.h,
            sane,
        );
        checked.map(|accepted| accepted.fresh_start)
    }

    #[test]
    fn repeated_swapped_and_replayed_messages_are_old() {
        let mut filter = filter();
        let mut say = |seq| at(&mut filter, &bytes(7, seq, 0, "car@there"), 0);
        assert_eq!(say(5), Ok(true));
        assert_eq!((say(5), say(6), say(8)), (Err(RejectReason::Old), Ok(false), Ok(false)));
        assert_eq!(
            (say(7), say(6), say(500)),
            (Err(RejectReason::Old), Err(RejectReason::Old), Err(RejectReason::Old))
        );
        let expected = StreamCounts { ok: 3, old: 4, lost: 1, ..StreamCounts::default() };
        assert_eq!(filter.counts, expected);
    }

    #[test]
    fn a_second_sender_is_refused_until_the_first_is_silent() {
        let mut filter = filter();
        assert_eq!(at(&mut filter, &bytes(7, 0, 0, "car@there"), 0), Ok(true));
        assert_eq!(at(&mut filter, &bytes(8, 0, 0, "car@there"), 900 * MS), Err(RejectReason::Old));
        assert_eq!(at(&mut filter, &bytes(8, 1, 0, "car@there"), 1100 * MS), Ok(true));
        assert_eq!(
            at(&mut filter, &bytes(7, 1, 0, "car@there"), 1200 * MS),
            Err(RejectReason::Old)
        );
    }

    #[test]
    fn only_this_hosts_clock_tells_the_age() {
        let mut filter = filter();
        let late = bytes(7, 0, 0, "car@here");
        assert_eq!(at(&mut filter, &late, 300 * MS), Err(RejectReason::Stale));
        assert_eq!(at(&mut filter, &bytes(7, 0, 0, "car@there"), 300 * MS), Ok(true));
    }

    #[test]
    fn a_flipped_bit_is_bad_wherever_it_is() {
        let mut filter = filter();
        let good = bytes(7, 0, 0, "car@there");
        for bit in 0..8 * good.len() {
            let mut flipped = good.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(at(&mut filter, &flipped, 0), Err(RejectReason::Bad), "bit {bit}");
        }
        assert_eq!(at(&mut filter, &good, 0), Ok(true));
    }
}
