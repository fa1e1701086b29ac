//! A network within one process: what is published is handed to every subscriber at once.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::{Error, Filter, ReceivedMessage, Sink, Statistics, Transport};

/// A network without a wire. Sinks are called on the thread that publishes: one that publishes itself
/// would wait for itself, so sinks put messages in an [`Inbox`](super::Inbox) or only look at them.
#[derive(Default)]
pub struct Local {
    sinks: Mutex<Vec<(Filter, Box<dyn Sink>)>>,
}

impl Local {
    fn sinks(&self) -> MutexGuard<'_, Vec<(Filter, Box<dyn Sink>)>> {
        self.sinks.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Transport for Local {
    fn publish(&self, channel: &str, payload: &[u8]) -> Result<(), Error> {
        super::check_channel(channel)?;
        super::check_size(payload)?;
        let message = ReceivedMessage { channel, payload, arrival: super::now(), sender: None };
        for (filter, sink) in self.sinks().iter_mut() {
            if filter.accepts(channel) {
                sink.deliver(&message);
            }
        }
        Ok(())
    }

    fn subscribe(&self, filter: Filter, sink: Box<dyn Sink>) -> Result<(), Error> {
        super::check_filter(&filter)?;
        self.sinks().push((filter, sink));
        Ok(())
    }

    /// Nothing is lost on no wire: all counts are 0.
    fn statistics(&self) -> Statistics {
        Statistics::default()
    }

    fn warnings(&self) -> &[String] {
        &[]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Inbox;

    #[test]
    fn each_subscriber_gets_the_channels_it_asked_for() {
        let network = Local::default();
        let (all, one) = (Inbox::queue(8), Inbox::queue(8));
        network.subscribe(Filter::All, all.sink()).unwrap();
        network.subscribe(Filter::channel("B"), one.sink()).unwrap();
        for channel in ["A", "B", "C"] {
            network.publish(channel, channel.as_bytes()).unwrap();
        }
        assert!(network.publish("no channel", b"").is_err());
        let taken = |inbox: &Inbox| -> Vec<String> {
            std::iter::from_fn(|| inbox.take()).map(|received| received.channel).collect()
        };
        assert_eq!(taken(&all), ["A", "B", "C"]);
        assert_eq!(taken(&one), ["B"]);
    }
}
