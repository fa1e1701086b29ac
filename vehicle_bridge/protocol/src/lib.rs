//! The messages of both ends of a network, and the rules by which either end accepts them.
//!
//! [`convert`] and [`telemetry`] alone know how messages and the controller's types correspond;
//! [`outlet`] stamps what is sent, [`guard`] and [`orders`] check what arrives.

pub mod convert;
pub mod guard;
pub mod orders;
pub mod outlet;
pub mod telemetry;
