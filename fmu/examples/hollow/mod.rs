//! A model with all variables of another and nothing behind them: what a host spends on the
//! variables alone. For measuring; never shipped.

use std::marker::PhantomData;

use fmu_core::{CallError, CommunicationStep, Description, FmuModel, Io};

/// The variables of `M`, at their start values for ever.
pub(crate) struct Hollow<M>(PhantomData<fn() -> M>);

impl<M: FmuModel> FmuModel for Hollow<M> {
    type State = ();

    fn description() -> &'static Description {
        M::description()
    }

    fn start(_: &mut Io<'_>) -> Result<Self, CallError> {
        Ok(Self(PhantomData))
    }

    fn step(&mut self, _: &mut Io<'_>, _: &CommunicationStep) -> Result<(), CallError> {
        Ok(())
    }

    fn state(&self) {}

    fn resume(&mut self, (): &()) -> Result<(), CallError> {
        Ok(())
    }

    fn save((): &()) -> Result<Vec<u8>, CallError> {
        Ok(Vec::new())
    }

    fn load(_: &[u8]) -> Result<(), CallError> {
        Ok(())
    }
}
