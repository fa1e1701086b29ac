//! Nothing: this package has tests alone, so that they run without building the crates they look at.
