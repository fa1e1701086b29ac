//! Which operator commands are new, repeated or old. Pure.

use lcm_types::{BootId, Checked as _, MonoTime, OperatorAck, OperatorCommand, SeqNumber};

/// Operators remembered; the one silent longest makes room. \[-\]
const OPERATORS: usize = 16;
/// An order that is older on arrival, or waited longer, is not obeyed, but for an emergency
/// stop. \[ns\]
const MAX_AGE_NS: i64 = 1_000_000_000;

/// An accepted operator command.
#[derive(Debug, Clone, PartialEq)]
pub enum Heard {
    /// For the first time.
    New(OperatorCommand),
    /// Repeated: its sender did not receive this answer, or holds a dead man's switch.
    Again(OperatorCommand, OperatorAck),
}

#[derive(Debug, Clone)]
struct HeardOperator {
    boot_id: BootId,
    seq: SeqNumber,
    heard: MonoTime,
    answer: Option<OperatorAck>,
}

/// Orders of any number of operators, each start of `lmpc operator` being one. Commands are
/// idempotent: one that is repeated or out of order, or sent again after another operator's command, does
/// not take effect a second time.
#[derive(Debug, Clone)]
pub struct OperatorInbox {
    host: String,
    operators: Vec<HeardOperator>,
}

impl OperatorInbox {
    /// For a program on `host`.
    #[must_use]
    pub fn new(host: &str) -> Self {
        Self { host: host.to_owned(), operators: Vec::new() }
    }

    /// The operator command, if it is accepted. An emergency stop always is.
    pub fn hear(&mut self, bytes: &[u8], (arrival, now): (MonoTime, MonoTime)) -> Option<Heard> {
        let order = OperatorCommand::open(bytes).ok()?;
        let estop = order.command == OperatorCommand::ESTOP;
        let local = order.h.sender.rsplit('@').next() == Some(self.host.as_str());
        let since = if local { order.h.sent().min(arrival) } else { arrival };
        let stale = now.ns_since(since) > MAX_AGE_NS;
        let known = self.operators.iter_mut().find(|known| known.boot_id == order.h.sender_start());
        let answer = match known {
            Some(known) if order.h.number() <= known.seq || stale => {
                return estop.then_some(Heard::New(order));
            }
            Some(known) => {
                (known.seq, known.heard) = (order.h.number(), now);
                known.answer.clone().filter(|answer| answer.request_id == order.request_id)
            }
            None if stale => return estop.then_some(Heard::New(order)),
            None => {
                self.meet(&order, now);
                None
            }
        };
        Some(match answer {
            Some(answer) if !estop => Heard::Again(order, answer),
            _ => Heard::New(order),
        })
    }

    fn meet(&mut self, order: &OperatorCommand, heard: MonoTime) {
        if self.operators.len() >= OPERATORS {
            let oldest = self.operators.iter().enumerate().min_by_key(|(_, o)| o.heard);
            if let Some(oldest) = oldest.map(|(index, _)| index) {
                self.operators.swap_remove(oldest);
            }
        }
        let (boot_id, seq) = (order.h.sender_start(), order.h.number());
        self.operators.push(HeardOperator { boot_id, seq, heard, answer: None });
    }

    /// Keeps the answer to an order of the start `boot_id`.
    pub fn answered(&mut self, boot_id: BootId, answer: &OperatorAck) {
        let known = self.operators.iter_mut().find(|known| known.boot_id == boot_id);
        if let Some(known) = known {
            known.answer = Some(answer.clone());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lcm_types::Header;

    const MS: i64 = 1_000_000;

    struct Desk(OperatorInbox);

    impl Desk {
        fn say(&mut self, boot_id: i64, seq: i64, command: i8, request: i64) -> Option<Heard> {
            self.at(boot_id, seq, command, request, 0)
        }

        fn at(&mut self, boot: i64, seq: i64, command: i8, ask: i64, late: i64) -> Option<Heard> {
            let h =
                Header { boot_id: boot, seq, sender: "op@here".to_owned(), ..Header::default() };
            let order = OperatorCommand { h, command, request_id: ask, ..Default::default() };
            let mut bytes = Vec::new();
            order.seal_into(&mut bytes).unwrap();
            let heard = self.0.hear(&bytes, (MonoTime::from_ns(late), MonoTime::from_ns(late)));
            if let Some(Heard::New(order)) = &heard {
                let answer = OperatorAck { request_id: order.request_id, ..Default::default() };
                self.0.answered(order.h.sender_start(), &answer);
            }
            heard
        }
    }

    const START: i8 = OperatorCommand::START;
    const STOP: i8 = OperatorCommand::STOP;
    const ESTOP: i8 = OperatorCommand::ESTOP;

    fn is_new(heard: Option<&Heard>) -> bool {
        matches!(heard, Some(Heard::New(_)))
    }

    #[test]
    fn a_second_operator_is_obeyed_straight_after_the_first() {
        let mut desk = Desk(OperatorInbox::new("here"));
        assert!(is_new(desk.say(1, 0, START, 10).as_ref()));
        assert!(is_new(desk.say(2, 0, STOP, 20).as_ref()));
        // The first still repeats itself: that order is answered, not obeyed a second time.
        assert!(matches!(desk.say(1, 1, START, 10), Some(Heard::Again(..))));
        assert!(is_new(desk.say(1, 2, START, 11).as_ref()), "a new order of his");
    }

    #[test]
    fn what_is_repeated_swapped_or_late_is_not_obeyed_but_an_emergency_stop() {
        let mut desk = Desk(OperatorInbox::new("here"));
        assert!(is_new(desk.say(1, 5, START, 10).as_ref()));
        assert_eq!(desk.say(1, 5, START, 10), None);
        assert_eq!(desk.say(1, 4, START, 9), None);
        assert_eq!(desk.at(1, 6, START, 11, 1001 * MS), None, "its own stamp is old");
        assert_eq!(desk.at(3, 0, START, 12, 1001 * MS), None);
        for (boot, seq) in [(1, 5), (1, 4), (1, 9), (1, 10), (3, 0)] {
            assert!(is_new(desk.at(boot, seq, ESTOP, 13, 2000 * MS).as_ref()), "{boot} {seq}");
        }
    }

    #[test]
    fn many_operators_take_a_bounded_room() {
        let mut desk = Desk(OperatorInbox::new("here"));
        for boot in 0..1000 {
            assert!(is_new(desk.at(boot, 0, START, boot, boot).as_ref()));
        }
        assert_eq!(desk.0.operators.len(), OPERATORS);
        assert_eq!(desk.say(999, 0, START, 999), None, "the last ones are remembered");
        let mut damaged = vec![0; 80];
        damaged[0] = 1;
        assert_eq!(desk.0.hear(&damaged, Default::default()), None);
    }
}
