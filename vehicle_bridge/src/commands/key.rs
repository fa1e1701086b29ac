//! `lmpc key`.

use anyhow::Result;

use super::Outcome;
use auth::Key;
use command_line::{KeyAction, KeyArgs};
use terminal::{Talk, result};

/// Makes a key, or prints which one a file holds.
pub(super) fn run(args: &KeyArgs, talk: Talk) -> Result<Outcome> {
    match &args.action {
        KeyAction::New { file } => {
            let key = Key::create(file)?;
            talk.say(&format!(
                "{}: a new key, {}; whoever has a copy can command the car",
                file.display(),
                key.id()
            ));
        }
        KeyAction::Id { file } => result(Key::load(file)?.id())?,
    }
    Ok(Outcome::Done)
}
