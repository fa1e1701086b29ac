//! `lmpc export`.

use anyhow::{Result, bail};

use super::Outcome;
use command_line::ExportArgs;
use log_export::{Account, Types, csv, mcap};
use terminal::{Talk, WARN, paint, result};

/// Writes a log for other tools.
pub(super) fn run(args: &ExportArgs, talk: Talk) -> Result<Outcome> {
    let types = Types::load(&args.types)?;
    let mut account = Account::default();
    if let Some(folder) = &args.csv {
        account = csv::write(&args.log, &types, &args.channels, folder)?;
    }
    if let Some(file) = &args.mcap {
        account = mcap::write(&args.log, &types, &args.channels, file)?;
    }
    for channel in &args.channels {
        let heard = account.streams.keys().any(|stream| stream.channel == *channel)
            || account.unknown.contains_key(channel)
            || account.unreadable.contains_key(channel);
        if !heard {
            bail!("{}: nothing on the channel {channel}", args.log.display());
        }
    }
    if args.json {
        terminal::json(&account)?;
    } else {
        tell(&account)?;
    }
    for (channel, count) in &account.unknown {
        talk.say(&format!("{channel}: {count} messages of an unknown type (--types)"));
    }
    if account.damaged_bytes > 0 {
        let (bytes, places) = (account.damaged_bytes, account.damaged_places);
        let text = format!("warning: {bytes} bytes skipped at {places} damaged places of the log");
        talk.say(&paint(WARN, &text));
    }
    for (channel, count) in &account.unreadable {
        let text = format!("warning: {channel}: {count} messages do not decode");
        talk.say(&paint(WARN, &text));
    }
    Ok(if account.is_damaged() { Outcome::Degraded } else { Outcome::Done })
}

fn tell(account: &Account) -> Result<()> {
    for (stream, messages) in &account.streams {
        result(&format!("{messages:8}  {}  {}", stream.channel, stream.type_name))?;
    }
    Ok(())
}
