//! A page that shows a drive as it happens, served on this computer.
//!
//! Messages go into a [`View`], which keeps what a page needs: laps as traces along the track, recent
//! step times, and what [`network_watch`] knows. A [`Server`] hands out the page, which is part of the
//! program, and a stream of server-sent events to each page that is open. Nothing is queued: a page
//! that is slow gets the newest state next, and every trace in full after it comes back.

mod frame;
mod http;
mod lap;
mod laps;
mod model;
mod reference;
mod view;
mod world;

pub use http::{Give, OrderRequest, Orders, Server, ServerOptions};
pub use reference::{Reference, Resolve, Wanted};
pub use view::{Clock, View};
