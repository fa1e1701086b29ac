//! The last complaint of an FMU, which the `fmi` crate passes to the `log` facade.

use std::cell::RefCell;

thread_local! {
    static LAST: RefCell<Option<String>> = const { RefCell::new(None) };
}

struct Ear;

impl log::Log for Ear {
    fn enabled(&self, _: &log::Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &log::Record<'_>) {
        if record.level() <= log::Level::Warn {
            LAST.with(|last| *last.borrow_mut() = Some(record.args().to_string()));
        }
    }

    fn flush(&self) {}
}

/// From now on, complaints are kept; another logger of the process keeps its place.
pub(super) fn listen() {
    let _ = log::set_logger(&Ear);
}

/// The last complaint on this thread, once.
pub(super) fn take() -> Option<String> {
    LAST.with(|last| last.borrow_mut().take())
}
