//! Known motions of a car, as other programs would report them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

use lcm_types::VehicleState;
use lcm_types::schema::Schema;
use lcm_types::value::{Path, Value};
use vehicle_model::Input;

use super::*;
use lcm_types::Arrival;

const TYPES: &str = "package their;
struct ins_t { double t; float north; float east; double heading; double speed; double rate; }
struct pose_t { int64_t utime; double pos[3]; double q[4]; double vel[3]; double rate[3]; }
struct wheel_t { int32_t angle; }
struct cmd_t { int64_t stamp; int16_t steer; byte gas; double brake; boolean go; int8_t gear; }
";

const COMMAND: &str = r#"
[command]
channel = "DO"
type = "their.cmd_t"
time = { field = "stamp", unit = "us", of = "measurement" }
field = [
  { field = "steer", from = "steer", unit = "deg", scale = -10.0, offset = 3.0, min = -200.0, max = 200.0 },
  { field = "gas", from = "drive", unit = "m/s^2", scale = 100.0, max = 150.0, stop = 0.0 },
  { field = "brake", from = "brake", unit = "g", max = 1.0, stop = 0.5 },
  { field = "go", from = "enabled", stop = 0.0 },
  { field = "gear", from = "constant", offset = 3.0 },
]
"#;

/// Navigation: north and east, heading from north clockwise in degrees, speed in km/h.
const INS: &str = r#"
types = ["their.lcm"]
source.ins = { channel = "INS", type = "their.ins_t", time = { field = "t", unit = "s" } }
source.wheel = { channel = "WHEEL", type = "their.wheel_t", max_age_ms = 50 }
[state]
x = { source = "ins", field = "east", unit = "m" }
y = { source = "ins", field = "north", unit = "m", offset = 2.0 }
yaw = { source = "ins", field = "heading", unit = "deg", zero = "north", positive = "clockwise" }
vx = { source = "ins", field = "speed", unit = "km/h" }
yaw_rate = { source = "ins", field = "rate", unit = "deg/s", scale = -1.0 }
steer = { source = "wheel", field = "angle", unit = "deg", scale = 0.01 }
[reference]
forward_m = -1.5
left_m = 0.5
"#;

const POSE: &str = r#"
types = ["their.lcm"]
source.pose = { channel = "POSE", type = "their.pose_t", time = { field = "utime", unit = "us" } }
reference = { forward_m = -0.13 }
frame = { x_m = 10.0, y_m = -4.0, yaw_deg = 90.0 }
[state]
velocity_frame = "world"
x = { field = "pos[0]", unit = "m" }
y = { field = "pos[1]", unit = "m" }
yaw = { quaternion = "q", order = "xyzw" }
vx = { field = "vel[0]", unit = "m/s" }
vy = { field = "vel[1]", unit = "m/s" }
yaw_rate = { field = "rate[2]", unit = "rad/s" }
"#;

fn schema() -> Schema {
    Schema::parse(&[("their.lcm", TYPES)]).unwrap()
}

fn mapping(state: &str) -> Result<Mapping, Vec<MapProblem>> {
    let text = format!("{state}{COMMAND}");
    Mapping::new(&toml::from_str(&text).unwrap(), &text, schema())
}

fn message(kind: &str, values: &[(&str, Value)]) -> Vec<u8> {
    let schema = schema();
    let mut message = schema.zero(kind).unwrap();
    for (path, value) in values {
        let path = Path::parse(&schema, kind, path).unwrap();
        *path.get_mut(&mut message).unwrap() = value.clone();
    }
    let mut bytes = Vec::new();
    schema.encode_into(kind, &message, &mut bytes).unwrap();
    bytes
}

fn at(milliseconds: i64) -> Arrival {
    Arrival {
        utime: milliseconds * 1000,
        mono: lcm_types::MonoTime::from_ns(milliseconds * 1_000_000),
    }
}

fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-6, "{found}, expected {expected}");
}

#[test]
fn navigation_in_degrees_from_north_becomes_a_state_at_the_centre_of_mass() {
    let mut mapping = mapping(INS).unwrap();
    let ins = |t: f64| {
        let values = [
            ("t", Value::Double(t)),
            ("north", Value::Float(5.0)),
            ("east", Value::Float(7.0)),
            // Heading east by south: yaw -30 degrees.
            ("heading", Value::Double(120.0)),
            ("speed", Value::Double(36.0)),
            ("rate", Value::Double(-45.0)),
        ];
        message("their.ins_t", &values)
    };
    let state = mapping.take("INS", &ins(3.0), at(100)).unwrap();
    assert_eq!((state.quality, state.valid), (1, VehicleState::POSE | VehicleState::VEL));
    let (yaw, rate) = (-std::f64::consts::PI / 6.0, std::f64::consts::FRAC_PI_4);
    near(state.yaw, yaw);
    near(state.yaw_rate, rate);
    // The source sits 1.5 m behind and 0.5 m left of the centre of mass: back to it by rotation.
    near(state.x + -1.5 * yaw.cos() - 0.5 * yaw.sin(), 7.0);
    near(state.y + -1.5 * yaw.sin() + 0.5 * yaw.cos(), 7.0);
    // Velocity there: that of the centre of mass plus omega times the arm.
    near(state.vx - rate * 0.5, 10.0);
    near(state.vy + rate * -1.5, 0.0);
    // The other message joins as long as it is young; it makes no state of its own.
    let wheel = message("their.wheel_t", &[("angle", Value::Integer(-500))]);
    assert_eq!(mapping.take("WHEEL", &wheel, at(190)), None);
    let state = mapping.take("INS", &ins(3.1), at(200)).unwrap();
    near(state.steer, -5.0_f64.to_radians());
    assert_eq!((state.meas_mono_ns, state.valid & VehicleState::STEER), (200_000_000, 16));
    let state = mapping.take("INS", &ins(3.15), at(250)).unwrap();
    assert_eq!(state.valid & VehicleState::STEER, 0);
    assert_eq!(mapping.take("INS", &ins(3.12), at(260)), None);
    assert_eq!(mapping.take("INS", &wheel, at(260)), None);
    let counts = mapping.counts();
    assert_eq!((counts.states, counts.old, counts.bad, counts.incomplete), (3, 1, 1, 0));
}

#[test]
fn world_velocities_and_a_quaternion_agree_with_rotation_by_hand() {
    let mut mapping = mapping(POSE).unwrap();
    let (yaw, omega) = (2.0_f64, 1.5);
    let (v_x, v_y) = (3.0, 0.2);
    let pose = |utime: i64, scale: f64| {
        let rear = v_y - 0.13 * omega;
        let values = [
            ("utime", Value::Integer(utime)),
            ("pos[0]", Value::Double(1.0 - 0.13 * yaw.cos())),
            ("pos[1]", Value::Double(2.0 - 0.13 * yaw.sin())),
            ("q[2]", Value::Double(scale * (yaw / 2.0).sin())),
            ("q[3]", Value::Double(scale * (yaw / 2.0).cos())),
            ("vel[0]", Value::Double(v_x * yaw.cos() - rear * yaw.sin())),
            ("vel[1]", Value::Double(v_x * yaw.sin() + rear * yaw.cos())),
            ("rate[2]", Value::Double(omega)),
        ];
        message("their.pose_t", &values)
    };
    let state = mapping.take("POSE", &pose(5, 1.0), at(1000)).unwrap();
    near(state.x, 10.0 - 2.0);
    near(state.y, -4.0 + 1.0);
    near(state.yaw, yaw + std::f64::consts::FRAC_PI_2 - 2.0 * std::f64::consts::PI);
    near(state.vx, v_x);
    near(state.vy, v_y);
    // Time goes by the source's clock, whatever the arrivals; a leap begins anew.
    let mut time =
        |utime, ms| mapping.take("POSE", &pose(utime, 1.0), at(ms)).map(|s| s.meas_mono_ns);
    assert_eq!(time(100_005, 1003), Some(1_100_000_000));
    assert_eq!(time(100_005, 1203), Some(1_100_000_000));
    assert_eq!(time(100_004, 1204), None);
    assert_eq!(time(9_000_000_000, 2000), Some(2_000_000_000));
    // An estimator that has not started.
    assert_eq!(mapping.take("POSE", &pose(9_000_100_000, 0.0), at(2100)), None);
    assert_eq!(mapping.take("POSE", &pose(9_000_200_000, f64::NAN), at(2200)), None);
    assert_eq!(mapping.counts().incomplete, 2);
}

#[test]
fn an_input_becomes_their_command_and_stops_when_there_is_none() {
    let mut mapping = mapping(POSE).unwrap();
    let bytes =
        message("their.pose_t", &[("utime", Value::Integer(700)), ("q[3]", Value::Double(1.0))]);
    let state = mapping.take("POSE", &bytes, at(5)).unwrap();
    let mut bytes = Vec::new();
    let mut say = |input: Option<Input>| {
        let request = CarRequest { input, answers_ns: Some(state.meas_mono_ns), utime: 1 };
        mapping.command(&request, &mut bytes).unwrap();
        let Value::Struct(values) = schema().decode("their.cmd_t", &bytes).unwrap() else {
            panic!("a struct");
        };
        values.iter().map(|v| v.number().unwrap()).collect::<Vec<_>>()
    };
    let degree = 1.0_f64.to_radians();
    assert_eq!(
        say(Some(Input { a: 0.5, delta: 2.0 * degree })),
        [700.0, -17.0, 50.0, 0.0, 1.0, 3.0]
    );
    let braking = say(Some(Input { a: -4.903_325, delta: 0.0 }));
    assert_eq!(braking[..3], [700.0, 3.0, 0.0]);
    near(braking[3], 0.5);
    // Cut at both ends.
    assert_eq!(say(Some(Input { a: 9.0, delta: 1.0 }))[1..3], [-200.0, 150.0]);
    assert_eq!(say(Some(Input { a: -90.0, delta: -1.0 }))[1..4], [200.0, 0.0, 1.0]);
    // The wheels stay, the pedals do what the file says.
    assert_eq!(say(None), [700.0, 200.0, 0.0, 0.5, 0.0, 3.0]);
}

#[test]
fn everything_wrong_is_named_with_its_line() {
    let broken = INS
        .replace("\"east\"", "\"est\"")
        .replace("unit = \"km/h\"", "unit = \"kmh\"")
        .replace("max_age_ms = 50", "max_age_ms = -1")
        .replace("their.ins_t", "their.in_t");
    let lines = |problems: Vec<MapProblem>| -> Vec<String> {
        problems.iter().map(ToString::to_string).collect()
    };
    let found = lines(mapping(&broken).unwrap_err());
    assert_eq!(
        found,
        [
            "line 3: type `their.in_t`, expected one of their.ins_t, their.pose_t, their.wheel_t, \
             their.cmd_t",
            "line 4: max_age_ms = -1, expected a number above 0",
            "line 9: unit `kmh`, expected one of m/s, km/h, mph",
        ]
    );
    let broken =
        INS.replace("\"east\"", "\"est\"").replace("source = \"wheel\"", "source = \"whel\"");
    let found = lines(mapping(&broken).unwrap_err());
    assert!(
        found[0].starts_with("line 6: ") && found[0].contains("expected one of t, north"),
        "{found:?}"
    );
    assert_eq!(found[1], "line 11: source `whel`, expected one of ins, wheel");
    let found = lines(mapping(&POSE.replace("pos[1]", "pos[3]")).unwrap_err());
    assert_eq!(found, ["line 9: `pos[3]`: index 3, the array has 3"]);
    let text = format!("{POSE}{}", COMMAND.replace(", stop = 0.0", "").replace(", stop = 0.5", ""));
    let file = toml::from_str(&text).unwrap();
    let found = lines(Mapping::new(&file, &text, schema()).unwrap_err());
    assert!(found[0].contains("would go on when the commands stop"), "{found:?}");
}
