//! The page's side: requests from a browser on this computer, and what they may do.

mod files;
mod guard;
mod orders;
mod request;
mod server;
mod stream;

pub use orders::{Give, OrderRequest, Orders};
pub use server::{Server, ServerOptions};
