//! A small model with one variable of every kind, an internal period, and a switch for every
//! way to fail. For tests; never shipped.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::sync::{Arc, OnceLock};

use fmu_core::{
    Boolean, ByteReader, ByteWriter, CallError, CommunicationStep, Description, FmuModel, Integer,
    Io, Real, Role, Terminal, Text, TickSchedule, Variable, VariableTable, unit,
};

/// Internal period [s].
pub(crate) const PERIOD: f64 = 0.1;

/// Integrates its input, sampled at its period, and remembers every sample.
#[derive(Clone, Debug)]
pub(crate) struct Probe {
    schedule: TickSchedule,
    x: f64,
    samples: Arc<Vec<f64>>,
}

struct Slots {
    u: Real,
    gain: Real,
    x0: Real,
    fail: Integer,
    quiet: Boolean,
    greeting: Text,
    x: Real,
    count: Real,
}

fn description() -> &'static (Description, Slots) {
    static CELL: OnceLock<(Description, Slots)> = OnceLock::new();
    CELL.get_or_init(|| {
        let mut t = VariableTable::new();
        let slots = Slots {
            u: t.real(
                "u",
                Role::Input,
                unit::M_PER_S,
                "Speed to integrate, \"x' = gain u\" & <so>",
            ),
            gain: t.add_real(
                Variable::real("param.gain", Role::Tunable, unit::ONE, "Factor on the input")
                    .start(1.0)
                    .range(-10.0, 10.0),
            ),
            x0: t.real("param.x0", Role::Fixed, unit::M, "Position at the start"),
            fail: t.add_integer(
                Variable::integer(
                    "param.fail",
                    Role::Tunable,
                    "0 no, 1 warn, 2 fail, 3 panic, 4 NaN",
                )
                .range(0.0, 4.0),
            ),
            quiet: t.add_boolean(
                Variable::boolean("param.quiet", Role::Tunable, "Do not log events").start(1.0),
            ),
            greeting: t.add_text(Variable::text("param.greeting", Role::Fixed, "", "Any text")),
            x: t.add_real(Variable::real("x", Role::Discrete, unit::M, "Position").nominal(1.0)),
            count: t.real("count", Role::Discrete, unit::ONE, "Samples taken"),
        };
        let description = Description {
            model_name: "Probe",
            model_identifier: "probe",
            description: "Test model",
            version: "1",
            stop_time: 1.0,
            step_size: PERIOD,
            table: t,
            terminals: vec![Terminal {
                name: "speed",
                description: "Where the speed comes from",
                members: vec![("v", "u".to_owned())],
            }],
            resources: Vec::new(),
            documentation: "<!doctype html><title>Probe</title><p>Test model.</p>",
            icon: &[],
            token: OnceLock::new(),
        };
        (description, slots)
    })
}

impl Probe {
    fn publish(&self, io: &mut Io<'_>) {
        let slots = &description().1;
        io.values.set_real(slots.x, self.x);
        io.values.set_real(slots.count, self.samples.len() as f64);
    }
}

impl FmuModel for Probe {
    type State = Self;

    fn description() -> &'static Description {
        &description().0
    }

    fn start(io: &mut Io<'_>) -> Result<Self, CallError> {
        let slots = &description().1;
        if io.values.text(slots.greeting) == "fail" {
            return Err(CallError::Failed("param.greeting says 'fail'".to_owned()));
        }
        let schedule = TickSchedule::new(PERIOD).ok_or(CallError::Failed("period".to_owned()))?;
        let probe = Self { schedule, x: io.values.real(slots.x0), samples: Arc::default() };
        probe.publish(io);
        Ok(probe)
    }

    fn step(&mut self, io: &mut Io<'_>, step: &CommunicationStep) -> Result<(), CallError> {
        let slots = &description().1;
        if self.schedule.too_long(step.size) {
            return Err(CallError::Discard(format!("step {} s, period {PERIOD} s", step.size)));
        }
        // Spoil an output first: a failure must not let it out.
        io.values.set_real(slots.x, -1.0);
        match io.values.integer(slots.fail) {
            0 => {}
            1 => io.log.warn("100 % warned, as asked: %s %n"),
            2 => return Err(CallError::Failed("failed, as asked".to_owned())),
            3 => panic!("panicked, as asked"),
            _ => io.values.set_real(slots.count, f64::NAN),
        }
        if !io.values.boolean(slots.quiet) {
            io.log.event(format!("step to {} s", step.end()));
        }
        if io.values.integer(slots.fail) == 4 {
            return Ok(());
        }
        if self.schedule.due_before(step.end() - step.origin, step.size) {
            let u = io.values.real(slots.u);
            self.x += PERIOD * io.values.real(slots.gain) * u;
            Arc::make_mut(&mut self.samples).push(u);
        }
        self.publish(io);
        Ok(())
    }

    fn state(&self) -> Self {
        self.clone()
    }

    fn resume(&mut self, state: &Self) -> Result<(), CallError> {
        self.clone_from(state);
        Ok(())
    }

    fn save(state: &Self) -> Result<Vec<u8>, CallError> {
        let mut writer = ByteWriter::default();
        writer.u64(state.schedule.count() as u64);
        writer.f64(state.x);
        writer.f64s(&state.samples);
        Ok(writer.finish())
    }

    fn load(bytes: &[u8]) -> Result<Self, CallError> {
        let mut reader = ByteReader::new(bytes);
        let mut read = || {
            let schedule = TickSchedule::resumed(PERIOD, i64::try_from(reader.u64()?).ok()?)?;
            let (x, samples) = (reader.f64()?, Arc::new(reader.f64s()?));
            reader.is_empty().then_some(Self { schedule, x, samples })
        };
        read().ok_or(CallError::Refused("not a saved probe".to_owned()))
    }
}
