//! The operator of a run: arms, starts, holds the dead man's switch, gives the faults' orders.

use std::sync::Arc;
use std::time::{Duration, Instant};

use lcm_types::{Heartbeat, OperatorAck, OperatorCommand, channels};

use super::fault::Order;
use protocol::publisher::{Identity, Publisher};
use transport::Transport;

const ARM_REPEAT: Duration = Duration::from_millis(100);
/// Times an emergency stop is said in each round. \[-\]
const ESTOP_TIMES: u32 = 3;

/// What the operator does in this round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Duty {
    /// Arms and starts, if the car does not drive yet.
    Drive,
    /// An order, until it is answered.
    Give(Order),
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
pub(super) struct Operator {
    publisher: Publisher,
    /// The grant in force, as last heard. \[-\]
    pub(super) token: i64,
    /// Whether the car side says that it drives.
    pub(super) running: bool,
    next: Instant,
    request: i64,
    /// The order that waits for its answer, and its number.
    given: Option<(Order, i64)>,
    answered: i64,
}

impl Operator {
    pub(super) fn new(network: &Arc<dyn Transport>) -> Self {
        Self {
            publisher: Publisher::new(network, &Identity::new("operator"), channels::OPERATOR),
            token: 0,
            running: false,
            next: Instant::now(),
            request: 0,
            given: None,
            answered: 0,
        }
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
                self.say(self.request, command, !arm && switch == Switch::Held);
            }
            Duty::Give(order) => self.give(order),
            Duty::Drive | Duty::Watch => {}
        }
        if self.running && switch != Switch::Silent {
            self.request += 1;
            self.say(self.request, OperatorCommand::START, switch == Switch::Held);
        }
    }

    fn give(&mut self, order: Order) {
        let number = match self.given {
            Some((given, number)) if given == order => number,
            _ => {
                self.request += 1;
                self.given = Some((order, self.request));
                self.request
            }
        };
        // A START that is refused is given again: it must stay refused.
        if self.answered >= number && order != Order::Start {
            return;
        }
        let (command, times) = match order {
            Order::Estop => (OperatorCommand::ESTOP, ESTOP_TIMES),
            Order::Stop => (OperatorCommand::STOP, 1),
            Order::Start => (OperatorCommand::START, 1),
        };
        for _ in 0..times {
            self.say(number, command, false);
        }
        if order == Order::Start {
            self.given = None;
        }
    }

    fn say(&mut self, request_id: i64, command: i8, deadman: bool) {
        let message = OperatorCommand {
            h: self.publisher.header(),
            command,
            request_id,
            arm_token: self.token,
            deadman,
            reason: "bench".to_owned(),
            ..OperatorCommand::default()
        };
        // What the network refuses is lost, as anything may be.
        let _ = self.publisher.send_sealed(&message);
    }
}
