//! `docs/reference/cli.md` is the help of every command. `LMPC_WRITE_DOCS=1 cargo test -p
//! vehicle_bridge --test commands_page` writes it anew.
#![allow(clippy::unwrap_used, reason = "code of tests")]

use std::fmt::Write as _;
use std::path::Path;

use clap::{Command, CommandFactory as _};
use command_line::Cli;

const TOP: &str = "# Commands

Generated from the command line's own help.
";

fn section(command: &Command, name: &str, text: &mut String) {
    let help = command.clone().term_width(96).render_long_help().to_string();
    let help: String = help.lines().map(|line| format!("{}\n", line.trim_end())).collect();
    writeln!(text, "\n## `{name}`\n\n```text\n{}\n```", help.trim_end()).unwrap();
    for inner in command.get_subcommands().filter(|c| !c.is_hide_set() && c.get_name() != "help") {
        section(inner, &format!("{name} {}", inner.get_name()), text);
    }
}

#[test]
fn the_page_is_up_to_date() {
    let mut command = Cli::command();
    command.build();
    let mut expected = TOP.to_owned();
    section(&command, "lmpc", &mut expected);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/reference/cli.md");
    if std::env::var_os("LMPC_WRITE_DOCS").is_some() {
        std::fs::write(&path, &expected).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == expected, "the page is old: LMPC_WRITE_DOCS=1 writes it anew");
}
