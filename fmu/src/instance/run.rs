//! Life of an instance: initialise, step, terminate, reset.

use super::{Instance, Phase, check_outputs};
use crate::model::{CommunicationStep, FmuModel, Io};
use crate::status::CallError;
use crate::values::VariableValues;

/// Two times are the same if they differ by less than this, relative to the larger of one second
/// and the time itself: hosts add up steps in floating point, some in single precision.
const TIME_TOLERANCE: f64 = f32::EPSILON as f64;

fn tolerance(time: f64) -> f64 {
    TIME_TOLERANCE * time.abs().max(1.0)
}

impl<M: FmuModel> Instance<M> {
    /// Takes start and stop time.
    pub(crate) fn set_times(
        &mut self,
        function: &str,
        start: f64,
        stop: Option<f64>,
    ) -> Result<(), CallError> {
        self.allow(function, &[Phase::Instantiated])?;
        if !start.is_finite() {
            return Err(CallError::Refused(format!(
                "{function}: start time {start} is not finite"
            )));
        }
        if let Some(stop) = stop
            && (stop.is_nan() || stop < start)
        {
            return Err(CallError::Refused(format!(
                "{function}: stop time {stop} lies before start time {start}"
            )));
        }
        (self.core.origin, self.core.time, self.core.stop) = (start, start, stop);
        Ok(())
    }

    pub(crate) fn enter_initialization(&mut self, function: &str) -> Result<(), CallError> {
        self.allow(function, &[Phase::Instantiated])?;
        self.core.phase = Phase::Initialization;
        Ok(())
    }

    pub(crate) fn exit_initialization(&mut self, function: &str) -> Result<(), CallError> {
        self.allow(function, &[Phase::Initialization])?;
        self.ensure_model()?;
        if let Some(model) = self.model.as_mut() {
            model.in_force(&mut self.core.values);
        }
        self.core.phase = Phase::Stepping;
        Ok(())
    }

    pub(crate) fn terminate(&mut self, function: &str) -> Result<(), CallError> {
        self.allow(function, &[Phase::Stepping])?;
        self.core.phase = Phase::Terminated;
        let Some(model) = self.model.as_mut() else { return Ok(()) };
        let mut io = Io {
            values: &mut self.core.values,
            resources: self.resources.as_deref(),
            log: &mut self.log,
        };
        Self::guarded(function, || {
            model.end(&mut io);
            Ok(())
        })
    }

    pub(crate) fn reset(&mut self, function: &str) -> Result<(), CallError> {
        self.allow(function, &Phase::ALL[..5])?;
        self.core.phase = Phase::Instantiated;
        (self.core.origin, self.core.time, self.core.stop) = (0.0, 0.0, None);
        self.core.values = VariableValues::start(&M::description().table);
        self.model = None;
        Ok(())
    }

    /// One communication step.
    pub(crate) fn do_step(
        &mut self,
        function: &str,
        begin: f64,
        size: f64,
    ) -> Result<(), CallError> {
        self.allow(function, &[Phase::Stepping])?;
        self.check_step(function, begin, size)?;
        self.backup.clone_from(&self.core.values.numbers);
        let Some(model) = self.model.as_mut() else {
            return Err(CallError::Fatal(format!("{function}: stepping without a model")));
        };
        let mut io = Io {
            values: &mut self.core.values,
            resources: self.resources.as_deref(),
            log: &mut self.log,
        };
        let step = CommunicationStep { origin: self.core.origin, begin, size };
        let done = Self::guarded(function, || model.step(&mut io, &step))
            .and_then(|()| check_outputs::<M>(&self.core.values));
        if done.is_ok() {
            self.core.time = step.end();
        } else {
            self.core.values.numbers.clone_from(&self.backup);
        }
        done
    }

    fn check_step(&self, function: &str, begin: f64, size: f64) -> Result<(), CallError> {
        let time = self.core.time;
        if !(size > 0.0 && size.is_finite()) {
            return Err(CallError::Refused(format!(
                "{function}: step size {size} s; it must be positive and finite"
            )));
        }
        if begin.is_nan() || (begin - time).abs() > tolerance(time) {
            return Err(CallError::Refused(format!(
                "{function}: communication point {begin} s, but the instance is at {time} s"
            )));
        }
        if begin + size <= begin {
            return Err(CallError::Refused(format!(
                "{function}: step size {size} s vanishes beside the time {begin} s"
            )));
        }
        match self.core.stop {
            Some(stop) if begin + size > stop + tolerance(stop) => Err(CallError::Refused(
                format!("{function}: the step to {} s passes the stop time {stop} s", begin + size),
            )),
            _ => Ok(()),
        }
    }
}
