//! `lmpc completions` and `lmpc man`.

use std::fs;
use std::io::Write as _;

use anyhow::{Context as _, Result};
use clap::CommandFactory as _;

use super::Outcome;
use command_line::{Cli, CompletionsArgs, ManArgs};
use terminal::result;

/// Prints a completion script.
pub(super) fn completions(args: &CompletionsArgs) -> Result<Outcome> {
    // Into memory first: the generator panics if its output is closed.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "lmpc", &mut script);
    std::io::stdout().write_all(&script)?;
    Ok(Outcome::Done)
}

/// Writes a page for each command.
pub(super) fn man(args: &ManArgs) -> Result<Outcome> {
    let folder = &args.folder;
    fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    clap_mangen::generate_to(Cli::command(), folder)
        .with_context(|| format!("cannot write to {}", folder.display()))?;
    result(&format!("manual pages: {}", folder.join("lmpc.1").display()))?;
    Ok(Outcome::Done)
}
