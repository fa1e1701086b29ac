//! An operator's order: said until everybody it concerns has answered.

use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use lcm_types::{Heartbeat, Message as _, OperatorAck, OperatorCommand, channels};

use super::outlet::{Identity, Outlet, random};
use crate::transport::{Filter, Inbox, Transport};

/// Time between two tellings.
const REPEAT: Duration = Duration::from_millis(10);
/// Tellings of an emergency stop each time. \[-\]
const ESTOP_TIMES: u32 = 3;
/// In this time everybody on the network was heard: three life signs.
const LOOK: Duration = Duration::from_millis(300);
/// Nobody is waited for any longer.
const PATIENCE: Duration = Duration::from_secs(3);

/// An answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Answered {
    /// `bridge` or `lmpc`.
    pub who: String,
    /// The answer.
    pub ack: OperatorAck,
}

/// What was heard so far.
#[derive(Default)]
struct Heard {
    bridge: Option<i64>,
    service: bool,
    acks: Vec<Answered>,
}

impl Heard {
    fn answered(&self, who: &str) -> bool {
        self.acks.iter().any(|answer| answer.who == who)
    }
}

/// Gives an order and waits for its answers. START without a token takes the one the bridge says.
///
/// # Errors
/// If nobody answers, or the network refuses it.
pub fn give(network: &Arc<dyn Transport>, mut order: OperatorCommand) -> Result<Vec<Answered>> {
    let inbox = Inbox::queue(256);
    let (bridge, service) =
        (format!("{}bridge", channels::HEARTBEAT), format!("{}lmpc", channels::HEARTBEAT));
    let names = vec![channels::OPERATOR_ACK.to_owned(), bridge.clone(), service.clone()];
    network.subscribe(Filter::Only(names), inbox.sink())?;
    let mut outlet = Outlet::new(network, &Identity::new("operator"), channels::OPERATOR);
    order.request_id = random();
    let begun = Instant::now();
    let mut heard = Heard::default();
    let estop = order.command == OperatorCommand::ESTOP;
    let for_bridge = matches!(order.command, OperatorCommand::ARM | OperatorCommand::DISARM);
    let needs_token = order.command == OperatorCommand::START && order.arm_token == 0;
    let mut next = begun;
    while begun.elapsed() < PATIENCE {
        if needs_token && let Some(token) = heard.bridge {
            order.arm_token = token;
        }
        if !needs_token || heard.bridge.is_some() || begun.elapsed() > LOOK {
            for _ in 0..if estop { ESTOP_TIMES } else { 1 } {
                order.h = outlet.header();
                outlet.send_sealed(&order)?;
            }
        }
        next += REPEAT;
        while let Some(received) = inbox.wait_until(next) {
            if received.channel == bridge {
                if let Ok(beat) = Heartbeat::decode(&received.payload) {
                    heard.bridge = Some(beat.arm_token);
                }
            } else if received.channel == service {
                heard.service = true;
            } else if let Ok(ack) = OperatorAck::decode(&received.payload) {
                let who = ack.h.sender.split('@').next().unwrap_or_default().to_owned();
                if ack.request_id == order.request_id && !heard.answered(&who) {
                    heard.acks.push(Answered { who, ack });
                }
            }
        }
        let served = for_bridge || !heard.service || heard.answered("lmpc");
        let bridged = heard.bridge.is_none() || heard.answered("bridge");
        if !heard.acks.is_empty() && served && bridged && begun.elapsed() > LOOK {
            break;
        }
        // A refusal is final, and an emergency stop that the bridge heard has happened.
        let settled = |a: &Answered| a.who == "bridge" && (estop || !a.ack.accepted);
        if heard.acks.iter().any(settled) {
            break;
        }
    }
    if heard.acks.is_empty() {
        bail!(
            "nobody answered within {} s: is `lmpc bridge` or `lmpc serve` running on this network?",
            PATIENCE.as_secs()
        );
    }
    Ok(heard.acks)
}
