//! Numbers of a message's header that must not be taken for one another: who, which, when.
//!
//! On the wire they are plain `int64_t`. [`Header::boot_id`], [`Header::seq`] and
//! [`Header::mono_ns`] are typed by [`Header::sender_start`], [`Header::number`] and
//! [`Header::sent`].

use std::fmt;

use crate::Header;

macro_rules! plain_number {
    ($($(#[$doc:meta])* $name:ident)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
        pub struct $name(i64);

        impl $name {
            /// From the number in a message.
            #[must_use]
            pub const fn new(number: i64) -> Self {
                Self(number)
            }

            /// The number for a message.
            #[must_use]
            pub const fn get(self) -> i64 {
                self.0
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }
    )*};
}

plain_number! {
    /// One start of a program: a random number, drawn when it starts. A change is a restart. \[-\]
    BootId

    /// The permission to drive that a bridge gives with ARM and a controller echoes. \[-\]
    ArmToken

    /// Number of a message on its channel: 0 at the start of its sender, +1 for each. \[-\]
    SeqNumber
}

impl BootId {
    /// No program: what an order holds that names none.
    pub const NONE: Self = Self(0);

    /// Whether no program is meant.
    #[must_use]
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }
}

impl ArmToken {
    /// No permission is in force.
    pub const NONE: Self = Self(0);

    /// Whether no permission is in force.
    #[must_use]
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }
}

impl SeqNumber {
    /// Numbers at most this far ahead of the last are accepted: a greater jump is not explained by
    /// lost messages. \[-\]
    pub const WINDOW: i64 = 100;

    /// The number of the next message.
    #[must_use]
    pub const fn next(self) -> Self {
        Self(self.0.saturating_add(1))
    }

    /// Whether this number may come after `last`: greater, and in its window.
    #[must_use]
    pub const fn follows(self, last: Self) -> bool {
        self.0 > last.0 && self.0.saturating_sub(last.0) <= Self::WINDOW
    }

    /// Messages missing between `last` and this one. \[-\]
    #[must_use]
    pub const fn missing_after(self, last: Self) -> i64 {
        self.0.saturating_sub(last.0).saturating_sub(1)
    }
}

/// Number of a lap on a network: from 0, whoever drove it. People read of its number, from 1. \[-\]
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct LapIndex(i32);

impl LapIndex {
    /// From the number in a message.
    #[must_use]
    pub const fn new(index: i32) -> Self {
        Self(index)
    }

    /// The lap of a car that has completed so many; the first where a message cannot hold the number.
    #[must_use]
    pub fn after(completed: i64) -> Self {
        Self(i32::try_from(completed).unwrap_or(0))
    }

    /// The number for a message.
    #[must_use]
    pub const fn get(self) -> i32 {
        self.0
    }
}

/// A time on the `CLOCK_MONOTONIC` of one host. Times of two hosts cannot be compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct MonoTime(i64);

impl MonoTime {
    /// Before everything.
    pub const EARLIEST: Self = Self(i64::MIN);
    /// After everything: what never happens.
    pub const NEVER: Self = Self(i64::MAX);

    /// From the clock's reading. \[ns\]
    #[must_use]
    pub const fn from_ns(ns: i64) -> Self {
        Self(ns)
    }

    /// The clock's reading. \[ns\]
    #[must_use]
    pub const fn as_ns(self) -> i64 {
        self.0
    }

    /// Time from `earlier` to this; negative if that is later. \[ns\]
    #[must_use]
    pub const fn ns_since(self, earlier: Self) -> i64 {
        self.0.saturating_sub(earlier.0)
    }

    /// As long after this. \[ns\]
    #[must_use]
    pub const fn plus_ns(self, ns: i64) -> Self {
        Self(self.0.saturating_add(ns))
    }

    /// As long before this. \[ns\]
    #[must_use]
    pub const fn minus_ns(self, ns: i64) -> Self {
        Self(self.0.saturating_sub(ns))
    }
}

impl Header {
    /// The start of the program that sent the message.
    #[must_use]
    pub const fn sender_start(&self) -> BootId {
        BootId::new(self.boot_id)
    }

    /// The message's number on its channel.
    #[must_use]
    pub const fn number(&self) -> SeqNumber {
        SeqNumber::new(self.seq)
    }

    /// When the message was sent, on its sender's clock.
    #[must_use]
    pub const fn sent(&self) -> MonoTime {
        MonoTime::from_ns(self.mono_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_follows_in_a_window_and_what_lies_between_is_missing() {
        let n = SeqNumber::new;
        assert!(n(6).follows(n(5)) && n(105).follows(n(5)));
        assert!(!n(5).follows(n(5)) && !n(4).follows(n(5)) && !n(106).follows(n(5)));
        assert_eq!((n(6).missing_after(n(5)), n(9).missing_after(n(5))), (0, 3));
        // Numbers of an attacker's choice do not overflow.
        assert!(!n(i64::MAX).follows(n(i64::MIN)) && !n(i64::MIN).follows(n(i64::MAX)));
        assert_eq!(n(i64::MAX).next(), n(i64::MAX));
    }

    #[test]
    fn times_of_an_attackers_choice_do_not_overflow() {
        let (first, last) = (MonoTime::EARLIEST, MonoTime::NEVER);
        assert_eq!((last.ns_since(first), first.ns_since(last)), (i64::MAX, i64::MIN));
        assert_eq!((last.plus_ns(1), first.minus_ns(1)), (last, first));
        let at = MonoTime::from_ns(5);
        assert_eq!((at.plus_ns(3).ns_since(at), at.minus_ns(3).ns_since(at)), (3, -3));
    }
}
