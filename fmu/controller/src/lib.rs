//! The controller FMU's shared library: `fmu_core::ControllerFmu` under the C names of FMI 2.0
//! and 3.0.

use fmu_core::ControllerFmu;

fmu_core::export_fmu!(ControllerFmu);
