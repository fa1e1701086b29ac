//! The operator of a run: arms, starts, holds the dead man's switch, gives the faults' orders.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use lcm_types::{Heartbeat, OperatorAck, OperatorCommand, channels};

use super::fault::BenchOrder;
use protocol::publisher::{Identity, Publisher};
use transport::Transport;

const ARM_REPEAT: Duration = Duration::from_millis(100);
/// Times an emergency stop is said in each round. \[-\]
const ESTOP_TIMES: u32 = 3;

/// What the operator does in this round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Duty {
    /// Arms and starts, if the car does not drive yet.
    Drive,
    /// The order of the fault with this place in the scenario and its value, until it is answered.
    Give(usize, BenchOrder, f64),
    /// Nothing more than the switch.
    Watch,
}

/// The dead man's switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Switch {
    /// There is none, or its holder is silent.
    Silent,
    /// Held.
    Held,
    /// Let go.
    Released,
}

/// The operator.
pub(super) struct BenchOperator {
    publisher: Publisher,
    /// The grant in force, as last heard. \[-\]
    pub(super) token: i64,
    /// Whether the car side says that it drives.
    pub(super) running: bool,
    next: Instant,
    request: i64,
    /// The fault whose order waits for its answer, and the order's number.
    given: Option<(usize, i64)>,
    answered: i64,
    /// Faults whose order was sent.
    sent: Arc<Mutex<BTreeSet<usize>>>,
}

impl BenchOperator {
    pub(super) fn new(network: &Arc<dyn Transport>) -> Self {
        Self {
            publisher: Publisher::new(network, &Identity::new("operator"), channels::OPERATOR),
            token: 0,
            running: false,
            next: Instant::now(),
            request: 0,
            given: None,
            answered: 0,
            sent: Arc::default(),
        }
    }

    /// Faults whose order was sent, by their place in the scenario.
    pub(super) fn sent(&self) -> Arc<Mutex<BTreeSet<usize>>> {
        Arc::clone(&self.sent)
    }

    /// The bridge answered.
    pub(super) fn answer(&mut self, ack: &OperatorAck) {
        self.answered = self.answered.max(ack.request_id);
    }

    /// The bridge said its grant and its state.
    pub(super) fn grant(&mut self, token: i64, state: i8) {
        (self.token, self.running) = (token, state == Heartbeat::RUNNING);
    }

    /// One round, every 10 ms.
    pub(super) fn round(&mut self, duty: Duty, switch: Switch) {
        match duty {
            Duty::Drive if !self.running && Instant::now() >= self.next => {
                self.next = Instant::now() + ARM_REPEAT;
                let arm = self.token == 0;
                let command = if arm { OperatorCommand::ARM } else { OperatorCommand::START };
                self.request += 1;
                self.say(self.request, command, 0.0, !arm && switch == Switch::Held);
            }
            Duty::Give(fault, order, value) => self.give(fault, order, value),
            Duty::Drive | Duty::Watch => {}
        }
        if self.running && switch != Switch::Silent {
            self.request += 1;
            self.say(self.request, OperatorCommand::START, 0.0, switch == Switch::Held);
        }
    }

    fn give(&mut self, fault: usize, order: BenchOrder, value: f64) {
        let number = match self.given {
            Some((given, number)) if given == fault => number,
            _ => {
                self.request += 1;
                self.given = Some((fault, self.request));
                self.sent.lock().unwrap_or_else(PoisonError::into_inner).insert(fault);
                self.request
            }
        };
        // A START that is refused is given again: it must stay refused.
        if self.answered >= number && order != BenchOrder::Start {
            return;
        }
        let (command, times) = match order {
            BenchOrder::Estop => (OperatorCommand::ESTOP, ESTOP_TIMES),
            BenchOrder::Stop => (OperatorCommand::STOP, 1),
            BenchOrder::Start => (OperatorCommand::START, 1),
            BenchOrder::SpeedCap => (OperatorCommand::SET_SPEED_CAP, 1),
        };
        for _ in 0..times {
            self.say(number, command, value, false);
        }
        if order == BenchOrder::Start {
            self.given = None;
        }
    }

    fn say(&mut self, request_id: i64, command: i8, value: f64, deadman: bool) {
        let message = OperatorCommand {
            h: self.publisher.header(),
            command,
            request_id,
            value,
            arm_token: self.token,
            deadman,
            reason: "bench".to_owned(),
            ..OperatorCommand::default()
        };
        // What the network refuses is lost, as anything may be.
        let _ = self.publisher.send_sealed(&message);
    }
}
