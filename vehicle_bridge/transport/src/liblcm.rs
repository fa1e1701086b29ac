//! Every other LCM provider, through the `lcm` crate's bindings to the C library.
//!
//! The crate's typed interface aborts the process on a wrong string length, and its handles can be
//! used after they are freed. This wrapper is the one place that touches it: raw bytes only, one
//! thread that owns the connection, names checked before they become C strings and patterns,
//! callbacks that copy into a bounded ring and cannot unwind into C, and no handle kept.
//!
//! What it cannot mend is liblcm itself: a datagram with an unterminated channel kills the process
//! (`udpm`), and a queue of 30 messages drops the newest. Use it for the providers that exist
//! nowhere else, on networks where every sender is known.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::process::CommandExt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::Command;
use std::rc::Rc;
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use lcm::Lcm;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sys::eventfd::EventFd;

use super::dispatch::{Dispatcher, Subscriber};
use super::{
    Arrival, Error, Filter, MAX_MESSAGE, ReceivedMessage, Sink, Statistics, ThreadStart, Transport,
    Url, check_channel, check_filter, check_size, now,
};

/// The one place liblcm takes a URL from, as the crate calls it.
const VARIABLE: &str = "LCM_DEFAULT_URL";
/// Messages waiting to be sent. [-]
const SEND_QUEUE: usize = 256;
/// Messages between liblcm's callback and the sinks. [-]
const RING: usize = 256;

/// A connection through liblcm.
pub struct Liblcm {
    orders: SyncSender<Order>,
    wake: Arc<EventFd>,
    subscriber: Subscriber,
    statistics: Arc<Mutex<Statistics>>,
    thread: Option<JoinHandle<()>>,
}

enum Order {
    Publish(String, Raw),
    Subscribe(Vec<String>, SyncSender<()>),
    Stop,
}

/// Starts this program again with `url` in the environment, if liblcm needs it there and it is not;
/// call it first thing in `main`, when there are no threads. Returns if nothing was to be done.
///
/// # Errors
/// [`Error::Url`], and [`Error::Socket`] if the program cannot be started again.
pub fn enter_environment(url: &str) -> Result<(), Error> {
    let url = Url::parse(url)?;
    if url.is_udpm() || std::env::var(VARIABLE).is_ok_and(|found| found == url.for_liblcm()) {
        return Ok(());
    }
    let failed = |source| Error::Socket {
        step: "starting the program again",
        target: url.to_string(),
        source,
        hint: "",
    };
    let program = std::env::current_exe().map_err(failed)?;
    let arguments = std::env::args_os().skip(1);
    Err(failed(Command::new(program).args(arguments).env(VARIABLE, url.for_liblcm()).exec()))
}

/// Whether liblcm is on this computer: loads it, if that was not done yet.
///
/// # Errors
/// What the system says if it cannot be loaded.
pub fn available() -> io::Result<()> {
    super::liblcm_loaded::load()
}

impl Liblcm {
    /// Connects as `url` says, which must also be in the environment: see [`enter_environment`].
    ///
    /// # Errors
    /// [`Error::Environment`]; [`Error::Socket`] if liblcm gives no connection (it prints why).
    pub fn open(url: &Url, start: Option<ThreadStart>) -> Result<Self, Error> {
        let found = std::env::var(VARIABLE).unwrap_or_default();
        if found != url.for_liblcm() {
            return Err(Error::Environment { found, expected: url.for_liblcm().to_owned() });
        }
        let failed = |source| Error::Socket {
            step: "connecting through liblcm",
            target: url.to_string(),
            source,
            hint: "",
        };
        available().map_err(|source| Error::Socket {
            step: "loading liblcm",
            target: url.to_string(),
            source,
            hint: "; apt-get install liblcm1",
        })?;
        let wake = Arc::new(EventFd::new().map_err(|e| failed(e.into()))?);
        let (orders, incoming) = sync_channel(SEND_QUEUE);
        let (dispatcher, subscriber) = Dispatcher::new();
        let statistics: Arc<Mutex<Statistics>> = Arc::default();
        let (ready, connected) = sync_channel(1);
        let (thread_wake, thread_statistics) = (Arc::clone(&wake), Arc::clone(&statistics));
        let thread = Builder::new().name("lcm-liblcm".to_owned()).spawn(move || {
            if let Some(start) = start {
                start();
            }
            // `Lcm` belongs to the thread that made it.
            let connection = match Lcm::new() {
                Ok(lcm) => lcm,
                Err(error) => {
                    let _ = ready.send(Err(error));
                    return;
                }
            };
            if ready.send(Ok(())).is_ok() {
                let ring = Rc::default();
                let statistics = thread_statistics;
                let (wake, subscribed) = (thread_wake, Vec::new());
                Owner { connection, ring, incoming, wake, dispatcher, statistics, subscribed }
                    .run();
            }
        });
        let thread = Some(thread.map_err(failed)?);
        match connected.recv() {
            Ok(Ok(())) => Ok(Self { orders, wake, subscriber, statistics, thread }),
            Ok(Err(error)) => Err(failed(error)),
            Err(_) => Err(Error::Closed),
        }
    }

    fn order(&self, order: Order) -> Result<(), Error> {
        self.orders.send(order).map_err(|_| Error::Closed)?;
        self.wake()
    }

    fn wake(&self) -> Result<(), Error> {
        self.wake.write(1).map(|_| ()).map_err(|_| Error::Closed)
    }
}

impl Transport for Liblcm {
    /// Queues the message for the owning thread; what liblcm then says is counted in
    /// [`Statistics::send_errors`].
    fn publish(&self, channel: &str, payload: &[u8]) -> Result<(), Error> {
        check_channel(channel)?;
        check_size(payload)?;
        let order = Order::Publish(channel.to_owned(), Raw(payload.to_vec()));
        if self.orders.try_send(order).is_err() {
            lock(&self.statistics).send_errors += 1;
            let source = io::Error::new(io::ErrorKind::WouldBlock, "the send queue is full");
            return Err(Error::Send { channel: channel.to_owned(), source });
        }
        self.wake()
    }

    fn subscribe(&self, filter: Filter, sink: Box<dyn Sink>) -> Result<(), Error> {
        check_filter(&filter)?;
        let Filter::Only(names) = &filter else {
            let what = "all channels at once through liblcm: the `lcm` crate does not say which \
                        channel a message is from; name the channels";
            return Err(Error::Unsupported { what: what.to_owned() });
        };
        let names = names.clone();
        self.subscriber.add(filter, sink)?;
        let (done, subscribed) = sync_channel(1);
        self.order(Order::Subscribe(names, done))?;
        subscribed.recv().map_err(|_| Error::Closed)
    }

    fn statistics(&self) -> Statistics {
        lock(&self.statistics).clone()
    }

    fn warnings(&self) -> &[String] {
        &[]
    }
}

impl Drop for Liblcm {
    fn drop(&mut self) {
        // If the thread is gone already there is nothing to stop.
        let _ = self.order(Order::Stop);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn lock(statistics: &Mutex<Statistics>) -> MutexGuard<'_, Statistics> {
    statistics.lock().unwrap_or_else(PoisonError::into_inner)
}

type Ring = Rc<RefCell<VecDeque<(Rc<str>, Vec<u8>, Arrival)>>>;

/// What the owning thread holds.
struct Owner {
    connection: Lcm,
    ring: Ring,
    incoming: Receiver<Order>,
    wake: Arc<EventFd>,
    dispatcher: Dispatcher,
    statistics: Arc<Mutex<Statistics>>,
    subscribed: Vec<String>,
}

impl Owner {
    fn run(mut self) {
        loop {
            match self.wait() {
                Ok((false, false)) => {}
                Ok((message, order)) => {
                    // `handle` takes one message and would wait for one if there were none.
                    if message && self.connection.handle().is_err() {
                        self.pause();
                    }
                    self.deliver();
                    if order && !self.follow_orders() {
                        return;
                    }
                }
                Err(_) => self.pause(),
            }
        }
    }

    /// Waits for a message or an order: which of them there is.
    fn wait(&self) -> nix::Result<(bool, bool)> {
        // SAFETY: the descriptor belongs to `self.connection`, which lives longer than this borrow
        // and does not close it while it lives.
        #[allow(unsafe_code, reason = "the crate gives a bare number")]
        let connection = unsafe { BorrowedFd::borrow_raw(self.connection.get_fileno()) };
        let mut descriptors = [
            PollFd::new(connection, PollFlags::POLLIN),
            PollFd::new(self.wake.as_fd(), PollFlags::POLLIN),
        ];
        match poll(&mut descriptors, PollTimeout::NONE) {
            Ok(_) => {}
            Err(nix::errno::Errno::EINTR) => return Ok((false, false)),
            Err(error) => return Err(error),
        }
        let ready = |d: &PollFd<'_>| d.any().unwrap_or(false);
        let [message, order] = &descriptors;
        if ready(order) {
            self.wake.read()?; // back to zero
        }
        Ok((ready(message), ready(order)))
    }

    /// After an error: counted, and no busy loop.
    fn pause(&self) {
        lock(&self.statistics).receive_errors += 1;
        std::thread::sleep(Duration::from_millis(50));
    }

    /// Hands on what the callbacks left in the ring.
    fn deliver(&mut self) {
        loop {
            let Some((channel, payload, arrival)) = self.ring.borrow_mut().pop_front() else {
                return;
            };
            let mut statistics = lock(&self.statistics);
            statistics.received += 1;
            statistics.bytes += payload.len() as u64;
            drop(statistics);
            let message =
                ReceivedMessage { channel: &channel, payload: &payload, arrival, sender: None };
            self.dispatcher.deliver(&message);
            if self.dispatcher.panics() > 0 {
                lock(&self.statistics).sink_panics = self.dispatcher.panics();
            }
        }
    }

    /// Does what was asked for from outside; false when it is time to end.
    fn follow_orders(&mut self) -> bool {
        loop {
            match self.incoming.try_recv() {
                Ok(Order::Publish(channel, payload)) => {
                    let sent = self.connection.publish(&channel, &payload).is_ok();
                    let mut statistics = lock(&self.statistics);
                    statistics.sent += u64::from(sent);
                    statistics.send_errors += u64::from(!sent);
                }
                Ok(Order::Subscribe(names, done)) => {
                    for name in names {
                        self.subscribe(name);
                    }
                    let _ = done.send(());
                }
                Err(TryRecvError::Empty) => return true,
                Ok(Order::Stop) | Err(TryRecvError::Disconnected) => return false,
            }
        }
    }

    fn subscribe(&mut self, name: String) {
        if self.subscribed.contains(&name) {
            return; // the dispatcher hands one message to every sink
        }
        let (ring, channel) = (Rc::clone(&self.ring), Rc::<str>::from(name.as_str()));
        // The handle this returns is dropped: used after its connection it would be freed memory.
        let _ = self.connection.subscribe(&pattern(&name), move |raw: Raw| {
            // Unwinding out of here would be out of C: the process would abort.
            let _ = catch_unwind(AssertUnwindSafe(|| {
                let mut ring = ring.borrow_mut();
                if ring.len() == RING {
                    ring.pop_front();
                }
                ring.push_back((Rc::clone(&channel), raw.0, now()));
            }));
        });
        self.subscribed.push(name);
    }
}

/// liblcm takes channel names for regular expressions.
fn pattern(name: &str) -> String {
    let mut pattern = String::new();
    for c in name.chars() {
        if "\\^$.[]|()?*+{}".contains(c) {
            pattern.push('\\');
        }
        pattern.push(c);
    }
    pattern
}

/// Bytes as they are: the crate's own types never touch the network.
struct Raw(Vec<u8>);

impl lcm::Message for Raw {
    fn encode_with_hash(&self) -> io::Result<Vec<u8>> {
        Ok(self.0.clone())
    }

    fn decode_with_hash(buffer: &mut dyn Read) -> io::Result<Self> {
        Self::decode(buffer)
    }

    fn encode(&self, buffer: &mut dyn Write) -> io::Result<()> {
        buffer.write_all(&self.0)
    }

    fn decode(buffer: &mut dyn Read) -> io::Result<Self> {
        let read = catch_unwind(AssertUnwindSafe(|| {
            let mut bytes = Vec::new();
            buffer.take(MAX_MESSAGE as u64 + 1).read_to_end(&mut bytes).map(|_| bytes)
        }));
        match read {
            Ok(Ok(bytes)) if bytes.len() <= MAX_MESSAGE => Ok(Self(bytes)),
            Ok(Err(error)) => Err(error),
            _ => Err(io::Error::from(io::ErrorKind::InvalidData)),
        }
    }

    fn size(&self) -> usize {
        self.0.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_no_patterns() {
        assert_eq!(pattern("CAR/STATE_1-a"), "CAR/STATE_1-a");
        assert_eq!(pattern("A.*[b]"), "A\\.\\*\\[b\\]");
    }

    #[test]
    fn another_url_than_the_environment_s_is_refused() {
        let url = Url::parse("memq://nowhere").unwrap();
        assert!(matches!(Liblcm::open(&url, None), Err(Error::Environment { .. })));
    }
}
