//! `udpm://`: LCM over UDP multicast, against whatever may arrive.

use std::io::{self, IoSlice, IoSliceMut};
use std::net::{Ipv4Addr, Shutdown, SocketAddrV4};
use std::os::fd::AsRawFd;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use nix::sys::socket::{ControlMessageOwned, MsgFlags, SockaddrIn, recvmsg, setsockopt, sockopt};
use socket2::{Domain, Protocol, Socket, Type};

use super::datagram::{self, Datagram, Fragment};
use super::dispatch::{Dispatcher, Subscriber};
use super::reassembly::{Outcome, Reassembly};
use super::{
    Arrival, Error, Filter, ReceivedMessage, Sink, Statistics, ThreadStart, Transport, UdpmOptions,
    check_channel, check_filter, check_size, now,
};

/// liblcm's test of its own route; not a message.
const SELF_TEST: &str = "LCM_SELF_TEST";
/// How often the receiving thread looks whether a message in pieces has expired, and how long it
/// rests after an error.
const POLL: Duration = Duration::from_millis(50);
/// A sender waits this long for room in the kernel's send buffer.
const SEND_TIMEOUT: Duration = Duration::from_millis(10);
/// The largest UDP datagram. \[B\]
const MAX_DATAGRAM: usize = 65_535;
const ROUTE_HINT: &str = " (no route for multicast? `ip route add 224.0.0.0/4 dev lo`)";

/// A connection to a multicast group. From the first subscription on it receives in a thread of its
/// own; a program that only sends is not woken by its own messages.
pub struct Udpm {
    options: UdpmOptions,
    sender: Socket,
    sequence: AtomicU32,
    subscriber: Subscriber,
    statistics: Arc<Mutex<Statistics>>,
    stop: Arc<AtomicBool>,
    /// The receiving thread's, to wake it.
    receiver: Arc<Socket>,
    receiving: Mutex<Receiving>,
    warnings: Vec<String>,
}

/// The receiving side, before and after the first subscription.
#[derive(Default)]
struct Receiving {
    waiting: Option<(Receiver, Option<ThreadStart>)>,
    thread: Option<JoinHandle<()>>,
}

impl Udpm {
    /// Opens the sockets; the group is joined at the first subscription, whose receiving thread
    /// begins with `start`.
    ///
    /// # Errors
    /// [`Error::Socket`] naming the step the system refused.
    pub fn open(options: &UdpmOptions, start: Option<ThreadStart>) -> Result<Self, Error> {
        let sender = sending_socket(options)?;
        let (socket, warnings) = receiving_socket(options)?;
        let socket = Arc::new(socket);
        let (dispatcher, subscriber) = Dispatcher::new();
        let statistics = Arc::new(Mutex::default());
        let stop = Arc::new(AtomicBool::new(false));
        let receiver = Receiver {
            socket: Arc::clone(&socket),
            dispatcher,
            reassembly: Reassembly::default(),
            timed: false,
            statistics: Arc::clone(&statistics),
            stop: Arc::clone(&stop),
        };
        let receiving = Mutex::new(Receiving { waiting: Some((receiver, start)), thread: None });
        Ok(Self {
            options: options.clone(),
            sender,
            sequence: AtomicU32::new(0),
            subscriber,
            statistics,
            stop,
            receiver: socket,
            receiving,
            warnings,
        })
    }

    /// Joins the group and starts the receiving thread, unless that was done before.
    fn receive(&self) -> Result<(), Error> {
        let mut receiving = self.receiving.lock().unwrap_or_else(PoisonError::into_inner);
        let Some((receiver, _)) = &receiving.waiting else { return Ok(()) };
        join(&receiver.socket, &self.options)?;
        let Some((receiver, start)) = receiving.waiting.take() else { return Ok(()) };
        let thread = Builder::new().name("lcm-udpm".to_owned()).spawn(move || {
            if let Some(start) = start {
                start();
            }
            receiver.run();
        });
        let failed = |source| refused("starting the receiving thread", &self.options, source);
        receiving.thread = Some(thread.map_err(failed)?);
        Ok(())
    }

    fn send(&self, channel: &str, payload: &[u8]) -> io::Result<()> {
        let sequence = self.sequence.fetch_add(1, Ordering::Relaxed);
        let send = |parts: &[&[u8]]| {
            let mut slices = [IoSlice::new(&[]); 4];
            for (slice, part) in slices.iter_mut().zip(parts) {
                *slice = IoSlice::new(part);
            }
            self.sender.send_vectored(&slices[..parts.len()])
        };
        if channel.len() + 1 + payload.len() <= datagram::MAX_SHORT {
            let header = datagram::short_header(sequence);
            send(&[&header, channel.as_bytes(), &[0], payload])?;
            return Ok(());
        }
        for fragment in datagram::fragments(sequence, channel, payload) {
            let header = datagram::fragment_header(&fragment);
            match fragment.channel {
                Some(channel) => send(&[&header, channel.as_bytes(), &[0], fragment.part])?,
                None => send(&[&header, fragment.part])?,
            };
        }
        Ok(())
    }
}

impl Transport for Udpm {
    fn publish(&self, channel: &str, payload: &[u8]) -> Result<(), Error> {
        check_channel(channel)?;
        check_size(payload)?;
        let result = self.send(channel, payload);
        let mut statistics = lock(&self.statistics);
        match result {
            Ok(()) => statistics.sent += 1,
            Err(_) => statistics.send_errors += 1,
        }
        result.map_err(|source| Error::Send { channel: channel.to_owned(), source })
    }

    fn subscribe(&self, filter: Filter, sink: Box<dyn Sink>) -> Result<(), Error> {
        check_filter(&filter)?;
        self.subscriber.add(filter, sink)?;
        self.receive()
    }

    fn statistics(&self) -> Statistics {
        lock(&self.statistics).clone()
    }

    fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

impl Drop for Udpm {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let receiving = self.receiving.get_mut().unwrap_or_else(PoisonError::into_inner);
        if let Some(thread) = receiving.thread.take() {
            // Linux wakes who waits for datagrams, though it refuses with "not connected".
            let _ = self.receiver.shutdown(Shutdown::Read);
            // A panic of the thread was printed when it happened.
            let _ = thread.join();
        }
    }
}

/// The counts; a thread that panicked while holding them left them whole.
fn lock(statistics: &Mutex<Statistics>) -> MutexGuard<'_, Statistics> {
    statistics.lock().unwrap_or_else(PoisonError::into_inner)
}

fn refused(step: &'static str, options: &UdpmOptions, source: io::Error) -> Error {
    let unreachable =
        matches!(source.kind(), io::ErrorKind::NetworkUnreachable | io::ErrorKind::HostUnreachable)
            || source.raw_os_error() == Some(nix::errno::Errno::ENODEV as i32);
    let hint = if unreachable { ROUTE_HINT } else { "" };
    Error::Socket { step, target: options.group.to_string(), source, hint }
}

fn sending_socket(options: &UdpmOptions) -> Result<Socket, Error> {
    let failed = |step| move |source| refused(step, options, source);
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))
        .map_err(failed("opening the sending socket"))?;
    socket.set_multicast_ttl_v4(options.ttl).map_err(failed("setting the time to live"))?;
    socket.set_multicast_loop_v4(true).map_err(failed("sending to this host too"))?;
    if options.interface != Ipv4Addr::UNSPECIFIED {
        socket
            .set_multicast_if_v4(&options.interface)
            .map_err(failed("choosing the interface to send on"))?;
    }
    socket.set_write_timeout(Some(SEND_TIMEOUT)).map_err(failed("setting the send timeout"))?;
    socket.connect(&options.group.into()).map_err(failed("connecting to the group"))?;
    Ok(socket)
}

fn receiving_socket(options: &UdpmOptions) -> Result<(Socket, Vec<String>), Error> {
    let failed = |step| move |source| refused(step, options, source);
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))
        .map_err(failed("opening the receiving socket"))?;
    // Other LCM programs on this host listen on the same port.
    socket.set_reuse_address(true).map_err(failed("sharing the port"))?;
    socket.set_recv_buffer_size(options.recv_buf_size).map_err(failed("sizing the buffer"))?;
    let option = |result: nix::Result<()>| result.map_err(io::Error::from);
    option(setsockopt(&socket, sockopt::ReceiveTimestampns, &true))
        .map_err(failed("asking for receive time stamps"))?;
    option(setsockopt(&socket, sockopt::RxqOvfl, &1))
        .map_err(failed("asking for the number of dropped datagrams"))?;
    // Linux reports twice what was set, for its own bookkeeping.
    let size = socket.recv_buffer_size().map_err(failed("reading the buffer's size"))? / 2;
    let asked = options.recv_buf_size;
    let warnings = if size < asked {
        vec![format!(
            "the receive buffer is {size} bytes, {asked} were asked for: bursts will be lost; \
             run `sysctl -w net.core.rmem_max={asked}`"
        )]
    } else {
        Vec::new()
    };
    Ok((socket, warnings))
}

fn join(socket: &Socket, options: &UdpmOptions) -> Result<(), Error> {
    let failed = |step| move |source| refused(step, options, source);
    // Bound to the group and not to all addresses: datagrams sent to this host alone stay out.
    socket.bind(&options.group.into()).map_err(failed("binding to the group"))?;
    socket
        .join_multicast_v4(options.group.ip(), &options.interface)
        .map_err(failed("joining the group"))
}

/// What the receiving thread owns.
struct Receiver {
    socket: Arc<Socket>,
    dispatcher: Dispatcher,
    reassembly: Reassembly,
    /// The wait ends after [`POLL`].
    timed: bool,
    statistics: Arc<Mutex<Statistics>>,
    stop: Arc<AtomicBool>,
}

impl Receiver {
    fn run(mut self) {
        let mut buffer = vec![0; MAX_DATAGRAM];
        let mut control = nix::cmsg_space!(nix::sys::time::TimeSpec, u32);
        while !self.stop.load(Ordering::Relaxed) {
            self.set_timeout();
            match self.receive(&mut buffer, &mut control) {
                Ok((size, source, arrival)) => self.handle(&buffer[..size], source, arrival),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => self.idle(),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(_) => {
                    // An interface that went down: nothing to receive, and no reason to end.
                    lock(&self.statistics).receive_errors += 1;
                    std::thread::sleep(POLL);
                }
            }
        }
    }

    /// A timer for each wait would cost about a microsecond: only while a message in pieces can expire.
    fn set_timeout(&mut self) {
        let timed = self.reassembly.is_waiting();
        if timed != self.timed {
            match self.socket.set_read_timeout(timed.then_some(POLL)) {
                Ok(()) => self.timed = timed,
                Err(_) => lock(&self.statistics).receive_errors += 1,
            }
        }
    }

    /// One datagram: its size, its sender, and when the kernel had it.
    fn receive(
        &mut self,
        buffer: &mut [u8],
        control: &mut [u8],
    ) -> io::Result<(usize, SocketAddrV4, Arrival)> {
        let mut slices = [IoSliceMut::new(buffer)];
        let descriptor = self.socket.as_raw_fd();
        let message =
            recvmsg::<SockaddrIn>(descriptor, &mut slices, Some(control), MsgFlags::empty())?;
        let mut arrival = now();
        for part in message.cmsgs()? {
            match part {
                ControlMessageOwned::ScmTimestampns(stamp) => {
                    let utime = stamp.tv_sec() * 1_000_000 + stamp.tv_nsec() / 1000;
                    // How long it waited in the kernel, unless the clock was set meanwhile.
                    let waited_us = (arrival.utime - utime).clamp(0, 1_000_000);
                    arrival.utime -= waited_us;
                    arrival.mono = arrival.mono.minus_ns(waited_us * 1000);
                }
                ControlMessageOwned::RxqOvfl(drops) => {
                    lock(&self.statistics).kernel_drops = drops.into();
                }
                _ => {}
            }
        }
        let source =
            message.address.map_or(SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, 0), Into::into);
        Ok((message.bytes, source, arrival))
    }

    fn handle(&mut self, bytes: &[u8], source: SocketAddrV4, arrival: Arrival) {
        match datagram::parse(bytes) {
            Some(Datagram::Short { sequence, channel, payload }) => {
                let message = ReceivedMessage { channel, payload, arrival, sender: Some(source) };
                // The loop that waits for it comes first, the books after.
                hand_over(&mut self.dispatcher, &self.statistics, &message);
                lock(&self.statistics).count(source, sequence, payload.len(), arrival.mono);
            }
            Some(Datagram::Fragment(fragment)) => self.fragment(&fragment, source, arrival),
            None => lock(&self.statistics).malformed += 1,
        }
    }

    fn fragment(&mut self, fragment: &Fragment<'_>, source: SocketAddrV4, arrival: Arrival) {
        let mut statistics = lock(&self.statistics);
        statistics.fragments += 1;
        let given_up = self.reassembly.given_up();
        statistics.expired = given_up.expired;
        statistics.evicted = given_up.evicted;
        match self.reassembly.insert(source, fragment, arrival.mono) {
            Outcome::Complete { channel, payload } => {
                statistics.count(source, fragment.sequence, payload.len(), arrival.mono);
                drop(statistics);
                let message = ReceivedMessage { channel, payload, arrival, sender: Some(source) };
                hand_over(&mut self.dispatcher, &self.statistics, &message);
            }
            Outcome::Incomplete => {}
            Outcome::Duplicate => statistics.duplicate_fragments += 1,
            Outcome::Refused => statistics.malformed += 1,
        }
    }

    fn idle(&mut self) {
        self.reassembly.expire(now().mono);
        let given_up = self.reassembly.given_up();
        let mut statistics = lock(&self.statistics);
        statistics.expired = given_up.expired;
        statistics.evicted = given_up.evicted;
    }
}

/// To the sinks, except what liblcm sends to itself.
fn hand_over(
    dispatcher: &mut Dispatcher,
    statistics: &Mutex<Statistics>,
    message: &ReceivedMessage<'_>,
) {
    if message.channel == SELF_TEST {
        return;
    }
    let before = dispatcher.panics();
    dispatcher.deliver(message);
    if dispatcher.panics() > before {
        lock(statistics).sink_panics = dispatcher.panics();
    }
}
