//! Orders that a person gives on the page of `lmpc view --operator`.

use std::sync::{Arc, Mutex, PoisonError};

use anyhow::Result;
use lcm_types::OperatorCommand;

use live_view::{OrderRequest, Orders};
use protocol::publisher::random;
use safety::BridgeState;
use services::operator_client::{Operator, OperatorAnswer};
use transport::Transport;

/// Carries orders to a network. An emergency stop does not wait for another order's answer.
pub(super) fn orders(network: &Arc<dyn Transport>) -> Result<Orders> {
    let (usual, urgent) =
        (Mutex::new(Operator::new(network)?), Mutex::new(Operator::new(network)?));
    Ok(Orders {
        token: format!("{:016x}{:016x}", random(), random()),
        give: Box::new(move |order| {
            let mut command = command(order)?;
            let stops = matches!(order.order.as_str(), "stop" | "estop");
            let operator = if stops { &urgent } else { &usual };
            let mut operator = operator.lock().unwrap_or_else(PoisonError::into_inner);
            operator.forget();
            let answers = operator.give(&mut command).map_err(|error| format!("{error:#}"))?;
            account(&answers)
        }),
    })
}

fn command(order: &OrderRequest) -> Result<OperatorCommand, String> {
    let (command, value) = match order.order.as_str() {
        "arm" => (OperatorCommand::ARM, 0.0),
        "disarm" => (OperatorCommand::DISARM, 0.0),
        "start" => (OperatorCommand::START, 0.0),
        "stop" => (OperatorCommand::STOP, 0.0),
        "estop" => (OperatorCommand::ESTOP, 0.0),
        "reset" => (OperatorCommand::ESTOP_RESET, 0.0),
        "speed-cap" => (OperatorCommand::SET_SPEED_CAP, order.value),
        other => return Err(format!("unknown order: {other}")),
    };
    Ok(OperatorCommand {
        command,
        value,
        reason: "from the page of lmpc view".to_owned(),
        ..OperatorCommand::default()
    })
}

/// Who answered what; an error if one of them refused.
fn account(answers: &[OperatorAnswer]) -> Result<String, String> {
    let line = |answer: &OperatorAnswer| {
        let state = BridgeState::name_of(answer.ack.state);
        match (answer.ack.accepted, &answer.ack.detail) {
            (true, _) => format!("{}: {state}", answer.who),
            (false, why) => format!("{} refuses in state {state}: {why}", answer.who),
        }
    };
    let text = answers.iter().map(line).collect::<Vec<_>>().join("; ");
    if answers.iter().all(|answer| answer.ack.accepted) { Ok(text) } else { Err(text) }
}
