//! The transport over real sockets: storms, sizes, both implementations, and the official tools.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "code of tests")]

use std::time::{Duration, Instant};

use common::{MULTICAST, URL, isolated};
use transport::{Filter, Inbox, MAX_MESSAGE, ReceivedMessage, Transport};

mod common;

const PATIENCE: Duration = Duration::from_secs(20);

fn subscribed(network: &dyn Transport, channel: &str, inbox: Inbox) -> Inbox {
    network.subscribe(Filter::channel(channel), inbox.sink()).unwrap();
    inbox
}

#[test]
fn a_storm_on_another_channel_costs_no_command() {
    isolated("a_storm_on_another_channel_costs_no_command", MULTICAST, URL, || {
        let network = transport::open(URL, None).unwrap();
        let commands = subscribed(&*network, "LMPC/CMD", Inbox::queue(1000));
        let ends = subscribed(&*network, "END", Inbox::queue(2));
        let storm = std::thread::spawn(|| {
            let sender = transport::open(URL, None).unwrap();
            let (begin, mut sent) = (Instant::now(), 0);
            // 20,000 per second for two seconds, 20 at a time.
            while sent < 40_000 {
                let due = (begin.elapsed().as_secs_f64() * 20_000.0) as usize;
                while sent < due.min(40_000) {
                    sender.publish("STORM", &[7; 1024]).unwrap();
                    sent += 1;
                }
                std::thread::sleep(Duration::from_millis(1));
            }
            std::thread::sleep(Duration::from_millis(500));
            sender.publish("END", &[]).unwrap();
        });
        let sender = transport::open(URL, None).unwrap();
        for number in 0..200_u32 {
            sender.publish("LMPC/CMD", &number.to_be_bytes()).unwrap();
            std::thread::sleep(Duration::from_millis(10));
        }
        storm.join().unwrap();
        sender.publish("END", &[]).unwrap();
        for _ in 0..2 {
            ends.wait(PATIENCE).unwrap();
        }
        // A message is handed over first and counted after.
        std::thread::sleep(Duration::from_millis(100));
        let statistics = network.statistics();
        assert_eq!(statistics.received + statistics.lost, 40_000 + 200 + 2);
        assert_eq!((statistics.malformed, commands.dropped()), (0, 0));
        if let [warning] = network.warnings() {
            // This system's limit is too small: what is lost is counted, and the warning says so.
            assert!(warning.contains("sysctl -w net.core.rmem_max=4194304"), "{warning}");
            return;
        }
        assert_eq!(statistics.lost, 0);
        for number in 0..200_u32 {
            assert_eq!(commands.take().unwrap().payload, number.to_be_bytes());
        }
    });
}

#[test]
fn a_slow_loop_reads_the_newest_state() {
    isolated("a_slow_loop_reads_the_newest_state", MULTICAST, URL, || {
        let network = transport::open(URL, None).unwrap();
        let state = subscribed(&*network, "CAR/STATE", Inbox::latest());
        let all = subscribed(&*network, "CAR/STATE", Inbox::queue(1000));
        for number in 0..500_u32 {
            network.publish("CAR/STATE", &number.to_be_bytes()).unwrap();
        }
        // The queue says when the last one is in; the slow loop then finds that one.
        for _ in 0..500 {
            all.wait(PATIENCE).unwrap();
        }
        let newest = state.take().unwrap();
        assert_eq!(newest.payload, 499_u32.to_be_bytes());
        assert_eq!((state.take(), state.dropped()), (None, 499));
        let age = transport::now().mono.as_ns() - newest.arrival.mono.as_ns();
        assert!((0..60_000_000_000).contains(&age), "{age}");
    });
}

#[test]
fn messages_of_every_size_arrive() {
    isolated("messages_of_every_size_arrive", MULTICAST, URL, || {
        let network = transport::open(URL, None).unwrap();
        let inbox = subscribed(&*network, "BIG", Inbox::queue(2));
        for size in [0, 1, 1400, 65_495, 65_496, 65_497, 130_970, 500_000, MAX_MESSAGE] {
            let payload: Vec<u8> = (0..size).map(|i| (i % 249) as u8).collect();
            network.publish("BIG", &payload).unwrap();
            assert_eq!(inbox.wait(PATIENCE).unwrap().payload, payload, "{size} bytes");
        }
        let error = network.publish("BIG", &vec![0; MAX_MESSAGE + 1]).unwrap_err();
        assert_eq!(error.to_string(), "message of 1048577 bytes, expected at most 1048576");
        let error = network.publish("A B", &[]).unwrap_err();
        assert!(error.to_string().starts_with("channel \"A B\", expected 1 to 63 bytes"));
    });
}

#[test]
fn a_receive_buffer_below_what_was_asked_for_is_a_warning_with_the_command_to_run() {
    let name = "a_receive_buffer_below_what_was_asked_for_is_a_warning_with_the_command_to_run";
    isolated(name, MULTICAST, URL, || {
        let url = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=1073741824";
        let network = transport::open(url, None).unwrap();
        let [warning] = network.warnings() else { panic!("{:?}", network.warnings()) };
        assert!(warning.contains("`sysctl -w net.core.rmem_max=1073741824`"), "{warning}");
    });
}

#[test]
fn without_a_route_the_error_says_what_to_do() {
    isolated("without_a_route_the_error_says_what_to_do", "true", URL, || {
        let error = transport::open(URL, None).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("239.255.76.67:7667"), "{error}");
        assert!(error.contains("ip route add 224.0.0.0/4 dev lo"), "{error}");
    });
}

#[test]
fn a_sink_may_publish_and_the_thread_start_runs_first() {
    isolated("a_sink_may_publish_and_the_thread_start_runs_first", MULTICAST, URL, || {
        let (tell, told) = std::sync::mpsc::channel();
        let start = move || tell.send(std::thread::current().name().map(str::to_owned)).unwrap();
        let network = transport::open(URL, Some(Box::new(start))).unwrap();
        let answers = subscribed(&*network, "ANSWER", Inbox::latest());
        assert_eq!(told.recv_timeout(PATIENCE).unwrap().as_deref(), Some("lcm-udpm"));
        let answering = std::sync::Arc::clone(&network);
        let answer = move |message: &ReceivedMessage<'_>| {
            answering.publish("ANSWER", message.payload).unwrap();
        };
        let asking = transport::open(URL, None).unwrap();
        // The sink holds its own connection: it goes when the process does.
        network.subscribe(Filter::channel("QUESTION"), Box::new(answer)).unwrap();
        asking.publish("QUESTION", b"?").unwrap();
        assert_eq!(answers.wait(PATIENCE).unwrap().payload, b"?");
        std::mem::forget(network);
    });
}

#[cfg(feature = "liblcm")]
fn payloads(messages: &[transport::Received]) -> Vec<&[u8]> {
    messages.iter().map(|m| m.payload.as_slice()).collect()
}

#[cfg(feature = "liblcm")]
#[test]
fn both_implementations_deliver_the_same() {
    isolated("both_implementations_deliver_the_same", MULTICAST, URL, || {
        let rust = transport::open(URL, None).unwrap();
        let c = transport::open(&format!("liblcm+{URL}"), None).unwrap();
        let sizes = [0, 1, 251, 1400, 9000, 65_494, 65_495, 65_496, 131_000, 300_000];
        let messages: Vec<Vec<u8>> = sizes
            .iter()
            .map(|size| (0..*size).map(|i: usize| (i * 7 + size) as u8).collect())
            .collect();
        for (round, sender) in [&rust, &c].into_iter().enumerate() {
            let channel = format!("BOTH.{round}"); // the dot must not match as a pattern
            let at_rust = subscribed(&*rust, &channel, Inbox::queue(100));
            let at_c = subscribed(&*c, &channel, Inbox::queue(100));
            for message in &messages {
                sender.publish(&format!("BOTHx{round}"), b"not subscribed to").unwrap();
                sender.publish(&channel, message).unwrap();
                // One at a time: liblcm's queue would drop the newest.
                std::thread::sleep(Duration::from_millis(5));
            }
            let collect = |inbox: &Inbox| -> Vec<transport::Received> {
                messages.iter().map(|_| inbox.wait(PATIENCE).unwrap()).collect()
            };
            let (from_rust, from_c) = (collect(&at_rust), collect(&at_c));
            assert_eq!(payloads(&from_rust), payloads(&from_c));
            assert_eq!(
                payloads(&from_rust),
                messages.iter().map(Vec::as_slice).collect::<Vec<_>>()
            );
            assert!(from_c.iter().chain(&from_rust).all(|m| m.channel == channel));
            assert_eq!((at_rust.take(), at_c.take()), (None, None));
        }
        assert!(matches!(
            c.subscribe(Filter::All, Inbox::latest().sink()),
            Err(transport::Error::Unsupported { .. })
        ));
    });
}

#[cfg(feature = "liblcm")]
#[test]
fn memq_works_through_liblcm() {
    isolated("memq_works_through_liblcm", "true", "memq://", || {
        let network = transport::open("memq://", None).unwrap();
        let inbox = subscribed(&*network, "A", Inbox::queue(10));
        for number in 0..10_u8 {
            network.publish("A", &[number]).unwrap();
            assert_eq!(inbox.wait(PATIENCE).unwrap().payload, [number]);
        }
        let statistics = network.statistics();
        assert_eq!((statistics.sent, statistics.received, statistics.send_errors), (10, 10, 0));
    });
}

#[cfg(feature = "liblcm")]
#[test]
fn mpudpm_works_through_liblcm() {
    let url = "mpudpm://239.255.76.67:7667?ttl=0";
    isolated("mpudpm_works_through_liblcm", MULTICAST, url, || {
        let network = transport::open(url, None).unwrap();
        let inbox = subscribed(&*network, "A", Inbox::queue(100));
        // Its senders learn from the others which port a channel has: the first may go unheard.
        let received = (0..200).find_map(|_| {
            network.publish("A", b"over many ports").unwrap();
            inbox.wait(Duration::from_millis(100))
        });
        assert_eq!(received.unwrap().payload, b"over many ports");
    });
}

#[cfg(feature = "liblcm")]
#[test]
fn a_file_written_through_liblcm_is_a_log() {
    let path = std::env::temp_dir().join("lmpc-file-provider.lcmlog");
    let url = format!("file://{}?mode=w", path.display());
    isolated("a_file_written_through_liblcm_is_a_log", "true", &url, || {
        let network = transport::open(&url, None).unwrap();
        for number in 0..20_u8 {
            network.publish("A", &[number]).unwrap();
        }
        drop(network); // sends what is queued, closes the file
        let log = lcm_types::eventlog::EventReader::new(std::fs::File::open(&path).unwrap());
        let events: Vec<_> = log.collect::<Result<_, _>>().unwrap();
        let data: Vec<u8> = events.iter().flat_map(|e| e.data.clone()).collect();
        assert_eq!(data, (0..20).collect::<Vec<u8>>());
        std::fs::remove_file(&path).unwrap();
    });
}
