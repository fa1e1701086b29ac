//! The fault proxy: a thread between the controller's network and the car's.

use std::os::fd::AsFd as _;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context as _, Result};
use lcm_types::channels;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use rand::RngExt as _;

use super::alter::{self, Memory};
use super::attack::{self, Sniffed};
use super::fault::{Fault, FaultKind};
use super::malformed;
use super::passed::Passed;
use super::random::{self, Random};
use super::wire::{Wire, datagram, parts};
use hosting::realtime;
use hosting::worker::Worker;
use transport::{UdpmOptions, now};

/// Largest datagram. \[B\]
const LARGEST: usize = 65_536;
/// Numbers of datagrams the proxy makes itself begin here.
const OWN: u32 = 0x4000_0000;
/// Old messages kept for replays. \[-\]
const KEPT: usize = 64;

/// When the faults begin, on this host's monotonic clock; `i64::MAX` until it is known. \[ns\]
pub(super) type Start = Arc<AtomicI64>;

/// The running thread; ends when dropped.
pub(super) struct Proxy {
    passed: Arc<Mutex<Passed>>,
    _worker: Worker,
}

impl Proxy {
    /// Joins both networks and begins to forward.
    pub(super) fn start(
        (control, car): (&UdpmOptions, &UdpmOptions),
        faults: &[Fault],
        start: &Start,
        seed: u64,
    ) -> Result<Self> {
        let wires = [control, car].map(|options| {
            Wire::join(options).with_context(|| format!("the proxy cannot join {}", options.group))
        });
        let [control, car] = wires;
        let passed: Arc<Mutex<Passed>> = Arc::default();
        let states =
            faults.iter().enumerate().map(|(i, f)| Active::new(i, f.clone(), seed)).collect();
        let mut forwarder = Forwarder {
            wires: [control?, car?],
            faults: states,
            start: Arc::clone(start),
            passed: Arc::clone(&passed),
            waiting: Vec::new(),
            sequence: OWN,
            sniffed: Sniffed::default(),
            malformed: malformed::cases(channels::COMMAND),
        };
        let worker = Worker::start("hil-proxy", move |stop| {
            // Without CAP_SYS_NICE the proxy adds the scheduler's latency.
            let _ = realtime::prioritise(realtime::RECEIVE_PRIORITY);
            forwarder.run(stop);
        })?;
        Ok(Self { passed, _worker: worker })
    }

    /// What went through so far.
    pub(super) fn passed(&self) -> Passed {
        self.passed.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// A fault and what it remembers.
pub(super) struct Active {
    index: usize,
    pub(super) fault: Fault,
    memory: Memory,
    pub(super) random: Random,
    pub(super) count: u32,
    held: Option<Vec<u8>>,
    past: Vec<Vec<u8>>,
    pub(super) next_ns: i64,
    done: bool,
}

impl Active {
    fn new(index: usize, fault: Fault, seed: u64) -> Self {
        let (memory, random) = (Memory::default(), random::of(seed));
        Self {
            index,
            fault,
            memory,
            random,
            count: 0,
            held: None,
            past: Vec::new(),
            next_ns: 0,
            done: false,
        }
    }
}

struct Forwarder {
    /// Of the controller, of the car.
    wires: [Wire; 2],
    faults: Vec<Active>,
    start: Start,
    passed: Arc<Mutex<Passed>>,
    /// Delayed datagrams: when due, to which wire.
    waiting: Vec<(i64, usize, Vec<u8>)>,
    sequence: u32,
    sniffed: Sniffed,
    malformed: Vec<malformed::MalformedMessage>,
}

impl Forwarder {
    fn run(&mut self, stop: &AtomicBool) {
        let mut buffer = vec![0; LARGEST];
        while !stop.load(Ordering::Relaxed) {
            self.wait();
            for from in [0, 1] {
                while let Some(received) = self.wires[from].receive(&mut buffer) {
                    let received = received.to_vec();
                    self.forward(&received, 1 - from);
                }
            }
            let time = now().mono.as_ns();
            self.release(time);
            self.attack(time);
        }
    }

    fn wait(&self) {
        let busy = self.faults.iter().any(|active| active.fault.action.is_storm());
        let time = now().mono.as_ns();
        let due = self.waiting.iter().map(|w| (w.0 - time).max(0) / 1_000_000).min();
        let longest = if busy { 1 } else { 20 };
        let timeout = due.map_or(longest, |ms| ms.clamp(1, longest));
        let mut sockets =
            [0, 1].map(|i| PollFd::new(self.wires[i].socket().as_fd(), PollFlags::POLLIN));
        // A signal ends the wait early, which does no harm.
        let _ = poll(&mut sockets, PollTimeout::try_from(timeout).unwrap_or(PollTimeout::ZERO));
    }

    fn release(&mut self, time: i64) {
        let mut i = 0;
        while i < self.waiting.len() {
            if self.waiting[i].0 <= time {
                let (_, to, bytes) = self.waiting.remove(i);
                self.pass(&bytes, to, true);
            } else {
                i += 1;
            }
        }
    }

    /// Sends, and notes what of it counts.
    fn pass(&mut self, bytes: &[u8], to: usize, genuine: bool) {
        if genuine {
            self.note(bytes, to, false);
        }
        self.wires[to].send(bytes);
    }

    fn note(&mut self, bytes: &[u8], to: usize, lost: bool) {
        let Some((channel, message)) = parts(bytes) else { return };
        if !lost {
            self.sniffed.note(channel, message, to);
        }
        if to != 1 {
            return;
        }
        let mut passed = self.passed.lock().unwrap_or_else(PoisonError::into_inner);
        passed.note(channel, message, now().mono.as_ns(), lost);
    }

    /// Notes that a fault had something to act on.
    fn acted(&self, index: usize) {
        let mut passed = self.passed.lock().unwrap_or_else(PoisonError::into_inner);
        *passed.acted.entry(index).or_default() += 1;
    }

    fn forward(&mut self, received: &[u8], to: usize) {
        let time = now().mono.as_ns();
        let start = self.start.load(Ordering::Acquire);
        let channel = parts(received).map_or("", |(channel, _)| channel).to_owned();
        let mut bytes = received.to_vec();
        let (mut genuine, mut delay_ns) = (true, 0);
        let mut extra: Vec<Vec<u8>> = Vec::new();
        let mut faults = std::mem::take(&mut self.faults);
        let mut lost = false;
        for active in &mut faults {
            if active.fault.car {
                continue;
            }
            let of_channel = active.fault.channel.as_ref().is_none_or(|name| *name == channel);
            let (from, until) = active.fault.window_ns();
            let since = if start == i64::MAX { -1 } else { time - start };
            let Some((_, message)) = parts(&bytes) else { continue };
            if let FaultKind::Replay { .. } = active.fault.action
                && of_channel
            {
                active.past.push(bytes.clone());
                if active.past.len() > KEPT {
                    active.past.remove(0);
                }
            }
            if !of_channel || since < from || since >= until {
                if since >= until
                    && let Some(held) = active.held.take()
                {
                    extra.push(held);
                }
                continue;
            }
            if active.random.random::<f64>() >= active.fault.share {
                continue;
            }
            self.acted(active.index);
            match &active.fault.action {
                FaultKind::Drop { first } => {
                    active.count += 1;
                    lost |= first.is_none_or(|most| active.count <= most);
                }
                FaultKind::Every { n } => {
                    active.count += 1;
                    lost |= active.count % n != 0;
                }
                #[expect(clippy::cast_possible_truncation, reason = "delays of a run")]
                FaultKind::Delay { ms, jitter_ms } => {
                    delay_ns += ((ms + active.random.random::<f64>() * jitter_ms) * 1e6) as i64;
                }
                FaultKind::Duplicate { copies } => {
                    extra.extend((0..*copies).map(|_| bytes.clone()));
                }
                FaultKind::Swap {} => match active.held.take() {
                    Some(first) => extra.push(first),
                    None => {
                        active.held = Some(bytes.clone());
                        lost = true;
                    }
                },
                FaultKind::Replay { count } => {
                    let old = active.past.len().saturating_sub(1 + *count as usize);
                    extra.extend(active.past[old..active.past.len() - 1].iter().cloned());
                }
                FaultKind::Junk { count } => {
                    extra.extend((0..*count).map(|_| attack::junk(&bytes, &mut active.random)));
                }
                FaultKind::Malformed {} if !self.malformed.is_empty() => {
                    let case = active.count as usize % self.malformed.len();
                    active.count += 1;
                    extra.extend(self.malformed[case].1.iter().cloned());
                }
                action => {
                    let mut message = message.to_vec();
                    if alter::message(
                        action,
                        &channel,
                        &mut message,
                        &mut active.memory,
                        &mut active.random,
                    ) {
                        genuine &=
                            matches!(action, FaultKind::WallClock { .. } | FaultKind::Ttl { .. });
                        self.sequence += 1;
                        bytes = datagram(self.sequence, &channel, &message);
                    }
                }
            }
        }
        self.faults = faults;
        if !lost && delay_ns > 0 {
            self.waiting.push((time + delay_ns, to, bytes));
        } else if lost {
            self.note(&bytes, to, true);
        } else {
            self.pass(&bytes, to, genuine);
        }
        for bytes in extra {
            self.pass(&bytes, to, false);
        }
    }

    /// What is sent though nothing came.
    fn attack(&mut self, time: i64) {
        let start = self.start.load(Ordering::Acquire);
        if start == i64::MAX {
            return;
        }
        for active in &mut self.faults {
            let (from, until) = active.fault.window_ns();
            if (from..until).contains(&(time - start)) {
                let sent = attack::send(active, &self.sniffed, time, |channel, message| {
                    self.sequence += 1;
                    // States go to the controller, all else to the car.
                    let to = usize::from(channel != channels::STATE);
                    self.wires[to].send(&datagram(self.sequence, channel, message));
                });
                if sent > 0 {
                    let mut passed = self.passed.lock().unwrap_or_else(PoisonError::into_inner);
                    passed.storm(sent, time);
                }
                if let FaultKind::Fragments { count, bytes } = active.fault.action
                    && !active.done
                {
                    active.done = true;
                    for number in 0..count {
                        let part = attack::incomplete(OWN + number, bytes, &mut active.random);
                        self.wires[1].send(&part);
                    }
                }
            }
        }
    }
}
