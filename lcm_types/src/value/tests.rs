//! What the codec tests beside the generated types do not reach.

use super::{MAX_DEPTH, Path, Value};
use crate::Error;
use crate::schema::Schema;

const FILE: &str = "package a;
struct inner_t { double pos[3]; string name; }
struct outer_t { int64_t utime; int32_t n; inner_t parts[n]; inner_t one; float grid[2][2]; }
struct node_t { int8_t n; node_t children[n]; }
struct loop_t { loop_t again; }";

fn schema() -> Schema {
    Schema::parse(&[("a.lcm", FILE)]).unwrap()
}

#[test]
fn a_path_leads_to_one_value() {
    let schema = schema();
    let mut message = schema.zero("a.outer_t").unwrap();
    for (path, value) in [("utime", Value::Integer(7)), ("one.pos[2]", Value::Double(2.5))] {
        let path = Path::parse(&schema, "a.outer_t", path).unwrap();
        *path.get_mut(&mut message).unwrap() = value.clone();
        assert_eq!(path.get(&message), Some(&value));
    }
    let mut bytes = Vec::new();
    schema.encode_into("a.outer_t", &message, &mut bytes).unwrap();
    assert_eq!(schema.decode("a.outer_t", &bytes).unwrap(), message);
    // The array is empty: the path is right, the value is not there.
    let part = Path::parse(&schema, "a.outer_t", "parts[0].pos[1]").unwrap();
    assert_eq!(part.get(&message), None);
}

#[test]
fn a_wrong_path_is_named_with_what_would_do() {
    let schema = schema();
    let error = |path| Path::parse(&schema, "a.outer_t", path).unwrap_err().to_string();
    assert_eq!(
        error("one.posn[0]"),
        "path `one.posn[0]` in a.outer_t:1:5: `posn`, expected one of pos, name"
    );
    assert!(error("one").ends_with("`one` is a a.inner_t, expected one of its members"));
    assert!(error("utime.x").ends_with("`utime` is a int64_t, it has no members"));
    assert!(error("grid[1]").ends_with("1 indices on `grid[1]`, expected 2"));
    assert!(error("grid[1][x]").ends_with("`[x]`, expected `[number]`"));
    assert!(matches!(Path::parse(&schema, "a.b_t", "x"), Err(Error::UnknownType { .. })));
}

#[test]
fn values_of_the_wrong_kind_are_not_encoded() {
    let schema = schema();
    let mut message = schema.zero("a.outer_t").unwrap();
    let path = Path::parse(&schema, "a.outer_t", "utime").unwrap();
    *path.get_mut(&mut message).unwrap() = Value::Double(1.0);
    let mut bytes = vec![1];
    let error = schema.encode_into("a.outer_t", &message, &mut bytes).unwrap_err();
    assert_eq!(error.to_string(), "a.outer_t.utime: found a double, expected int64_t");
    assert!(bytes.is_empty());
}

#[test]
fn nesting_is_bounded() {
    let schema = schema();
    let node = |levels: usize| {
        let mut bytes = schema.fingerprint("a.node_t").unwrap().to_be_bytes().to_vec();
        bytes.extend(std::iter::repeat_n(1, levels));
        bytes.push(0);
        bytes
    };
    assert!(schema.decode("a.node_t", &node(MAX_DEPTH)).is_ok());
    let error = schema.decode("a.node_t", &node(MAX_DEPTH + 1)).unwrap_err();
    assert!(matches!(error, Error::Depth { .. }), "{error}");
    assert!(matches!(schema.zero("a.loop_t"), Err(Error::Depth { .. })));
    let bytes = schema.fingerprint("a.loop_t").unwrap().to_be_bytes();
    assert!(matches!(schema.decode("a.loop_t", &bytes), Err(Error::Depth { .. })));
}
