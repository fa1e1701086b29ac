//! Logs, whole and damaged.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::{BackgroundWriter, Event, EventReader, EventWriter, SYNC};
use crate::Error;

fn events(count: usize) -> Vec<Event> {
    let mut rng = Pcg64::seed_from_u64(6);
    (0..count)
        .map(|i| Event {
            number: i64::try_from(i).unwrap(),
            utime: 1_700_000_000_000_000 + i64::try_from(i).unwrap() * 10_000,
            channel: format!("CH/{}", i % 3),
            data: (0..rng.random_range(0..300)).map(|_| rng.random()).collect(),
        })
        .collect()
}

fn log(events: &[Event]) -> Vec<u8> {
    let mut writer = EventWriter::new(Vec::new());
    for event in events {
        writer.write(event.utime, &event.channel, &event.data).unwrap();
    }
    writer.into_inner()
}

fn read(bytes: &[u8]) -> (Vec<Event>, super::Damage) {
    let mut reader = EventReader::new(bytes);
    let events = reader.by_ref().collect::<Result<_, _>>().unwrap();
    (events, reader.damage())
}

#[test]
fn what_was_written_is_read() {
    let events = events(500);
    let (again, damage) = read(&log(&events));
    assert_eq!(again, events);
    assert_eq!(damage.bytes, 0);
}

#[test]
fn a_log_cut_anywhere_gives_its_whole_events() {
    let events = events(5);
    let bytes = log(&events);
    let ends: Vec<usize> = (0..=5).map(|n| log(&events[..n]).len()).collect();
    for cut in 0..=bytes.len() {
        let whole = ends.iter().filter(|end| **end <= cut).count() - 1;
        let (again, damage) = read(&bytes[..cut]);
        assert_eq!(again, events[..whole], "cut at {cut}");
        assert_eq!(damage.bytes as usize, cut - ends[whole], "cut at {cut}");
    }
}

#[test]
fn a_flipped_byte_costs_at_most_two_events() {
    let events = events(20);
    let bytes = log(&events);
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0xff;
        let (again, _) = read(&damaged);
        let kept = events.iter().filter(|event| again.contains(event)).count();
        assert!(kept >= 18, "{kept} of 20 events with byte {at} flipped");
    }
}

#[test]
fn a_damaged_sync_word_costs_one_event() {
    let events = events(20);
    let mut bytes = log(&events);
    bytes[log(&events[..7]).len()] ^= 1;
    let (again, damage) = read(&bytes);
    assert_eq!(again.len(), 19);
    assert_eq!(damage.places, 1);
    assert!(!again.contains(&events[7]));
}

#[test]
fn a_sync_word_inside_a_message_is_no_damage() {
    let mut events = events(3);
    events[1].data = [SYNC.to_be_bytes(); 20].concat();
    assert_eq!(read(&log(&events)), (events, super::Damage::default()));
}

#[test]
fn noise_between_events_is_skipped() {
    let events = events(10);
    let mut rng = Pcg64::seed_from_u64(7);
    let mut bytes = Vec::new();
    for event in &events {
        bytes.extend((0..rng.random_range(1..100_000)).map(|_| rng.random_range(0..0xed_u8)));
        bytes.extend(log(std::slice::from_ref(event)));
    }
    let (mut again, damage) = read(&bytes);
    for (event, expected) in again.iter_mut().zip(&events) {
        event.number = expected.number; // each piece was a log of its own
    }
    assert_eq!(again, events);
    assert_eq!(damage.places, 10);
}

/// As `/dev/zero` is.
#[test]
fn what_has_no_end_and_no_event_is_no_log() {
    let error = EventReader::new(std::io::repeat(0)).next_event().unwrap_err().to_string();
    assert!(error.contains("no event in the first 256 MiB"), "{error}");
}

#[test]
fn random_bytes_never_end_in_anything_but_none() {
    let mut rng = Pcg64::seed_from_u64(8);
    for _ in 0..500 {
        let mut bytes: Vec<u8> = (0..rng.random_range(0..2000)).map(|_| rng.random()).collect();
        for at in (0..bytes.len().saturating_sub(4)).step_by(rng.random_range(5..60)) {
            bytes[at..at + 4].copy_from_slice(&SYNC.to_be_bytes());
        }
        read(&bytes);
    }
}

#[test]
fn sizes_no_log_holds_are_refused() {
    let mut writer = EventWriter::new(Vec::new());
    for channel in [String::new(), "x".repeat(256)] {
        let error = writer.write(0, &channel, &[]).unwrap_err();
        assert!(matches!(error, Error::LogSize { what: "channel", .. }));
    }
    assert!(writer.into_inner().is_empty());
}

#[test]
fn the_background_writer_writes_all_or_counts_what_it_drops() {
    let path = std::env::temp_dir().join(format!("lcm-log-{}", std::process::id()));
    let events = events(200);
    let writer = BackgroundWriter::new(std::fs::File::create(&path).unwrap(), 1000).unwrap();
    for event in &events {
        writer.push(event.utime, &event.channel, &event.data);
    }
    let totals = writer.finish().unwrap();
    let (again, _) = read(&std::fs::read(&path).unwrap());
    std::fs::remove_file(&path).unwrap();
    assert_eq!((totals.written, totals.dropped), (200, 0));
    assert_eq!(again, events);

    // A disk that takes nothing until it is let go: all but the queue's worth is dropped.
    struct Stuck(std::sync::mpsc::Receiver<()>);
    impl std::io::Write for Stuck {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            let _ = self.0.recv(); // an error once the other end is dropped: no longer stuck
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let (release, stuck) = std::sync::mpsc::channel();
    let writer = BackgroundWriter::new(Stuck(stuck), 8).unwrap();
    for event in &events {
        writer.push(event.utime, &event.channel, &event.data);
    }
    drop(release);
    let totals = writer.finish().unwrap();
    assert_eq!(totals.written + totals.dropped, 200);
    assert!(totals.dropped >= 191, "{totals:?}");
}

#[test]
fn writing_goes_on_when_the_disk_has_room_again() {
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::{Arc, Mutex};
    use std::time::{Duration, Instant};

    /// A disk that is full as long as it is said to be.
    #[derive(Clone, Default)]
    struct Disk(Arc<AtomicBool>, Arc<Mutex<Vec<u8>>>);
    impl std::io::Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            if self.0.load(Ordering::SeqCst) {
                return Err(std::io::ErrorKind::StorageFull.into());
            }
            self.1.lock().unwrap().extend(bytes);
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let disk = Disk::default();
    let buffered = std::io::BufWriter::with_capacity(4096, disk.clone());
    let writer = BackgroundWriter::new(buffered, 10_000).unwrap();
    let events = events(600);
    let push = |range: std::ops::Range<usize>| {
        for event in &events[range] {
            writer.push(event.utime, &event.channel, &event.data);
        }
    };
    let until = |what: &dyn Fn() -> bool| {
        let begun = Instant::now();
        while !what() {
            assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", writer.trouble());
            std::thread::sleep(Duration::from_millis(1));
        }
    };
    let empty = || disk.1.lock().unwrap().len() == log(&events[..200]).len();
    push(0..200);
    until(&empty);
    disk.0.store(true, Ordering::SeqCst);
    push(200..400);
    until(&|| writer.dropped() > 0 && writer.trouble().is_some());
    disk.0.store(false, Ordering::SeqCst);
    push(400..600);
    until(&|| writer.trouble().is_none());
    let totals = writer.finish().unwrap();
    let (again, damage) = read(&disk.1.lock().unwrap());
    assert_eq!((totals.written + totals.dropped, again.len() as u64), (600, totals.written));
    assert_eq!(damage, super::Damage::default(), "no event is torn");
    assert!(totals.written >= 400 && again.last().unwrap().data == events[599].data, "{totals:?}");
}
