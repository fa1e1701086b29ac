//! A snapshot of the whole network as lines at a terminal. What is heard is kept by `network_watch`.

#[cfg(test)]
mod tests;
mod view;

pub use view::draw;
