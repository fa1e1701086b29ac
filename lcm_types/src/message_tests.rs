//! The typed and the run-time codec against each other, and both against damage.

use rand::SeedableRng;
use rand_pcg::Pcg64;

use crate::schema::Schema;
use crate::value::Value;
use crate::{Checked, Error, Message};

#[path = "../tests/common/random.rs"]
mod random;

/// Decodes and encodes with the generated type called `name`.
fn recode(name: &str, bytes: &[u8]) -> Result<Vec<u8>, Error> {
    fn with<M: Message>(bytes: &[u8]) -> Result<Vec<u8>, Error> {
        let mut out = vec![1, 2, 3]; // must be replaced
        M::decode(bytes)?.encode_into(&mut out)?;
        Ok(out)
    }
    macro_rules! dispatch {
        ($($message:ty),* $(,)?) => {
            match name {
                $(<$message>::NAME => with::<$message>(bytes),)*
                other => panic!("type {other} is not in the list of the tests"),
            }
        };
    }
    dispatch!(
        crate::Header,
        crate::Frenet,
        crate::VehicleState,
        crate::ActuationCommand,
        crate::ActuationReport,
        crate::PredPoint,
        crate::MpcTelemetry,
        crate::LapResult,
        crate::Heartbeat,
        crate::OperatorCommand,
        crate::OperatorAck,
        crate::Setup,
        crate::Hello,
        crate::Track,
        crate::sample::Empty,
        crate::sample::Part,
        crate::sample::Sample,
    )
}

fn schema() -> Schema {
    let files = [crate::SOURCES, crate::sample::SOURCES].concat();
    Schema::parse(&files).unwrap()
}

/// As printed by lcm-gen 1.3.1 and 1.5.3.
const FINGERPRINTS: [(&str, u64); 14] = [
    ("lmpc.actuation_command_t", 0x5910_1ead_56c1_6132),
    ("lmpc.actuation_report_t", 0x424b_58e8_d5db_3819),
    ("lmpc.frenet_t", 0xe7e5_6d20_a1c3_5904),
    ("lmpc.header_t", 0x82d3_c0e5_44ca_3ecc),
    ("lmpc.heartbeat_t", 0xbd2d_35c7_bca7_faa4),
    ("lmpc.hello_t", 0xf8fc_fcfe_8285_1bcc),
    ("lmpc.lap_result_t", 0x2454_ff89_ec6b_8c97),
    ("lmpc.mpc_telemetry_t", 0x121f_9ef0_2acd_c0ec),
    ("lmpc.operator_ack_t", 0x96b7_0b00_79c6_2ca5),
    ("lmpc.operator_command_t", 0x9222_fccc_670d_1e58),
    ("lmpc.pred_point_t", 0x970a_595c_8d0d_2ce2),
    ("lmpc.setup_t", 0x85ea_f3c7_b034_54b0),
    ("lmpc.track_t", 0x2e52_3ba3_9c20_da0e),
    ("lmpc.vehicle_state_t", 0x6e72_dadd_f994_2e67),
];

#[test]
fn the_fingerprints_are_those_of_lcm_gen() {
    let schema = Schema::parse(crate::SOURCES).unwrap();
    assert_eq!(schema.structs.len(), FINGERPRINTS.len());
    for (name, expected) in FINGERPRINTS {
        assert_eq!(schema.fingerprint(name), Some(expected), "{name}");
    }
    assert_eq!(crate::VehicleState::FINGERPRINT, 0x6e72_dadd_f994_2e67);
}

#[test]
fn fifty_thousand_random_messages_are_the_same_bytes_in_both_codecs() {
    let schema = schema();
    let names: Vec<String> = schema.structs.iter().map(super::schema::Struct::full_name).collect();
    let mut rng = Pcg64::seed_from_u64(4);
    let (mut bytes, mut again) = (Vec::new(), Vec::new());
    for name in names.iter().cycle().take(50_000) {
        let value = random::message(&schema, name, &mut rng);
        schema.encode_into(name, &value, &mut bytes).unwrap();
        assert_eq!(recode(name, &bytes).unwrap(), bytes, "{name}");
        let decoded = schema.decode(name, &bytes).unwrap();
        schema.encode_into(name, &decoded, &mut again).unwrap();
        assert_eq!(again, bytes, "{name}");
    }
}

/// The fuzz target of the normal test run. `LCM_FUZZ_INPUTS` and `LCM_FUZZ_SEED` make it longer or
/// different.
#[test]
fn fifty_thousand_damaged_messages_are_values_or_errors() {
    let setting = |name, default| std::env::var(name).map_or(default, |text| text.parse().unwrap());
    let inputs: usize = setting("LCM_FUZZ_INPUTS", 50_000);
    let schema = schema();
    let names: Vec<String> = schema.structs.iter().map(super::schema::Struct::full_name).collect();
    let mut rng = Pcg64::seed_from_u64(setting("LCM_FUZZ_SEED", 5) as u64);
    let mut bytes = Vec::new();
    let (mut values, mut errors) = (0, 0);
    for name in names.iter().cycle().take(inputs) {
        let value = random::message(&schema, name, &mut rng);
        schema.encode_into(name, &value, &mut bytes).unwrap();
        random::damage(&mut bytes, &mut rng);
        let typed = recode(name, &bytes);
        let dynamic = schema.decode(name, &bytes);
        assert_eq!(typed.is_ok(), dynamic.is_ok(), "{name}: {typed:?} {dynamic:?} {bytes:?}");
        match typed {
            // Strict decoding: whatever is accepted is the one encoding of its value.
            Ok(again) => {
                assert_eq!(again, bytes, "{name}");
                values += 1;
            }
            Err(typed) => {
                assert_eq!(typed.to_string(), dynamic.unwrap_err().to_string());
                errors += 1;
            }
        }
    }
    assert!(values > inputs / 20 && errors > inputs / 4, "{values} values, {errors} errors");
}

#[test]
fn each_kind_of_damage_has_its_error() {
    let header = crate::Header { sender: "ab".into(), ..crate::Header::default() };
    let mut good = Vec::new();
    header.encode_into(&mut good).unwrap();
    let string = 8 + 4 * 8; // where the length of `sender` stands
    let broken = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = good.clone();
        change(&mut bytes);
        crate::Header::decode(&bytes).unwrap_err()
    };
    assert!(matches!(broken(&|b| b.truncate(7)), Error::Short { needed: 8, left: 7, .. }));
    assert!(matches!(broken(&|b| b.truncate(20)), Error::Short { needed: 8, left: 4, .. }));
    assert!(matches!(broken(&|b| b[0] ^= 1), Error::Fingerprint { .. }));
    assert!(matches!(broken(&|b| b.push(0)), Error::Trailing { bytes: 1, .. }));
    assert!(matches!(broken(&|b| b[string + 3] = 0), Error::Length { found: 0, .. }));
    assert!(matches!(broken(&|b| b[string] = 0x80), Error::Length { found: -2_147_483_645, .. }));
    assert!(matches!(broken(&|b| b[string + 3] = 4), Error::Length { found: 4, limit: 3, .. }));
    assert!(matches!(broken(&|b| b[string + 4] = 0), Error::Nul { .. }));
    assert!(matches!(broken(&|b| b[string + 6] = 7), Error::Nul { .. }));
    assert!(matches!(broken(&|b| b[string + 4] = 0xff), Error::Utf8 { .. }));
    let text = broken(&|b| b[string + 3] = 0).to_string();
    assert_eq!(text, "lmpc.header_t.sender: length 0 before offset 44, expected 0 to 3");
}

#[test]
fn a_boolean_is_zero_or_one() {
    let report = crate::ActuationReport { enabled: true, ..Default::default() };
    let mut bytes = Vec::new();
    report.encode_into(&mut bytes).unwrap();
    let at = bytes.len() - (4 + 8 + 8 + 4 + 1) - 1;
    bytes[at] = 2;
    let error = crate::ActuationReport::decode(&bytes).unwrap_err();
    assert!(matches!(error, Error::Boolean { found: 2, .. }), "{error}");
}

#[test]
fn the_checksum_is_checked_before_anything_else() {
    let state = crate::VehicleState { vx: 2.5, ..Default::default() };
    let mut bytes = Vec::new();
    state.seal_into(&mut bytes).unwrap();
    let opened = crate::VehicleState::open(&bytes).unwrap();
    assert_eq!(opened.crc.cast_unsigned(), crate::crc::of(&bytes[..bytes.len() - 4]));
    for bit in 0..bytes.len() * 8 {
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(matches!(crate::VehicleState::open(&bytes), Err(Error::Crc { .. })));
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
}

#[test]
fn arrays_that_disagree_with_their_length_are_not_encoded() {
    let command =
        crate::ActuationCommand { n_plan: 2, plan_accel: vec![0.0; 2], ..Default::default() };
    let mut bytes = vec![9];
    let error = command.encode_into(&mut bytes).unwrap_err();
    assert_eq!(
        error.to_string(),
        "lmpc.actuation_command_t.plan_steer: 0 elements, expected 2 by its length field"
    );
    assert!(bytes.is_empty());
    let ragged = crate::MpcTelemetry { n_x: 2, n_ss: 1, ss: vec![vec![0.0]], ..Default::default() };
    assert!(matches!(
        ragged.encode_into(&mut bytes),
        Err(Error::Count { found: 1, expected: 2, .. })
    ));
    let nul = crate::Header { sender: "a\0b".into(), ..Default::default() };
    assert!(matches!(nul.encode_into(&mut bytes), Err(Error::Nul { .. })));
}

#[test]
fn rows_without_a_byte_are_allowed_up_to_a_bound() {
    let mut telemetry = crate::MpcTelemetry::default();
    let mut bytes = Vec::new();
    for (rows, accepted) in [(4096, true), (4097, false)] {
        telemetry.n_ss = rows;
        telemetry.ss = vec![Vec::new(); rows as usize];
        telemetry.ss_cost = vec![0.0; rows as usize];
        telemetry.ss_lambda = vec![0.0; rows as usize];
        telemetry.encode_into(&mut bytes).unwrap();
        assert_eq!(crate::MpcTelemetry::decode(&bytes).is_ok(), accepted, "{rows} rows");
    }
}

#[test]
fn a_normal_message_has_the_size_planned_for() {
    // Sizes decide whether a message fits one Ethernet frame: 1,400 bytes.
    let h = crate::Header { sender: "lmpc@host".into(), ..Default::default() };
    let mut bytes = Vec::new();
    crate::VehicleState { h: h.clone(), ..Default::default() }.encode_into(&mut bytes).unwrap();
    let size = 8 + (4 * 8 + 14) + 16 + 5 + 6 * 8 + 3 * 8 + 4 * 8 + 6 * 8 + (4 * 8 + 12) + 4;
    assert_eq!(bytes.len(), size);
    crate::ActuationCommand { h, ..Default::default() }.encode_into(&mut bytes).unwrap();
    assert_eq!(bytes.len(), 8 + 46 + 24 + 4 + 8 + 2 + 24 + 2 + 4 + 4);
}

#[test]
fn constants_have_the_values_of_the_file() {
    use crate::sample::Sample;
    assert_eq!((Sample::SIZE, Sample::MINUS, Sample::BIG), (3, -7, i64::MAX));
    assert_eq!([Sample::GAIN, Sample::MILLI, Sample::WHOLE], [3.25, 1e-3, 2.0]);
    assert_eq!(crate::VehicleState::WHEELS, 0x20);
}

/// The value the golden files hold, by the rule in `tests/interop/golden.py`.
fn golden(schema: &Schema, name: &str, count: &mut i64) -> Value {
    use crate::schema::{Dim, Member, Primitive, Type};
    fn value(schema: &Schema, m: &Member, length: bool, dims: &[Dim], n: &mut i64) -> Value {
        if let [dim, rest @ ..] = dims {
            let count = if let Dim::Fixed { count, .. } = dim { *count } else { 2 };
            return Value::Array((0..count).map(|_| value(schema, m, length, rest, n)).collect());
        }
        let kind = match &m.kind {
            Type::Struct(name) => return golden(schema, name, n),
            Type::Primitive(kind) => *kind,
        };
        *n += 1;
        match kind {
            _ if length => Value::Integer(2),
            Primitive::Float => Value::Float(*n as f32 + 0.5),
            Primitive::Double => Value::Double(*n as f64 + 0.5),
            Primitive::Boolean => Value::Boolean(*n % 2 == 1),
            Primitive::String => Value::Text(format!("s{n}")),
            _ => Value::Integer(*n % 100),
        }
    }
    let members = &schema.get(name).unwrap().members;
    let is_length = |name: &str| {
        let uses = |d: &Dim| matches!(d, Dim::Variable(length) if length == name);
        members.iter().any(|m| m.dims.iter().any(uses))
    };
    Value::Struct(
        members.iter().map(|m| value(schema, m, is_length(&m.name), &m.dims, count)).collect(),
    )
}

#[test]
fn the_files_written_by_python_hold_what_they_should() {
    let schema = Schema::parse(crate::SOURCES).unwrap();
    for structure in &schema.structs {
        let name = structure.full_name();
        let path = format!("{}/golden/{name}.bin", env!("CARGO_MANIFEST_DIR"));
        let bytes = std::fs::read(path).unwrap();
        assert_eq!(recode(&name, &bytes).unwrap(), bytes, "{name}");
        let mut expected = Vec::new();
        let value = golden(&schema, &name, &mut 0);
        schema.encode_into(&name, &value, &mut expected).unwrap();
        if structure.members.last().unwrap().name == "crc" {
            crate::crc::check("golden", &bytes).unwrap(); // zlib's CRC
            expected.truncate(bytes.len() - crate::crc::SIZE);
            assert_eq!(bytes[..expected.len()], expected, "{name}");
        } else {
            assert_eq!(bytes, expected, "{name}");
        }
    }
    let bytes = include_bytes!("../golden/lmpc.vehicle_state_t.bin");
    let state = crate::VehicleState::open(bytes).unwrap();
    assert_eq!((state.h.sender.as_str(), state.valid, state.quality), ("s5", 8, 9));
    assert_eq!((state.x, state.vx, state.wheel_speed[3]), (10.5, 13.5, 22.5));
    assert_eq!((state.cov_diag[0], state.frenet.kappa, state.frenet.lap), (23.5, 32.5, 33));
}
