//! What users and their programs read, compared with files in `tests/golden`: headers of tables,
//! reports, verdicts, manual pages. The help of every command is `docs/reference/cli.md`.
//! `make generated` writes the files anew; the difference then shows in the commit.
#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

#[path = "common/command.rs"]
mod command;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use clap::CommandFactory as _;
use command::lmpc;
use command_line::Cli;

/// Runs a command that writes into a folder of its own.
fn written(arguments: &[&str], codes: &[i32]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().display().to_string();
    let output = lmpc(&[arguments, &["--out", &out]].concat());
    assert!(codes.contains(&output.status.code().unwrap()), "{arguments:?}: {output:?}");
    folder
}

fn compare(name: &str, found: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    if std::env::var_os("LMPC_WRITE_DOCS").is_some() {
        fs::write(&path, found).unwrap();
    }
    let expected = fs::read_to_string(&path).unwrap_or_default();
    for (line, (found, expected)) in found.lines().zip(expected.lines()).enumerate() {
        let line = line + 1;
        assert_eq!(found, expected, "{name}, line {line}; `make generated` writes it anew");
    }
    assert!(found == expected, "{name} has another length; `make generated` writes it anew");
}

/// The words of a page: without markup and styles, each number as `#`, repeated lines once.
fn words(page: &str) -> String {
    let (mut text, mut rest) = (String::new(), page);
    while let Some(start) = rest.find('<') {
        text.push_str(&rest[..start]);
        text.push('\n');
        rest = &rest[start..];
        let hidden = ["style", "script"].into_iter().find(|tag| rest[1..].starts_with(tag));
        let end = hidden.map_or(">".to_owned(), |tag| format!("</{tag}>"));
        rest = rest.split_once(&end).map_or("", |(_, after)| after);
    }
    text.push_str(rest);
    let mut lines: Vec<String> = Vec::new();
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let mut plain = String::new();
        let mut characters = line.chars().peekable();
        while let Some(c) = characters.next() {
            let signed = "-+\u{2212}".contains(c)
                && characters.peek().is_some_and(char::is_ascii_digit)
                && !plain.ends_with(char::is_alphanumeric);
            if c.is_ascii_digit() || signed {
                let number = |c: &char| c.is_ascii_digit() || *c == '.';
                while characters.next_if(number).is_some() {}
                plain.push('#');
            } else {
                plain.push(c);
            }
        }
        if lines.last() != Some(&plain) {
            lines.push(plain);
        }
    }
    lines.join("\n") + "\n"
}

fn tables(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut tables: Vec<_> =
        entries.filter(|p| p.extension().is_some_and(|e| e == "csv")).collect();
    tables.sort();
    tables
}

#[test]
fn tables_have_the_columns_that_programs_read() {
    let mut text = String::new();
    let size = ["--seeds", "1", "--laps", "1"];
    for (command, more) in [
        (vec!["race"], vec!["--laps", "1"]),
        (vec!["study", "hardware"], size.to_vec()),
        (vec!["study", "tracks"], size.to_vec()),
    ] {
        let arguments = match command[..] {
            ["study", "tracks"] => [&command[..], &["--track", "l"], &more].concat(),
            _ => [&command[..], &more].concat(),
        };
        let folder = written(&arguments, &[0]);
        for table in tables(folder.path()) {
            let name = table.file_name().unwrap().to_string_lossy().into_owned();
            let content = fs::read_to_string(&table).unwrap();
            text += &format!("lmpc {} {name}\n", command.join(" "));
            let header = content.lines().find(|line| !line.is_empty()).unwrap_or_default();
            for column in header.split(',') {
                text += &format!("  {column}\n");
            }
        }
    }
    compare("csv_headers.txt", &text);
}

#[test]
fn the_report_of_a_race_says_what_it_said() {
    let store = tempfile::tempdir().unwrap();
    let store = store.path().display().to_string();
    let folder = written(&["race", "--laps", "2", "--store", &store], &[0]);
    compare("report.txt", &words(&fs::read_to_string(folder.path().join("report.html")).unwrap()));
}

/// Replaces what stands between the two texts, wherever they do.
fn masked(text: &mut String, before: &str, after: &str) {
    assert!(text.contains(before), "{before}");
    let parts: Vec<String> = text.split(before).map(str::to_owned).collect();
    let rest = |part: &String| format!("#{}", &part[part.find(after).unwrap()..]);
    let rest: Vec<String> = parts.iter().skip(1).map(rest).collect();
    *text = [vec![parts[0].clone()], rest].concat().join(before);
}

#[test]
fn the_verdict_of_a_bench_says_what_it_said() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../bench/host.toml");
    let shipped = fs::read_to_string(shipped).unwrap();
    let head = &shipped[..shipped.find("[[process]]").unwrap()];
    let scenario = |name: &str, most: u32| {
        format!(
            "[[scenario]]\nname = '{name}'\nexpected = 'what should happen'\n\
             program = [\"sh\", \"-c\", \"echo lost 2\"]\n\
             [[scenario.expect]]\nmeasure = \"lost\"\nmost = {most}\n"
        )
    };
    let bench = [head, &scenario("a run within its limit", 2), &scenario("beyond it", 1)].concat();
    let file = tempfile::tempdir().unwrap();
    let file = (file.path().join("bench.toml"), file);
    fs::write(&file.0, bench).unwrap();
    let folder = written(&["hil", "run", "--repeats", "2", &file.0.display().to_string()], &[1]);
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
    let (mut page, mut junit) = (read("verdict.html"), read("junit.xml"));
    // What was tested differs from place to place, and seconds from run to run.
    let names: Vec<String> = ["version", "build", "car", "track", "bench", "options", "machine"]
        .into_iter()
        .chain(["machine stood still", "date", "duration"])
        .map(str::to_owned)
        .collect();
    for name in names {
        masked(&mut page, &format!("<th>{name}</th><td>"), "</td>");
        masked(&mut junit, &format!("<property name=\"{name}\" value=\""), "\"/>");
    }
    masked(&mut junit, " time=\"", "\"");
    compare("verdict.txt", &format!("{}\n{junit}", words(&page)));
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let output = lmpc(&["man", &folder.path().display().to_string()]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    fn visit(command: &clap::Command, name: &str, folder: &Path, names: &mut BTreeSet<String>) {
        let page = fs::read_to_string(folder.join(format!("{name}.1"))).unwrap();
        // Roff has its own way to write a hyphen.
        let page = page.replace("\\-", "-");
        for option in command.get_arguments().filter(|option| !option.is_hide_set()) {
            let Some(long) = option.get_long() else { continue };
            assert!(page.contains(&format!("--{long}")), "{name}.1 does not have --{long}");
        }
        names.insert(format!("{name}.1"));
        for inner in command.get_subcommands().filter(|inner| !inner.is_hide_set()) {
            visit(inner, &format!("{name}-{}", inner.get_name()), folder, names);
        }
    }
    let mut command = Cli::command().disable_help_subcommand(true);
    command.build();
    let mut names = BTreeSet::new();
    visit(&command, "lmpc", folder.path(), &mut names);
    let found: BTreeSet<String> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    assert_eq!(found, names);
    let first = fs::read_to_string(folder.path().join("lmpc-study-tracks.1")).unwrap();
    assert!(first.contains("matrix.html") && first.contains(".TH"), "{first}");
}
