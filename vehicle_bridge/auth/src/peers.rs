//! Who proved that it runs now. Pure: the host brings time and random numbers.
//!
//! A recorded message keeps its code, so a code alone says nothing of when it was made. Every program
//! therefore greets the others (`AUTH/HELLO`) with a random challenge, and answers theirs in its own
//! greetings. A greeting that answers one of our latest two challenges was made now, by a holder of
//! the key: its sender's start is believed for [`TRUST_NS`], and no message of any other.

use lcm_types::Hello;

/// A challenge is replaced after this time, and believed as long again. \[ns\]
const CHANGE_NS: i64 = 2_000_000_000;
/// A sender is believed this long after its last answer. \[ns\]
pub const TRUST_NS: i64 = 3_000_000_000;
/// Senders remembered. \[-\]
const MOST: usize = 64;

/// Another program that holds the key.
#[derive(Debug, Clone, Copy)]
struct Peer {
    start: i64,
    challenge: i64,
    /// Number of its last greeting.
    seq: i64,
    heard_ns: i64,
    /// Number of the greeting that first answered us without a break, and when one last did.
    proven: Option<(i64, i64)>,
}

impl Peer {
    fn is_proven(&self, now_ns: i64) -> bool {
        self.proven.is_some_and(|(_, last_ns)| now_ns.saturating_sub(last_ns) <= TRUST_NS)
    }
}

/// All others, as one program knows them.
#[derive(Debug, Clone)]
pub struct Peers {
    own: i64,
    challenges: [i64; 2],
    changed_ns: i64,
    all: Vec<Peer>,
}

impl Peers {
    /// For the start `own`, with two random numbers.
    #[must_use]
    pub fn new(own: i64, challenges: [i64; 2], now_ns: i64) -> Self {
        Self { own, challenges, changed_ns: now_ns, all: Vec::with_capacity(MOST) }
    }

    /// Whether it is time for another challenge.
    #[must_use]
    pub fn wants_challenge(&self, now_ns: i64) -> bool {
        now_ns.saturating_sub(self.changed_ns) >= CHANGE_NS
    }

    /// Takes a random number as the new challenge.
    pub fn challenge(&mut self, challenge: i64, now_ns: i64) {
        self.challenges = [challenge, self.challenges[0]];
        self.changed_ns = now_ns;
    }

    /// A greeting whose code holds; whether its sender is new and ought to be greeted at once.
    pub fn greet(&mut self, hello: &Hello, (start, seq): (i64, i64), now_ns: i64) -> bool {
        if start == self.own {
            return false;
        }
        let known = self.all.iter().position(|peer| peer.start == start);
        let index = known.unwrap_or_else(|| self.meet(start, now_ns));
        let Some(peer) = self.all.get_mut(index) else { return false };
        if seq <= peer.seq {
            return false;
        }
        (peer.challenge, peer.seq, peer.heard_ns) = (hello.challenge, seq, now_ns);
        let mut answers = hello.start.iter().zip(&hello.answer);
        if answers.any(|(to, answer)| *to == self.own && self.challenges.contains(answer)) {
            let first =
                peer.proven.filter(|_| peer.is_proven(now_ns)).map_or(seq, |(first, _)| first);
            peer.proven = Some((first, now_ns));
        }
        known.is_none()
    }

    /// Makes room for a sender: of those that proved nothing, else of all, the one silent longest
    /// goes.
    fn meet(&mut self, start: i64, now_ns: i64) -> usize {
        if self.all.len() >= MOST {
            let oldest = |peer: &&Peer| (peer.is_proven(now_ns), peer.heard_ns);
            let goes = self.all.iter().min_by_key(oldest).map(|peer| peer.start);
            self.all.retain(|peer| Some(peer.start) != goes);
        }
        let peer = Peer { start, challenge: 0, seq: i64::MIN, heard_ns: now_ns, proven: None };
        self.all.push(peer);
        self.all.len() - 1
    }

    /// Whether the start proved that it runs now.
    #[must_use]
    pub fn knows(&self, start: i64, now_ns: i64) -> bool {
        self.all.iter().any(|peer| peer.start == start && peer.is_proven(now_ns))
    }

    /// Whether the message `seq` was sent after the start proved that it runs: what was recorded
    /// before that, also in an earlier time of trust, was not.
    #[must_use]
    pub fn believes(&self, (start, seq): (i64, i64), now_ns: i64) -> bool {
        let mut of = self.all.iter().filter(|peer| peer.start == start && peer.is_proven(now_ns));
        of.any(|peer| peer.proven.is_some_and(|(first, _)| seq > first))
    }

    /// Our greeting, without its header; the senders heard last are answered.
    #[must_use]
    pub fn hello(&self, now_ns: i64) -> Hello {
        let heard = |peer: &&Peer| now_ns.saturating_sub(peer.heard_ns) <= TRUST_NS;
        let heard: Vec<&Peer> = self.all.iter().filter(heard).collect();
        Hello {
            challenge: self.challenges[0],
            // At most MOST.
            n: i16::try_from(heard.len()).unwrap_or(i16::MAX),
            start: heard.iter().map(|peer| peer.start).collect(),
            answer: heard.iter().map(|peer| peer.challenge).collect(),
            ..Hello::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;

    fn pair() -> (Peers, Peers) {
        (Peers::new(1, [11, 12], 0), Peers::new(2, [21, 22], 0))
    }

    #[test]
    fn two_believe_each_other_after_three_greetings() {
        let (mut a, mut b) = pair();
        assert!(b.greet(&a.hello(0), (1, 0), 0) && !b.knows(1, 0));
        assert!(a.greet(&b.hello(0), (2, 0), 0) && a.knows(2, 0));
        assert!(!b.greet(&a.hello(0), (1, 1), 0) && b.knows(1, 0));
        assert!(!b.knows(3, 0));
        assert!(
            b.believes((1, 2), 0) && !b.believes((1, 1), 0),
            "only what comes after the answer"
        );
    }

    #[test]
    fn an_old_greeting_proves_nothing_once_the_challenge_has_changed_twice() {
        let (mut a, mut b) = pair();
        a.greet(&b.hello(0), (2, 0), 0);
        let recorded = a.hello(0);
        b.greet(&recorded, (1, 5), 0);
        assert!(b.knows(1, TRUST_NS) && !b.knows(1, TRUST_NS + 1));
        b.challenge(23, 2000 * MS);
        b.challenge(24, 4000 * MS);
        // The same bytes, and the same answer by a start that was forgotten meanwhile.
        assert!(!b.greet(&recorded, (1, 5), 4000 * MS));
        assert!(!b.knows(1, 4000 * MS));
        let mut later = Peers { all: Vec::new(), ..b.clone() };
        later.greet(&recorded, (1, 5), 4000 * MS);
        assert!(!later.knows(1, 4000 * MS));
    }

    #[test]
    fn a_crowd_of_replayed_starts_displaces_nobody_who_is_believed() {
        let (mut a, mut b) = pair();
        a.greet(&b.hello(0), (2, 0), 0);
        b.greet(&a.hello(0), (1, 0), 0);
        for start in 100..10_100 {
            b.greet(&Hello::default(), (start, 0), MS);
        }
        assert!(b.knows(1, MS));
        assert!((100..10_100).all(|start| !b.knows(start, MS)));
        assert!(b.all.len() <= MOST);
    }
}
