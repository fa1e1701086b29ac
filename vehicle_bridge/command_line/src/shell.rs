//! Options of `lmpc completions` and `lmpc man`.

use std::path::PathBuf;

use clap::Args;

const COMPLETIONS: &str = "\
Examples:
  lmpc completions bash > /etc/bash_completion.d/lmpc
  lmpc completions zsh > /usr/local/share/zsh/site-functions/_lmpc
  lmpc completions fish > ~/.config/fish/completions/lmpc.fish";

const MAN: &str = "\
Examples:
  lmpc man /usr/local/share/man/man1      then `man lmpc`, `man lmpc-race`
  lmpc man out/man && man out/man/lmpc-study-tracks.1";

/// Options of `lmpc completions`.
#[derive(Debug, Args)]
#[command(after_help = COMPLETIONS)]
pub struct CompletionsArgs {
    /// Shell
    pub shell: clap_complete::Shell,
}

/// Options of `lmpc man`.
#[derive(Debug, Args)]
#[command(after_help = MAN)]
pub struct ManArgs {
    /// Folder for lmpc.1 and a page for each command; made if it is not there
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}
