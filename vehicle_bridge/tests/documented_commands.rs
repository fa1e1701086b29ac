//! Every command in the documents is one that the program takes: those in blocks are parsed whole,
//! of those within sentences each option has to exist.
#![allow(clippy::unwrap_used, reason = "code of tests")]

use std::path::{Path, PathBuf};

use clap::{Command, CommandFactory as _, Parser as _};
use command_line::Cli;

fn documents(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            documents(&path, found);
        } else if path.extension().is_some_and(|end| end == "md") {
            found.push(path);
        }
    }
}

/// README, the book and the examples, with their names in the tree.
fn texts() -> Vec<(String, String)> {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut found = vec![top.join("README.md")];
    for folder in ["docs", "examples", "python"] {
        documents(&top.join(folder), &mut found);
    }
    let text = |path: PathBuf| {
        let name = path.strip_prefix(&top).unwrap().display().to_string();
        (name, std::fs::read_to_string(path).unwrap())
    };
    found.into_iter().map(text).collect()
}

/// The words of a line as a shell takes them, up to what is not the command's any more.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), None::<String>, None);
    for c in line.chars() {
        match (quote, c) {
            (Some(end), _) if c == end => quote = None,
            (None, '\'' | '"') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, '|' | '>' | '<' | '&' | ';') => break,
            (None, '#') if word.is_none() => break,
            (None, ' ' | '\t') => words.extend(word.take()),
            _ => word.get_or_insert_default().push(c),
        }
    }
    words.extend(word);
    words
}

/// Commands of the program in the blocks of a document.
fn blocks(text: &str) -> Vec<String> {
    let parts = text.split("\\\n").enumerate();
    let joined: String = parts.map(|(i, p)| if i > 0 { p.trim_start() } else { p }).collect();
    let (mut inside, mut found) = (false, Vec::new());
    for line in joined.lines() {
        if line.trim_start().starts_with("```") {
            inside = !inside;
        } else if inside {
            let line = line.trim_start().trim_start_matches("$ ");
            let line = line.strip_prefix("target/release/").unwrap_or(line);
            // Help explains behind two spaces.
            let line = line.split("  ").next().unwrap_or(line);
            let syntax = line.contains(" <COMMAND>");
            found.extend((line.starts_with("lmpc ") && !syntax).then(|| line.to_owned()));
        }
    }
    found
}

/// Commands of the program within sentences.
fn spans(text: &str) -> Vec<String> {
    let mut prose = String::new();
    let mut inside = false;
    for line in text.lines() {
        let fence = line.trim_start().starts_with("```");
        inside ^= fence;
        if !inside && !fence {
            prose.push_str(line);
            prose.push(' ');
        }
    }
    let spans = prose.split('`').skip(1).step_by(2);
    spans.filter(|span| span.starts_with("lmpc ")).map(str::to_owned).collect()
}

/// What of a command within a sentence does not exist.
fn unknown(command: &Command, span: &str) -> Option<String> {
    let words = words(span);
    let mut commands = vec![command];
    for word in words.iter().skip(1).take_while(|word| !word.starts_with('-')) {
        let last = commands.last()?;
        let Some(next) = last.find_subcommand(word) else {
            let takes_words = last.get_positionals().next().is_some();
            return (!takes_words && last.has_subcommands()).then(|| word.clone());
        };
        commands.push(next);
    }
    let known = |option: &str| {
        let of = |c: &&Command| {
            let mut options = c.get_arguments();
            options.any(|a| a.get_long() == Some(option))
        };
        matches!(option, "help" | "version") || commands.iter().any(of)
    };
    let options = words.iter().filter_map(|word| word.strip_prefix("--"));
    let names = options.map(|option| option.split('=').next().unwrap_or(option));
    names.filter(|name| !name.is_empty()).find(|name| !known(name)).map(|name| format!("--{name}"))
}

#[test]
fn the_program_takes_every_command_of_the_documents() {
    let mut command = Cli::command();
    command.build();
    let (mut wrong, mut parsed, mut mentioned) = (Vec::new(), 0, 0);
    for (name, text) in texts() {
        for line in blocks(&text) {
            parsed += 1;
            if let Err(error) = Cli::try_parse_from(words(&line))
                && error.use_stderr()
            {
                wrong.push(format!("{name}: {line}\n{error}"));
            }
        }
        for span in spans(&text) {
            mentioned += 1;
            let what = unknown(&command, &span);
            wrong.extend(what.map(|what| format!("{name}: `{span}`: there is no {what}")));
        }
    }
    assert!(parsed > 100 && mentioned > 100, "{parsed} and {mentioned} commands found");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_command_that_does_not_exist_is_found() {
    let mut command = Cli::command();
    command.build();
    assert_eq!(unknown(&command, "lmpc race --seed 0 --laps=5"), None);
    assert_eq!(unknown(&command, "lmpc rice --seed 0").as_deref(), Some("rice"));
    assert_eq!(unknown(&command, "lmpc race --sead 0").as_deref(), Some("--sead"));
    assert_eq!(
        blocks("```sh\nlmpc race \\\n  --seed 0 | head\n```\nlmpc x"),
        ["lmpc race --seed 0 | head"]
    );
    assert_eq!(words("lmpc race --set 'a=1 2' | head # x"), ["lmpc", "race", "--set", "a=1 2"]);
}
