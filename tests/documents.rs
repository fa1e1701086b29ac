//! What the documents promise: every link leads somewhere, every command and option exists, the book
//! holds every page, the code in the README is an example that is compiled.
#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn pages() -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![root().join("docs")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "md") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

fn documents() -> Vec<PathBuf> {
    let top = ["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md", "fmu/README.md"];
    let top = top.into_iter().chain(["tracks/README.md"]).map(|name| root().join(name));
    top.chain(pages()).collect()
}

/// Text without code blocks.
fn prose(text: &str) -> String {
    let mut code = false;
    let keep = |line: &&str| {
        let fence = line.trim_start().starts_with("```");
        code ^= fence;
        !code && !fence
    };
    text.lines().filter(keep).map(|line| format!("{line}\n")).collect()
}

/// Targets of `[text](target)`.
fn links(text: &str) -> Vec<String> {
    let prose = prose(text);
    let targets = prose.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets.map(str::to_owned).collect()
}

/// The anchor mdBook and forges give a heading.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

fn anchors(text: &str) -> Vec<String> {
    let prose = prose(text);
    let headings = prose.lines().filter(|line| line.starts_with('#'));
    headings.map(|line| anchor(line.trim_start_matches('#'))).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let mut count = 0;
    for document in documents() {
        let text = read(&document);
        for link in links(&text) {
            if link.starts_with("http") || link.starts_with("mailto:") {
                continue;
            }
            count += 1;
            let (path, fragment) = link.split_once('#').unwrap_or((&link, ""));
            let target = if path.is_empty() {
                document.clone()
            } else {
                document.parent().unwrap().join(path)
            };
            assert!(target.exists(), "{}: {link} leads nowhere", document.display());
            if !fragment.is_empty() {
                let known = anchors(&read(&target));
                let found = known.iter().any(|anchor| anchor == fragment);
                assert!(found, "{}: {link}: no such heading in {known:?}", document.display());
            }
        }
    }
    assert!(count > 40, "{count} links");
}

#[test]
fn the_book_holds_every_page_once() {
    let summary = read(&root().join("docs/SUMMARY.md"));
    let listed = links(&summary);
    for page in pages() {
        let name = page.strip_prefix(root().join("docs")).unwrap().display().to_string();
        let times = listed.iter().filter(|link| **link == name).count();
        let expected = usize::from(name != "SUMMARY.md");
        assert_eq!(times, expected, "{name} in docs/SUMMARY.md");
    }
}

#[test]
fn pages_of_the_book_link_within_the_book_or_to_files_of_the_tree() {
    // Links out of docs/ would break in the built book.
    for page in pages() {
        for link in links(&read(&page)) {
            let outside = page.parent().unwrap().join(&link);
            let inside = outside.canonicalize().map(|path| path.starts_with(root().join("docs")));
            let local = !link.starts_with("http") && !link.starts_with('#');
            let fine = !local || link.contains('#') || inside.unwrap_or(true);
            assert!(fine, "{}: {link} leaves the book; name the path as code", page.display());
        }
    }
}

/// Code blocks of a language.
fn blocks(text: &str, language: &str) -> Vec<String> {
    let mut found = Vec::new();
    for part in text.split("```").skip(1).step_by(2) {
        if let Some(code) = part.strip_prefix(language).and_then(|rest| rest.strip_prefix('\n')) {
            found.push(code.to_owned());
        }
    }
    found
}

#[test]
fn the_code_of_the_readme_is_an_example_that_is_compiled() {
    let blocks = blocks(&read(&root().join("README.md")), "rust");
    let example = read(&root().join("controller/examples/race_in_20_lines.rs"));
    assert_eq!(blocks.len(), 1);
    assert!(example.ends_with(&blocks[0]), "README.md and the example differ:\n{}", blocks[0]);
}

/// Commands a text shows: lines of its `sh` blocks and code within its sentences.
fn commands(text: &str) -> Vec<String> {
    let lines = blocks(text, "sh").join("\n").replace("\\\n", " ");
    let lines = lines.lines().map(|line| line.split(" #").next().unwrap().to_owned());
    let inline =
        prose(text).split('`').skip(1).step_by(2).map(|code| code.replace('\n', " ")).collect();
    let parts = lines.chain::<Vec<String>>(inline);
    let parts = parts.flat_map(|line| {
        line.split(['&', ';', '|']).map(|part| part.trim().to_owned()).collect::<Vec<_>>()
    });
    parts.filter(|part| part.starts_with("lmpc ")).collect()
}

/// The reference's section of a command, and the words after the command's name.
fn section<'a>(reference: &'a str, words: &'a [&'a str]) -> Option<(&'a str, &'a [&'a str])> {
    (1..=words.len().min(3)).rev().find_map(|count| {
        let heading = format!("## `lmpc {}`\n", words[..count].join(" "));
        let text = reference.split_once(&heading)?.1;
        Some((text.split("\n## `").next()?, &words[count..]))
    })
}

#[test]
fn every_command_in_the_documents_is_in_the_reference() {
    let reference = read(&root().join("docs/reference/cli.md"));
    let (mut count, mut options) = (0, 0);
    for document in documents().iter().chain([&root().join("examples/lcm/car.toml")]) {
        if document.ends_with("CHANGELOG.md") || document.ends_with("cli.md") {
            continue;
        }
        for command in commands(&read(document)) {
            let place = format!("{}: `{command}`", document.display());
            let words: Vec<&str> = command.split_whitespace().skip(1).collect();
            let words = &words[words.iter().take_while(|word| word.starts_with('-')).count()..];
            if words.is_empty() {
                continue;
            }
            count += 1;
            let (text, rest) =
                section(&reference, words).unwrap_or_else(|| panic!("{place}: no such command"));
            for word in rest.iter().filter(|word| word.starts_with("--")) {
                options += 1;
                let name = |c: char| c == '-' || c.is_ascii_alphanumeric();
                let option = word.split(|c| !name(c)).next().unwrap();
                let known = text.split(|c| !name(c)).any(|word| word == option);
                assert!(known, "{place}: this command has no option {option}");
            }
        }
    }
    assert!(count > 150 && options > 100, "{count} commands, {options} options");
}

#[test]
fn the_rustdoc_of_the_controller_links_to_files_that_exist() {
    let text = read(&root().join("controller/src/lib.rs"));
    let sources: Vec<&str> =
        text.split("(../src/").skip(1).filter_map(|rest| rest.split(".html").next()).collect();
    assert!(sources.len() >= 10, "{sources:?}");
    for source in sources {
        let (package, path) = source.split_once('/').unwrap();
        let folders = [root().join(package), root().join("controller").join(package)];
        assert!(folders.iter().any(|folder| folder.join("src").join(path).exists()), "{source}");
    }
}

/// Lines of a module's own doc.
fn module_doc(text: &str) -> String {
    let lines = text.lines().take_while(|line| line.starts_with("//!"));
    lines.map(|line| format!("{line}\n")).collect()
}

/// What a row of the table of equations is known by: its number in brackets, or the words up to a comma.
fn label(cell: &str) -> &str {
    match cell.strip_prefix('(').and_then(|rest| rest.find(')')) {
        Some(end) => &cell[..end + 2],
        None => cell.split(',').next().unwrap(),
    }
}

#[test]
fn each_file_of_the_table_of_equations_opens_with_the_label_of_its_row() {
    let text = read(&root().join("controller/src/lib.rs"));
    let mut labels = Vec::new();
    for row in text.lines().filter_map(|line| line.strip_prefix("//! | ")) {
        let label = label(row.split(" | ").next().unwrap());
        for link in row.split("(../src/").skip(1) {
            let (package, path) = link.split(".html").next().unwrap().split_once('/').unwrap();
            let folders = [root().join(package), root().join("controller").join(package)];
            let files = folders.iter().map(|folder| folder.join("src").join(path));
            let file = files.into_iter().find(|file| file.exists()).unwrap();
            let doc = module_doc(&read(&file));
            assert!(doc.contains("```text") || !label.starts_with('('), "{path}: no equation");
            let found = doc.to_lowercase().contains(&label.to_lowercase());
            assert!(found, "{}: its doc has no {label}", file.display());
            labels.push(label);
        }
    }
    for number in ["(1)", "(3)", "(4)", "(5)", "(6)", "(7)", "(8)", "D^j", "D^0", "X^j", "z_bar"] {
        assert!(labels.contains(&number), "{number}: no row of the table links a file");
    }
    let paths = ["learning/dataset.rs", "slip.rs", "plan.rs", "drive.rs", "learned_model.rs"];
    for path in paths {
        let doc = module_doc(&read(&root().join("controller/src").join(path)));
        assert!(doc.contains("```text"), "{path} opens without its equation");
    }
}

#[test]
fn the_deviations_from_the_paper_stand_in_one_place() {
    let heading = "# Deviations from the paper";
    let mut files = documents();
    files.push(root().join("controller/src/lib.rs"));
    let with = files.iter().filter(|file| read(file).contains(heading));
    let with: Vec<_> = with.map(|file| file.strip_prefix(root()).unwrap().to_owned()).collect();
    assert_eq!(with, [Path::new("docs/explanation/algorithm.md")]);
    let lib = read(&root().join("controller/src/lib.rs"));
    assert!(lib.contains("`docs/explanation/algorithm.md`, section \"Deviations from the paper\""));
}

#[test]
fn the_changelog_and_the_citation_are_of_this_version() {
    let workspace: toml::Table = read(&root().join("Cargo.toml")).parse().unwrap();
    let version = workspace["workspace"]["package"]["version"].as_str().unwrap();
    let changelog = read(&root().join("CHANGELOG.md"));
    let newest = changelog.lines().find_map(|line| line.strip_prefix("## ")).unwrap();
    // A version, or what comes after it.
    let known = newest == "Unreleased" || newest.split(' ').next() == Some(version);
    assert!(known, "CHANGELOG.md begins with {newest}, the workspace is {version}");
    let citation = read(&root().join("CITATION.cff"));
    assert!(citation.contains(&format!("\nversion: {version}\n")), "CITATION.cff: {version}");
}

#[test]
fn the_readme_is_short() {
    assert!(read(&root().join("README.md")).lines().count() <= 150);
}

#[test]
fn lints_and_ci_check_everything_that_is_configured() {
    let makefile = read(&root().join("Makefile"));
    let deny = read(&root().join("deny.toml"));
    let line = makefile.lines().find(|line| line.contains("cargo deny check")).unwrap();
    for table in ["[licenses]", "[bans]", "[sources]", "[advisories]"] {
        assert!(deny.contains(table), "deny.toml has no {table}");
    }
    assert_eq!(line.trim(), "cargo deny check", "all tables of deny.toml are checked");
    let workflow = read(&root().join(".github/workflows/ci.yml"));
    assert!(workflow.contains(".ci/run"));
    let oldest: toml::Table = read(&root().join("Cargo.toml")).parse().unwrap();
    let oldest = oldest["workspace"]["package"]["rust-version"].as_str().unwrap();
    assert!(workflow.contains(&format!("rust-toolchain@{oldest}")), "the oldest Rust is tested");
}

/// Commands of a stage of the container file.
fn stage(text: &str, name: &str) -> Vec<String> {
    let begins = |line: &&str| line.starts_with("FROM") && line.ends_with(&format!(" AS {name}"));
    let lines = text.lines().skip_while(|line| !begins(line)).skip(1);
    let own = lines.take_while(|line| !line.starts_with("FROM"));
    own.filter_map(|line| line.strip_prefix("RUN ")).map(str::to_owned).collect()
}

#[test]
fn the_container_runs_the_commands_of_the_readme() {
    let (container, readme) =
        (read(&root().join("Containerfile")), read(&root().join("README.md")));
    let start = readme.split("## Start").nth(1).unwrap().split("```").nth(1).unwrap();
    // `make test` needs network namespaces, which a build has not: its comment names the part that does not.
    let commands: Vec<String> = start
        .lines()
        .filter_map(|line| line.strip_prefix("make "))
        .map(|line| format!("make {}", line.split_whitespace().next().unwrap()))
        .map(|line| if line == "make test" { "make test-fast".to_owned() } else { line })
        .collect();
    assert_eq!(stage(&container, "readme"), commands);
    let makefile = read(&root().join("Makefile"));
    let build = stage(&container, "build");
    assert!(!build.is_empty());
    for command in commands.iter().chain(&build) {
        match command.strip_prefix("make ") {
            Some(target) => assert!(makefile.contains(&format!("\n{target}:")), "{command}"),
            None => assert!(root().join(command.split(' ').next().unwrap()).exists(), "{command}"),
        }
    }
}
