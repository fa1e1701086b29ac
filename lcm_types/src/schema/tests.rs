//! The language: what is accepted, what is refused and with which words.

use super::{Schema, generate};

fn error(text: &str) -> String {
    Schema::parse(&[("x.lcm", text)]).unwrap_err().to_string()
}

#[test]
fn mistakes_are_named_with_their_place() {
    let cases = [
        (
            "package a;\nstruct t_t { uint8_t x; }",
            "x.lcm:2:22: unknown type `a.uint8_t` of `a.t_t.x`",
        ),
        ("struct t_t { int8_t x }", "x.lcm:1:23: found `}`, expected `;`"),
        ("struct t_t { int8_t x", "x.lcm:1:21: the file ends inside a declaration"),
        (
            "struct t_t { double n; int8_t x[n]; }",
            "x.lcm:1:33: length `n`, expected a number or an earlier integer member",
        ),
        (
            "struct t_t { int8_t x[-1]; }",
            "x.lcm:1:23: length `-1`, expected a number or an earlier integer member",
        ),
        (
            "struct t_t { int8_t x; int8_t x; }",
            "x.lcm:1:31: `x` in `t_t`, expected a new, plain name",
        ),
        ("struct t_t { const int8_t A = 128; }", "x.lcm:1:31: found `128`, expected a int8_t"),
        (
            "struct t_t { const string A = 1; }",
            "x.lcm:1:20: constant of type `string`, expected a number type",
        ),
        ("struct t_t { } struct t_t { }", "x.lcm:1:23: `t_t` is declared twice"),
        ("enum e { A }", "x.lcm:1:1: found `enum`, expected `const` in a struct"),
        ("struct t_t { /* ", "x.lcm:1:14: comment without an end, expected `*/`"),
        ("struct t_t { int8_t é; }", "x.lcm:1:21: unexpected character 'é'"),
        ("message t_t { }", "x.lcm:1:1: found `message`, expected `package` or `struct`"),
        ("struct 7 { }", "x.lcm:1:8: found `7`, expected a name"),
    ];
    for (text, expected) in cases {
        assert_eq!(error(text), expected, "{text}");
    }
}

#[test]
fn the_house_rules_find_each_offence() {
    let text = "struct thing { int8_t type; int32_t crc; double x[33]; thing again; }";
    let schema = Schema::parse(&[("x.lcm", text)]).unwrap();
    let found: Vec<String> = schema.lint().into_iter().map(|e| e.message).collect();
    for part in [
        "no package",
        "end in `_t`",
        "what the message is",
        "contains itself",
        "`type` is a keyword",
        "no comment on `crc`",
        "as the last member",
        "`x`, expected 1 to 32 elements",
    ] {
        assert!(found.iter().any(|m| m.contains(part)), "{part} in {found:#?}");
    }
    assert_eq!(Schema::parse(crate::SOURCES).unwrap().lint(), []);
}

#[test]
fn comments_go_to_what_they_describe() {
    let text = "// file\npackage p;\n// first\n// second\nstruct t_t {\n  /* a\n   * b */\n  int8_t x; // behind\n  int8_t y;\n}";
    let schema = Schema::parse(&[("x.lcm", text)]).unwrap();
    let t = schema.get("p.t_t").unwrap();
    assert_eq!(t.doc, ["first", "second"]);
    assert_eq!(t.members[0].doc, ["a", "b", "behind"]);
    assert!(t.members[1].doc.is_empty());
}

#[test]
fn any_text_is_a_schema_or_an_error() {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_pcg::Pcg64::seed_from_u64(9);
    let whole: String = crate::SOURCES.iter().map(|(_, text)| *text).collect();
    let letters: Vec<char> = whole.chars().collect();
    for _ in 0..300 {
        let mut text = letters.clone();
        for _ in 0..rng.random_range(1..10) {
            let at = rng.random_range(0..text.len());
            match rng.random_range(0..3) {
                0 => text[at] = ['{', '}', ';', '/', '*', '[', '0', 'ω'][rng.random_range(0..8)],
                1 => text.truncate(at.max(1)),
                _ => drop(text.drain(at..(at + 5).min(text.len() - 1).max(at))),
            }
        }
        let text: String = text.into_iter().collect();
        if let Ok(schema) = Schema::parse(&[("x.lcm", &text)]) {
            assert!(generate::rust(&schema).is_ok());
        }
    }
}

#[test]
fn names_become_rust_names() {
    assert_eq!(generate::rust_name("mpc_telemetry_t"), "MpcTelemetry");
    assert_eq!(generate::rust_name("pose"), "Pose");
}

#[test]
fn huge_and_deeply_nested_types_are_refused_at_once() {
    let mut nested = "struct s0_t { double x; } ".to_owned();
    let mut lengths = "struct s0_t { int32_t n; double x[n]; } ".to_owned();
    for i in 1..60 {
        nested += &format!("struct s{i}_t {{ s{}_t a; s{}_t b; }} ", i - 1, i - 1);
        lengths +=
            &format!("struct s{i}_t {{ int32_t n; s{}_t a[n]; s{}_t b[n]; }} ", i - 1, i - 1);
    }
    let dims = "[1]".repeat(10_000);
    let cases = [
        ("struct a_t { double x[1000000000]; }".to_owned(), "more than 1048576 values"),
        ("struct a_t { double x[100000][100000][100000]; }".to_owned(), "more than 1048576 values"),
        ("struct a_t { byte x[2147483647]; }".to_owned(), "more than 1048576 values"),
        (nested, "more than 1048576 values"),
        (lengths, "more than 1048576 values"),
        (format!("struct a_t {{ double x{dims}; }}"), "10000 dimensions"),
        (format!("struct a_t {{ double {}; }}", "x".repeat(2 << 20)), "bytes, at most 1048576"),
    ];
    for (text, expected) in &cases {
        let error = Schema::parse(&[("a.lcm", text)]).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    assert!(Schema::parse(&[("a.lcm", "struct a_t { double x[1000][1000]; }")]).is_ok());
    // A text without an end is not read to its end.
    let endless = std::io::repeat(b'x');
    assert!(Schema::read_text(endless).unwrap_err().to_string().contains("longer than"));
}
