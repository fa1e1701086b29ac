//! The messages of both ends of a network, and the rules by which either end accepts them.
//!
//! [`convert`] and [`telemetry`] alone know how messages and the controller's types correspond;
//! [`publisher`] stamps what is sent, [`stream_filter`] and [`operator_inbox`] check what arrives.

pub mod convert;
pub mod operator_inbox;
pub mod publisher;
pub mod stream_filter;
pub mod telemetry;
