//! Hosts of the racing LMPC.

pub mod transport;
