//! Where a loop finds what arrived since it last looked.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::{Arrival, ReceivedMessage, Sink};

/// A message taken out of an [`Inbox`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Received {
    /// Channel.
    pub channel: String,
    /// The encoded message. Nothing in it has been checked.
    pub payload: Vec<u8>,
    /// When it arrived.
    pub arrival: Arrival,
}

/// A bounded place for messages between the receiving thread and a loop. When it is full the oldest
/// message goes: a slow loop reads the newest state, not the one from half a second ago.
///
/// Copies are handles of the same inbox; subscribe with [`Inbox::sink`].
#[derive(Debug, Clone)]
pub struct Inbox {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    capacity: usize,
    state: Mutex<InboxState>,
    arrived: Condvar,
}

#[derive(Debug, Default)]
struct InboxState {
    urgent: VecDeque<Received>,
    waiting: VecDeque<Received>,
    /// Memory of messages gone by, for the next ones.
    spare: Vec<Received>,
    dropped: u64,
}

impl Inbox {
    /// Holds only the newest message.
    #[must_use]
    pub fn latest() -> Self {
        Self::queue(1)
    }

    /// Holds the newest `capacity` messages, at least one.
    #[must_use]
    pub fn queue(capacity: usize) -> Self {
        let (capacity, state, arrived) = (capacity.max(1), Mutex::default(), Condvar::new());
        Self { shared: Arc::new(Shared { capacity, state, arrived }) }
    }

    /// The end that takes messages in.
    #[must_use]
    pub fn sink(&self) -> Box<dyn Sink> {
        Box::new(Entrance { shared: Arc::clone(&self.shared), urgent: false })
    }

    /// Another end, whose messages come out first. They have as many places of their own: no storm
    /// on the other end makes them give way.
    #[must_use]
    pub fn urgent_sink(&self) -> Box<dyn Sink> {
        Box::new(Entrance { shared: Arc::clone(&self.shared), urgent: true })
    }

    /// The oldest message waiting.
    #[must_use]
    pub fn take(&self) -> Option<Received> {
        self.shared.lock().pop()
    }

    /// The oldest message waiting; waits for one until `deadline`.
    #[must_use]
    pub fn wait_until(&self, deadline: Instant) -> Option<Received> {
        let mut state = self.shared.lock();
        loop {
            if let Some(received) = state.pop() {
                return Some(received);
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return None;
            }
            let woken = self.shared.arrived.wait_timeout(state, left);
            state = woken.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// The oldest message waiting; waits for one at most `time`.
    #[must_use]
    pub fn wait(&self, time: Duration) -> Option<Received> {
        self.wait_until(Instant::now() + time)
    }

    /// Gives a message's memory back, so that the next one need not be allocated.
    pub fn recycle(&self, received: Received) {
        let mut state = self.shared.lock();
        if state.spare.len() < self.shared.capacity {
            state.spare.push(received);
        }
    }

    /// Messages that gave way to newer ones. [-]
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.shared.lock().dropped
    }
}

impl InboxState {
    fn pop(&mut self) -> Option<Received> {
        self.urgent.pop_front().or_else(|| self.waiting.pop_front())
    }
}

impl Shared {
    /// The state; a thread that panicked while holding it left it whole.
    fn lock(&self) -> MutexGuard<'_, InboxState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

struct Entrance {
    shared: Arc<Shared>,
    urgent: bool,
}

impl Sink for Entrance {
    fn deliver(&mut self, message: &ReceivedMessage<'_>) {
        let mut guard = self.shared.lock();
        let InboxState { urgent, waiting, spare, dropped } = &mut *guard;
        let queue = if self.urgent { urgent } else { waiting };
        let oldest = if queue.len() == self.shared.capacity {
            *dropped += 1;
            queue.pop_front()
        } else {
            spare.pop()
        };
        let mut place = oldest.unwrap_or_default();
        place.channel.clear();
        place.channel.push_str(message.channel);
        place.payload.clear();
        place.payload.extend_from_slice(message.payload);
        place.arrival = message.arrival;
        queue.push_back(place);
        drop(guard);
        self.shared.arrived.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn send(inbox: &Inbox, numbers: std::ops::Range<u8>) {
        let mut sink = inbox.sink();
        for number in numbers {
            let arrival = Arrival { utime: number.into(), ..Arrival::default() };
            sink.deliver(&ReceivedMessage {
                channel: "A",
                payload: &[number],
                arrival,
                sender: None,
            });
        }
    }

    #[test]
    fn a_slow_loop_reads_the_newest() {
        let inbox = Inbox::latest();
        send(&inbox, 0..100);
        let newest = inbox.take().unwrap();
        assert_eq!((newest.payload[0], newest.arrival.utime), (99, 99));
        assert_eq!((inbox.take(), inbox.dropped()), (None, 99));
    }

    #[test]
    fn a_queue_keeps_the_newest_in_order() {
        let inbox = Inbox::queue(3);
        send(&inbox, 0..5);
        let numbers: Vec<u8> = std::iter::from_fn(|| inbox.take()).map(|r| r.payload[0]).collect();
        assert_eq!((numbers, inbox.dropped()), (vec![2, 3, 4], 2));
    }

    #[test]
    fn what_is_urgent_comes_first_and_does_not_give_way() {
        let inbox = Inbox::queue(3);
        let arrival = Arrival::default();
        let message = ReceivedMessage { channel: "B", payload: &[99], arrival, sender: None };
        inbox.urgent_sink().deliver(&message);
        send(&inbox, 0..100);
        let numbers: Vec<u8> = std::iter::from_fn(|| inbox.take()).map(|r| r.payload[0]).collect();
        assert_eq!((numbers, inbox.dropped()), (vec![99, 97, 98, 99], 97));
    }

    #[test]
    fn waiting_ends_with_a_message_or_with_the_deadline() {
        let inbox = Inbox::latest();
        assert_eq!(inbox.wait(Duration::from_millis(1)), None);
        let sender = inbox.clone();
        let thread = std::thread::spawn(move || send(&sender, 7..8));
        assert_eq!(inbox.wait(Duration::from_secs(60)).unwrap().payload, [7]);
        thread.join().unwrap();
    }
}
