//! A model with all variables of another and nothing behind them: what a host spends on the
//! variables alone. For measuring; never shipped.

use std::marker::PhantomData;

use fmu_core::{Description, Fault, Io, Model, Step};

/// The variables of `M`, at their start values for ever.
pub(crate) struct Hollow<M>(PhantomData<fn() -> M>);

impl<M: Model> Model for Hollow<M> {
    type State = ();

    fn description() -> &'static Description {
        M::description()
    }

    fn start(_: &mut Io<'_>) -> Result<Self, Fault> {
        Ok(Self(PhantomData))
    }

    fn step(&mut self, _: &mut Io<'_>, _: &Step) -> Result<(), Fault> {
        Ok(())
    }

    fn state(&self) {}

    fn resume(&mut self, (): &()) -> Result<(), Fault> {
        Ok(())
    }

    fn save((): &()) -> Result<Vec<u8>, Fault> {
        Ok(Vec::new())
    }

    fn load(_: &[u8]) -> Result<(), Fault> {
        Ok(())
    }
}
