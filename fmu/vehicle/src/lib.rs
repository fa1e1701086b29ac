//! The vehicle FMU's shared library: `fmu_core::VehicleFmu` under the C names of FMI 2.0 and 3.0.

use fmu_core::VehicleFmu;

fmu_core::export_fmu!(VehicleFmu);
