//! An operator command: repeated until every receiver has answered, or as long as a dead man's
//! switch is held.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use lcm_types::{
    ArmToken, BootId, Heartbeat, Message as _, OperatorAck, OperatorCommand, channels,
};

use protocol::publisher::{Identity, Publisher, random};
use transport::{Filter, Inbox, Transport};

/// Time between two tellings.
const REPEAT: Duration = Duration::from_millis(10);
/// Tellings of an emergency stop each time. \[-\]
const ESTOP_TIMES: u32 = 3;
/// In this time every program on the network sends a heartbeat: three periods.
const LOOK: Duration = Duration::from_millis(300);
/// Nobody is waited for any longer.
const PATIENCE: Duration = Duration::from_secs(3);

/// An answer.
#[derive(Debug, Clone, PartialEq)]
pub struct OperatorAnswer {
    /// `bridge` or `lmpc`.
    pub who: String,
    /// The answer.
    pub ack: OperatorAck,
}

/// How a dead man's switch came to its end.
#[derive(Debug, Clone, PartialEq)]
pub enum Held {
    /// The START was refused by somebody.
    Refused(Vec<OperatorAnswer>),
    /// It was let go, and these answered the STOP.
    Released(Vec<OperatorAnswer>),
    /// The bridge stopped by itself, and says so.
    Ended(OperatorAnswer),
}

/// An operator at the network: one start of a program.
pub struct Operator {
    inbox: Inbox,
    publisher: Publisher,
    bridge_channel: String,
    service_channel: String,
    /// The arm token the bridge reports.
    bridge: Option<ArmToken>,
    /// Boot id and sender of each bridge heard.
    bridges: Vec<(BootId, String)>,
    service: bool,
    begun: Instant,
}

impl Operator {
    /// Begins to listen.
    ///
    /// # Errors
    /// If the network refuses the subscription.
    pub fn new(network: &Arc<dyn Transport>) -> Result<Self> {
        let inbox = Inbox::queue(256);
        let life = |name: &str| format!("{}{name}", channels::HEARTBEAT);
        let (bridge_channel, service_channel) = (life("bridge"), life("lmpc"));
        let names =
            [channels::OPERATOR_ACK, &bridge_channel, &service_channel].map(str::to_owned).to_vec();
        network.subscribe(Filter::Only(names), inbox.sink())?;
        let publisher = Publisher::new(network, &Identity::new("operator"), channels::OPERATOR);
        let begun = Instant::now();
        let (bridge, bridges, service) = (None, Vec::new(), false);
        Ok(Self {
            inbox,
            publisher,
            bridge_channel,
            service_channel,
            bridge,
            bridges,
            service,
            begun,
        })
    }

    /// Forgets which programs are on the network, as at the start: for one that gives several orders.
    pub fn forget(&mut self) {
        while self.inbox.take().is_some() {}
        (self.bridge, self.service) = (None, false);
        self.bridges.clear();
        self.begun = Instant::now();
    }

    /// Says an order once.
    fn publish(&mut self, order: &mut OperatorCommand) -> Result<()> {
        order.h = self.publisher.header();
        self.publisher.send_sealed(order)
    }

    /// The answers to an order that come until `deadline`.
    fn listen(
        &mut self,
        deadline: Instant,
        request_id: i64,
        heard: &mut dyn FnMut(OperatorAnswer),
    ) {
        while let Some(received) = self.inbox.wait_until(deadline) {
            if received.channel == self.bridge_channel {
                if let Ok(beat) = Heartbeat::decode(&received.payload) {
                    self.bridge = Some(ArmToken::new(beat.arm_token));
                    if self.bridges.iter().all(|(boot_id, _)| *boot_id != beat.h.sender_start()) {
                        self.bridges.push((beat.h.sender_start(), beat.h.sender));
                    }
                }
            } else if received.channel == self.service_channel {
                self.service = true;
            } else if let Ok(ack) = OperatorAck::decode(&received.payload) {
                let who = ack.h.sender.split('@').next().unwrap_or_default().to_owned();
                if ack.request_id == request_id {
                    heard(OperatorAnswer { who, ack });
                }
            }
        }
    }

    /// Gives an order and waits for its answers. START without a token takes the one the bridge
    /// says.
    ///
    /// # Errors
    /// If there is no answer, the network refuses it, or ARM or START would reach two bridges.
    pub fn give(&mut self, order: &mut OperatorCommand) -> Result<Vec<OperatorAnswer>> {
        order.request_id = random();
        if matches!(order.command, OperatorCommand::ARM | OperatorCommand::START) {
            self.listen(self.begun + LOOK, 0, &mut |_| {});
            if let [(one, first), (two, second), ..] = &self.bridges[..] {
                bail!(
                    "two bridges are on this network, {first} (boot id {one}) and {second} (boot \
                     id {two}): end one, or give each a network of its own"
                );
            }
        }
        let begun = Instant::now();
        let estop = order.command == OperatorCommand::ESTOP;
        let for_bridge = matches!(order.command, OperatorCommand::ARM | OperatorCommand::DISARM);
        let needs_token = order.command == OperatorCommand::START && order.arm_token == 0;
        let mut next = begun;
        let mut acks: Vec<OperatorAnswer> = Vec::new();
        while begun.elapsed() < PATIENCE {
            let looked = self.begun.elapsed() > LOOK;
            if needs_token && let Some(token) = self.bridge {
                order.arm_token = token.get();
            }
            if !needs_token || self.bridge.is_some() || looked {
                for _ in 0..if estop { ESTOP_TIMES } else { 1 } {
                    self.publish(order)?;
                }
            }
            next += REPEAT;
            self.listen(next, order.request_id, &mut |answer| {
                if acks.iter().all(|known| known.who != answer.who) {
                    acks.push(answer);
                }
            });
            let answered = |who: &str| acks.iter().any(|answer| answer.who == who);
            let served = for_bridge || !self.service || answered("lmpc");
            let bridged = self.bridge.is_none() || answered("bridge");
            if !acks.is_empty() && served && bridged && looked {
                break;
            }
            // A refusal is final, and an emergency stop that the bridge heard has happened.
            let settled = |a: &OperatorAnswer| a.who == "bridge" && (estop || !a.ack.accepted);
            if acks.iter().any(settled) {
                break;
            }
        }
        if acks.is_empty() {
            bail!(
                "no answer within {} s: is `lmpc bridge` or `lmpc serve` running on this \
                 network?",
                PATIENCE.as_secs()
            );
        }
        Ok(acks)
    }

    /// START with the dead man's switch held until `release` is set, then STOP; `begun` is called with who
    /// obeys. When this program dies, the bridge receives nothing more and stops the car.
    ///
    /// # Errors
    /// If there is no bridge, no answer, or the network refuses it.
    pub fn hold(
        &mut self,
        mut start: OperatorCommand,
        release: &AtomicBool,
        begun: &mut dyn FnMut(&[OperatorAnswer]) -> Result<()>,
    ) -> Result<Held> {
        self.listen(self.begun + LOOK, 0, &mut |_| {});
        if self.bridge.is_none() {
            bail!("no bridge on this network: the dead man's switch would have no effect");
        }
        start.deadman = true;
        let answers = self.give(&mut start)?;
        if answers.iter().any(|answer| !answer.ack.accepted) {
            return Ok(Held::Refused(answers));
        }
        begun(&answers)?;
        let mut next = Instant::now();
        while !release.load(Ordering::Relaxed) {
            self.publish(&mut start)?;
            next += REPEAT;
            let mut ended = None;
            self.listen(next, start.request_id, &mut |answer| {
                if answer.who == "bridge" && !answer.ack.accepted {
                    ended = Some(answer);
                }
            });
            if let Some(ended) = ended {
                return Ok(Held::Ended(ended));
            }
        }
        Ok(Held::Released(self.stop(&start)?))
    }

    fn stop(&mut self, start: &OperatorCommand) -> Result<Vec<OperatorAnswer>> {
        let command = OperatorCommand::STOP;
        let reason = "dead man's switch released".to_owned();
        let arm_token = start.arm_token;
        self.give(&mut OperatorCommand { command, arm_token, reason, ..Default::default() })
    }
}
