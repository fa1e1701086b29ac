//! `junit.xml` of the bench is what Jenkins (xUnit plugin, junit-10) and Maven Surefire take: which
//! elements stand where, with which attributes, of which form.
#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

use std::path::Path;
use std::process::Command;

use roxmltree::{Document, Node};

/// What an element may hold: children, attributes it must have, attributes it may have.
type Rule =
    (&'static str, &'static [&'static str], &'static [&'static str], &'static [&'static str]);

const RULES: [Rule; 7] = [
    ("testsuites", &["testsuite"], &[], &["name", "time", "tests", "failures", "errors"]),
    (
        "testsuite",
        &["properties", "testcase"],
        &["name", "tests", "failures", "errors"],
        // Surefire wants these two as well.
        &["time", "skipped"],
    ),
    ("testcase", &["failure", "system-out"], &["name"], &["time", "classname"]),
    ("properties", &["property"], &[], &[]),
    ("property", &[], &["name", "value"], &[]),
    ("system-out", &[], &[], &[]),
    ("failure", &[], &[], &["type", "message"]),
];

/// Every way a document does not keep to the rules.
fn problems(text: &str) -> Vec<String> {
    let document = match Document::parse(text) {
        Ok(document) => document,
        Err(error) => return vec![error.to_string()],
    };
    let root = document.root_element();
    let mut problems = Vec::new();
    if root.tag_name().name() != "testsuites" {
        problems.push(format!("root {}", root.tag_name().name()));
    }
    for element in document.descendants().filter(Node::is_element) {
        problems.extend(of_element(element));
    }
    problems
}

fn of_element(element: Node<'_, '_>) -> Vec<String> {
    let name = element.tag_name().name();
    let Some((_, children, must, may)) = RULES.iter().find(|rule| rule.0 == name) else {
        return vec![format!("element {name}")];
    };
    let mut problems = Vec::new();
    for child in element.children().filter(Node::is_element) {
        if !children.contains(&child.tag_name().name()) {
            problems.push(format!("{} in {name}", child.tag_name().name()));
        }
    }
    for wanted in *must {
        if element.attribute(*wanted).is_none() {
            problems.push(format!("{name} without {wanted}"));
        }
    }
    for attribute in element.attributes() {
        let (key, value) = (attribute.name(), attribute.value());
        if !must.contains(&key) && !may.contains(&key) {
            problems.push(format!("{name} with {key}"));
        }
        let is_number = match key {
            "tests" | "failures" | "errors" | "skipped" => value.parse::<u64>().is_ok(),
            // Seconds, no sign and no exponent.
            "time" => {
                value.chars().all(|c| c.is_ascii_digit() || c == '.')
                    && value.parse::<f64>().is_ok()
            }
            _ => true,
        };
        if !is_number {
            problems.push(format!("{name} {key} {value:?}"));
        }
    }
    // The counts are those of the cases.
    let cases = element.descendants().filter(|n| n.has_tag_name("testcase")).count();
    let failures = element.descendants().filter(|n| n.has_tag_name("failure")).count();
    let said = |key| element.attribute(key).and_then(|text| text.parse::<usize>().ok());
    for (key, count) in [("tests", cases), ("failures", failures)] {
        if said(key).is_some_and(|said| said != count) {
            problems.push(format!("{name}: {key} {:?}, found {count}", said(key)));
        }
    }
    problems
}

#[test]
fn the_verdict_is_junit_whatever_a_bench_calls_things() {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../bench/host.toml");
    let text = std::fs::read_to_string(shipped).unwrap();
    let head = text[..text.find("[[process]]").unwrap()].replacen(
        "title = \"",
        "title = \"<&'> \u{e4} ",
        1,
    );
    let scenario = |name: &str, most: u32| {
        format!(
            "[[scenario]]\nname = '{name}'\nprogram = [\"sh\", \"-c\", \"echo lost 2\"]\n\
             [[scenario.expect]]\nmeasure = \"lost\"\nmost = {most}\n"
        )
    };
    let bench = [head, scenario("passes <\"&>", 2), scenario("fails ]]> \u{2264}", 1)].concat();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("junit");
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("bench.toml");
    std::fs::write(&file, bench).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_lmpc"));
    command.args(["hil", "run", "--repeats", "3", "--out"]).arg(&folder).arg(&file);
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let junit = std::fs::read_to_string(folder.join("junit.xml")).unwrap();
    assert_eq!(problems(&junit), Vec::<String>::new(), "{junit}");
    let document = Document::parse(&junit).unwrap();
    let suites: Vec<_> = document.descendants().filter(|n| n.has_tag_name("testsuite")).collect();
    let names: Vec<_> = suites.iter().filter_map(|suite| suite.attribute("name")).collect();
    assert_eq!(names, ["passes <\"&>", "fails ]]> \u{2264}"]);
    assert_eq!(suites[1].attribute("failures"), Some("3"));
    // The rules see what is wrong.
    for (from, to) in [
        ("<testcase ", "<case "),
        ("errors=\"0\"", ""),
        ("failures=\"3\"", "failures=\"2\""),
        ("time=\"", "time=\"-"),
        ("classname=", "class="),
        ("<failure ", "<failure line=\"1\" "),
    ] {
        assert!(!problems(&junit.replace(from, to)).is_empty(), "{from} to {to}");
    }
}
