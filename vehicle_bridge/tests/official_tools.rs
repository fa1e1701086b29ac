//! Beside the programs every LCM network has: lcm-logger records us, lcm-logplayer plays our logs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "code of tests")]

use std::fs::{self, File};
use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use common::{MULTICAST, URL, isolated};
use lcm_types::eventlog::{Event, EventReader, EventWriter};
use lcm_types::{Checked, Header, Message, VehicleState, channels};
use transport::{Filter, Inbox};

mod common;

const MISSING: &str = "a program of liblcm-bin, see tools/setup.sh";

fn file(name: &str) -> PathBuf {
    let path = std::env::temp_dir().join(format!("{name}-{}.lcmlog", std::process::id()));
    let _ = fs::remove_file(&path); // of an earlier run
    path
}

fn events(path: &PathBuf) -> Vec<Event> {
    EventReader::new(File::open(path).unwrap()).collect::<Result<_, _>>().unwrap()
}

/// A sealed state of the car, number `seq`.
fn state(seq: i64) -> Vec<u8> {
    let h = Header { seq, sender: "test@host".to_owned(), ..Header::default() };
    let mut bytes = Vec::new();
    let vx = 0.5 * seq as f64;
    VehicleState { h, vx, ..VehicleState::default() }.seal_into(&mut bytes).unwrap();
    bytes
}

#[test]
fn lcm_logger_records_what_we_send() {
    isolated("lcm_logger_records_what_we_send", MULTICAST, URL, || {
        let path = file("recorded");
        let mut logger = Command::new("lcm-logger").arg(&path).spawn().expect(MISSING);
        let network = transport::open(URL, None).unwrap();
        // It says nothing when it is ready: something in the file does.
        while fs::metadata(&path).map_or(0, |m| m.len()) == 0 {
            network.publish("HELLO", b"is anybody there?").unwrap();
            std::thread::sleep(Duration::from_millis(20));
        }
        let sent: Vec<Vec<u8>> = (0..300).map(state).collect();
        for bytes in &sent {
            network.publish(channels::STATE, bytes).unwrap();
            std::thread::sleep(Duration::from_millis(1));
        }
        network.publish("BIG", &vec![7; 300_000]).unwrap();
        std::thread::sleep(Duration::from_millis(500));
        let stopped = Command::new("kill").args(["-INT", &logger.id().to_string()]).status();
        assert!(stopped.unwrap().success());
        logger.wait().unwrap();
        let events = events(&path);
        fs::remove_file(&path).unwrap();
        let on = |channel: &str| -> Vec<&[u8]> {
            events.iter().filter(|e| e.channel == channel).map(|e| e.data.as_slice()).collect()
        };
        assert_eq!(on(channels::STATE), sent);
        assert_eq!(on("BIG"), [vec![7; 300_000]]);
        let last = VehicleState::open(on(channels::STATE)[299]).unwrap();
        assert_eq!((last.h.seq, last.vx), (299, 149.5));
    });
}

#[test]
fn lcm_logplayer_plays_what_we_write() {
    isolated("lcm_logplayer_plays_what_we_write", MULTICAST, URL, || {
        let path = file("written");
        let mut log = EventWriter::new(File::create(&path).unwrap());
        let states: Vec<Vec<u8>> = (0..200).map(state).collect();
        for (utime, bytes) in (1_700_000_000_000_000..).step_by(2_000).zip(&states) {
            log.write(utime, channels::STATE, bytes).unwrap();
        }
        drop(log.into_inner());
        let network = transport::open(URL, None).unwrap();
        let inbox = Inbox::queue(1000);
        network.subscribe(Filter::channel(channels::STATE), inbox.sink()).unwrap();
        let player = Command::new("lcm-logplayer").args(["-s", "2"]).arg(&path).status();
        assert!(player.expect(MISSING).success());
        for bytes in &states {
            assert_eq!(&inbox.wait(Duration::from_secs(20)).unwrap().payload, bytes);
        }
        assert_eq!(inbox.take(), None);
        fs::remove_file(&path).unwrap();
        assert!(VehicleState::decode(&states[0]).is_ok());
    });
}
