//! The vehicle's variables with nothing behind them, as a shared library. Never shipped.

mod hollow;

use fmu_core::VehicleFmu;
use hollow::Hollow;

fmu_core::export_fmu!(Hollow<VehicleFmu>);
