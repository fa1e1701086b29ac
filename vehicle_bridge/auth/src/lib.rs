//! Messages that only holders of a key can send.
//!
//! [`Signed`] stands before a network. It puts a signature behind every message of ours and lets in
//! only messages with one that holds: made with the [`Key`], for this channel, by a program that
//! proved that it runs now ([`peers`]), and not seen before. An emergency stop is let in without.
//! `docs/threats.md` says what that prevents and what not.

mod key;
pub mod peers;
mod signed;
#[cfg(test)]
mod tests;

pub use key::{Key, KeyError};
pub use signed::{Refusals, Seal, Signed};
