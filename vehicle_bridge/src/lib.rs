//! Hosts of the racing LMPC.
