//! Learning model predictive control with error dynamics regression for autonomous racing
//! (Xue, Zhu, Dolan, Borrelli 2023).
#![forbid(unsafe_code)]
