//! Messages to those who asked for them, on the receiving thread.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, channel};

use super::{Error, Filter, ReceivedMessage};

/// Takes messages on the receiving thread: copies what it needs and returns at once.
pub trait Sink: Send {
    /// Takes one message.
    fn deliver(&mut self, message: &ReceivedMessage<'_>);
}

impl<F: FnMut(&ReceivedMessage<'_>) + Send> Sink for F {
    fn deliver(&mut self, message: &ReceivedMessage<'_>) {
        self(message);
    }
}

/// The end of the dispatcher that hands in new subscriptions, from any thread.
#[derive(Clone)]
pub(super) struct Subscriber(Sender<(Filter, Box<dyn Sink>)>);

impl Subscriber {
    pub(super) fn add(&self, filter: Filter, sink: Box<dyn Sink>) -> Result<(), Error> {
        self.0.send((filter, sink)).map_err(|_| Error::Closed)
    }
}

/// All subscriptions, owned by the receiving thread.
pub(super) struct Dispatcher {
    incoming: Receiver<(Filter, Box<dyn Sink>)>,
    sinks: Vec<(Filter, Box<dyn Sink>)>,
    panics: u64,
}

impl Dispatcher {
    pub(super) fn new() -> (Self, Subscriber) {
        let (sender, incoming) = channel();
        (Self { incoming, sinks: Vec::new(), panics: 0 }, Subscriber(sender))
    }

    /// Hands `message` to every sink that asked for its channel. A sink that panics is taken out:
    /// the thread, and with it every other subscription, lives on.
    pub(super) fn deliver(&mut self, message: &ReceivedMessage<'_>) {
        self.sinks.extend(self.incoming.try_iter());
        let before = self.sinks.len();
        self.sinks.retain_mut(|(filter, sink)| {
            !filter.accepts(message.channel)
                || catch_unwind(AssertUnwindSafe(|| sink.deliver(message))).is_ok()
        });
        self.panics += (before - self.sinks.len()) as u64;
    }

    /// Sinks that panicked. [-]
    pub(super) fn panics(&self) -> u64 {
        self.panics
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::Arrival;

    #[test]
    fn a_sink_that_panics_is_taken_out_and_the_others_go_on() {
        let (mut dispatcher, subscriber) = Dispatcher::new();
        let count = Arc::new(AtomicUsize::new(0));
        let counted = Arc::clone(&count);
        let counting = move |_: &ReceivedMessage<'_>| {
            counted.fetch_add(1, Ordering::Relaxed);
        };
        let broken = |_: &ReceivedMessage<'_>| panic!("a sink with a fault");
        subscriber.add(Filter::channel("A"), Box::new(broken)).unwrap();
        subscriber.add(Filter::channel("A"), Box::new(counting)).unwrap();
        for channel in ["A", "B", "A"] {
            let arrival = Arrival::default();
            dispatcher.deliver(&ReceivedMessage { channel, payload: &[], arrival, sender: None });
        }
        assert_eq!(count.load(Ordering::Relaxed), 2);
        assert_eq!((dispatcher.panics(), dispatcher.sinks.len()), (1, 1));
        drop(dispatcher);
        let late = subscriber.add(Filter::All, Box::new(|_: &ReceivedMessage<'_>| {}));
        assert!(matches!(late, Err(Error::Closed)));
    }
}
