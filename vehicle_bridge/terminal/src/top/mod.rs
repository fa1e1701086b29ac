//! A snapshot of the whole network as lines at a terminal. `network_watch` keeps what arrives.

#[cfg(test)]
mod tests;
mod view;

pub use view::draw;
