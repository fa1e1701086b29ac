//! The server over real connections: files, streams, refusals, orders.
#![allow(clippy::unwrap_used, clippy::panic, reason = "code of tests")]

use std::io::{BufReader, Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use lcm_types::{Checked, Frenet, LapResult, Message, MpcTelemetry, Track, VehicleState, channels};
use live_view::{Orders, Server, ServerOptions, View};
use serde_json::Value;

const MS: i64 = 1_000_000;
const LENGTH: f64 = 20.0;

fn view() -> Arc<View> {
    Arc::new(View::new("a test".to_owned(), Box::new(|| 5000 * MS), Box::new(|_| None)))
}

fn serve(view: &Arc<View>, options: ServerOptions) -> SocketAddr {
    let any = SocketAddr::from(([127, 0, 0, 1], 0));
    Server::start(any, Arc::clone(view), options).unwrap().address()
}

fn connect(address: SocketAddr) -> TcpStream {
    let stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    stream
}

/// Status line and body.
fn ask(address: SocketAddr, head: &str, body: &str) -> (String, String) {
    let mut stream = connect(address);
    let length = body.len();
    write!(stream, "{head}\r\nHost: {address}\r\nContent-Length: {length}\r\n\r\n{body}").unwrap();
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    let (head, body) = text.split_once("\r\n\r\n").unwrap();
    (head.lines().next().unwrap().to_owned(), body.to_owned())
}

/// The next event of a name on a stream.
fn event(stream: &mut impl std::io::BufRead, wanted: &str) -> Value {
    let (mut name, mut line) = (String::new(), String::new());
    for _ in 0..100_000 {
        line.clear();
        assert!(stream.read_line(&mut line).unwrap() > 0, "the stream ended before {wanted}");
        if let Some(found) = line.strip_prefix("event: ") {
            found.trim().clone_into(&mut name);
        } else if let Some(data) = line.strip_prefix("data: ").filter(|_| name == wanted) {
            return serde_json::from_str(data).unwrap();
        }
    }
    panic!("no event {wanted}");
}

fn stream(address: SocketAddr) -> BufReader<TcpStream> {
    let mut stream = connect(address);
    write!(stream, "GET /stream HTTP/1.1\r\nHost: {address}\r\n\r\n").unwrap();
    BufReader::new(stream)
}

fn sealed(message: &impl Checked) -> Vec<u8> {
    let mut bytes = Vec::new();
    message.seal_into(&mut bytes).unwrap();
    bytes
}

fn plain(message: &impl Message) -> Vec<u8> {
    let mut bytes = Vec::new();
    message.encode_into(&mut bytes).unwrap();
    bytes
}

/// A straight track to the east, 2 m wide.
fn track() -> Track {
    let s: Vec<f32> = (0_u8..20).map(f32::from).collect();
    Track {
        track_id: 3,
        name: "straight".to_owned(),
        length: LENGTH,
        closed: true,
        n: 20,
        x: s.clone(),
        y: vec![0.0; 20],
        yaw: vec![0.0; 20],
        kappa: vec![0.0; 20],
        w_left: vec![1.0; 20],
        w_right: vec![1.0; 20],
        s,
        ..Track::default()
    }
}

/// At 2 m/s, every 100 ms; the state `n` is measured at n * 100 ms.
fn state(n: i64) -> VehicleState {
    let s = (0.2 * n as f64) % LENGTH;
    VehicleState {
        meas_mono_ns: n * 100 * MS,
        quality: 2,
        valid: VehicleState::POSE | VehicleState::VEL | VehicleState::FRENET,
        x: s,
        vx: 2.0,
        frenet: Frenet {
            s,
            track_id: 3,
            lap: i32::try_from(n / 100).unwrap(),
            ..Frenet::default()
        },
        ..VehicleState::default()
    }
}

#[test]
fn a_page_that_comes_late_gets_the_laps_and_then_only_what_is_new() {
    let view = view();
    let address = serve(&view, ServerOptions::default());
    view.take(channels::TRACK, &sealed(&track()), 0);
    // A lap of 10 s and a half.
    for n in 0..150 {
        view.take(channels::STATE, &sealed(&state(n)), n * 100 * MS);
        if n == 100 {
            let lap =
                LapResult { track_id: 3, lap_time: 10.0, valid: true, ..LapResult::default() };
            view.take(channels::LAP, &plain(&lap), n * 100 * MS);
        }
    }
    let mut page = stream(address);
    let hello = event(&mut page, "hello");
    assert_eq!((&hello["source"], &hello["operator"]), (&"a test".into(), &false.into()));
    let world = event(&mut page, "world");
    assert_eq!((&world["name"], &world["car"]["known"]), (&"straight".into(), &false.into()));
    assert_eq!(
        (&world["left"][5], &world["right"][5]),
        (&serde_json::json!([5.0, 1.0]), &serde_json::json!([5.0, -1.0]))
    );
    let laps = event(&mut page, "laps");
    assert_eq!(
        (&laps["rows"][0]["time"], &laps["rows"][0]["judged"]),
        (&10.0.into(), &true.into())
    );
    let best = laps["best"]["samples"].as_array().unwrap();
    // Time since the line by place: 2 m/s.
    assert_eq!(best.len(), 101);
    for sample in best {
        let (t, s) = (sample[0].as_f64().unwrap(), sample[1].as_f64().unwrap());
        assert!((2.0 * t - s).abs() < 1e-3, "{sample}");
    }
    let frame = event(&mut page, "frame");
    assert_eq!(frame["lap"]["fresh"], true);
    let had = frame["lap"]["add"].as_array().unwrap().len();
    assert_eq!(had, 50);
    assert_eq!(frame["car"]["s"], state(149).frenet.s);
    let step = MpcTelemetry { total_us: 700, ..MpcTelemetry::default() };
    view.take(channels::TELEMETRY, &plain(&step), 15_000 * MS);
    view.take(channels::STATE, &sealed(&state(150)), 15_000 * MS);
    let mut added = 0;
    let mut steps = Vec::new();
    while added == 0 {
        let frame = event(&mut page, "frame");
        added += frame["lap"]["add"].as_array().unwrap().len();
        steps.extend(frame["steps"].as_array().cloned().unwrap_or_default());
    }
    assert_eq!((added, steps.len()), (1, 1));
    assert_eq!(steps[0][0], 700);
    view.end("over");
    while event(&mut page, "status")["ended"] != "over" {}
}

#[test]
fn what_no_car_would_send_is_shown_as_unknown_and_stays_small() {
    let view = view();
    let address = serve(&view, ServerOptions::default());
    let n = 20_000_usize;
    let s: Vec<f32> = (0..n).map(|i| i as f32 * 1e-3).collect();
    let zeros = vec![0.0_f32; n];
    let long = Track {
        n: 20_000,
        x: s.clone(),
        y: zeros.clone(),
        yaw: zeros.clone(),
        kappa: zeros,
        w_left: vec![f32::NAN; n],
        w_right: vec![1.0; n],
        s,
        ..track()
    };
    view.take(channels::TRACK, &sealed(&long), 0);
    let point = lcm_types::PredPoint { x: f32::INFINITY, ..Default::default() };
    let step = MpcTelemetry {
        n_pred: 5000,
        pred: vec![point; 5000],
        n_x: 6,
        n_ss: 5000,
        ss: vec![vec![f32::NAN; 6]; 5000],
        ss_cost: vec![0.0; 5000],
        ss_lambda: vec![f32::NAN; 5000],
        support_min: f32::NAN,
        ..MpcTelemetry::default()
    };
    view.take(channels::TELEMETRY, &plain(&step), 0);
    for (i, value) in [f64::NAN, f64::INFINITY, -1e300, 1e300].into_iter().enumerate() {
        let frenet = Frenet { s: value, e_y: value, track_id: 3, ..Frenet::default() };
        let odd = VehicleState {
            x: value,
            yaw: value,
            vx: value,
            frenet,
            ..state(i64::try_from(i).unwrap())
        };
        view.take(channels::STATE, &sealed(&odd), 0);
        view.take(channels::STATE, b"no message", 0);
        let lap = LapResult { track_id: 3, lap_time: value, valid: true, ..LapResult::default() };
        view.take(channels::LAP, &plain(&lap), 0);
    }
    let mut page = stream(address);
    let world = event(&mut page, "world");
    assert_eq!(
        (world["centre"].as_array().unwrap().len(), &world["left"][0]),
        (2000, &serde_json::json!([null, null]))
    );
    let laps = event(&mut page, "laps");
    assert_eq!((&laps["rows"][0]["time"], &laps["best"]), (&Value::Null, &Value::Null));
    let frame = event(&mut page, "frame");
    assert_eq!(frame["lap"]["add"].as_array().unwrap().len(), 0, "{}", frame["lap"]);
    assert_eq!(frame["plan"]["x"].as_array().unwrap().len(), 400);
    assert_eq!(frame["plan"]["x"][0][0], Value::Null);
    view.take(channels::STATE, &sealed(&state(1)), 0);
    while event(&mut page, "frame")["car"]["x"] != state(1).x {}
}

#[test]
fn files_are_served_and_nothing_of_other_places() {
    let address = serve(&view(), ServerOptions::default());
    let (line, page) = ask(address, "GET / HTTP/1.1", "");
    assert!(line.contains("200") && page.contains("<title>lmpc view</title>"), "{line}");
    // Everything the page and its scripts name is served here.
    let mut seen = Vec::new();
    let mut open = vec![page];
    while let Some(text) = open.pop() {
        assert!(
            !text.contains("https://")
                && !text.replace("http://www.w3.org/2000/svg", "").contains("http://")
        );
        let names = text.split(['"', '\'']).filter(|part| {
            part.len() > 1
                && (part.starts_with('/') || part.starts_with("./"))
                && part.ends_with(['s', 'g'])
                && !part.contains(' ')
        });
        for name in names {
            let path = name.trim_start_matches('.').to_owned();
            if seen.contains(&path) {
                continue;
            }
            let (line, text) = ask(address, &format!("GET {path} HTTP/1.1"), "");
            assert!(line.contains("200"), "{path}: {line}");
            open.push(text);
            seen.push(path);
        }
    }
    assert_eq!(seen.len(), 8, "{seen:?}");
    for path in ["/none", "/..", "/../src/lib.rs", "//etc/passwd"] {
        assert!(ask(address, &format!("GET {path} HTTP/1.1"), "").0.contains("404"), "{path}");
    }
    assert!(ask(address, "DELETE / HTTP/1.1", "").0.contains("405"));
    assert!(ask(address, "OPTIONS /order HTTP/1.1", "").0.contains("405"));
}

#[test]
fn orders_are_taken_only_with_the_token_from_this_page_and_if_wanted() {
    let given = Arc::new(Mutex::new(Vec::new()));
    let taken = Arc::clone(&given);
    let give = move |order: &live_view::OrderRequest| {
        taken.lock().unwrap().push((order.order.clone(), order.value));
        if order.order == "start" { Err("not armed".to_owned()) } else { Ok("fine".to_owned()) }
    };
    let orders = Orders { token: "secret".to_owned(), give: Box::new(give) };
    let address = serve(&view(), ServerOptions { orders: Some(orders) });
    let shows = serve(&view(), ServerOptions::default());
    let head = |address: SocketAddr, token: &str| {
        format!("POST /order HTTP/1.1\r\nOrigin: http://{address}\r\nX-Lmpc-Token: {token}")
    };
    let cap = r#"{"order":"speed-cap","value":2.5}"#;
    assert!(ask(shows, &head(shows, "secret"), cap).0.contains("403"));
    assert!(ask(address, &head(address, "secre"), cap).0.contains("403"));
    assert!(ask(address, &head(address, ""), cap).0.contains("403"));
    assert!(ask(address, "POST /order HTTP/1.1\r\nX-Lmpc-Token: secret", cap).0.contains("403"));
    let foreign = "POST /order HTTP/1.1\r\nOrigin: http://evil.example\r\nX-Lmpc-Token: secret";
    assert!(ask(address, foreign, cap).0.contains("403"));
    assert!(ask(address, &head(address, "secret"), "{\"order\":1}").0.contains("400"));
    assert_eq!(*given.lock().unwrap(), []);
    assert_eq!(
        ask(address, &head(address, "secret"), cap),
        ("HTTP/1.1 200 OK".to_owned(), "fine".to_owned())
    );
    let refused = ask(address, &head(address, "secret"), r#"{"order":"start"}"#);
    assert_eq!(refused, ("HTTP/1.1 409 Conflict".to_owned(), "not armed".to_owned()));
    let orders = [("speed-cap".to_owned(), 2.5), ("start".to_owned(), 0.0)];
    assert_eq!(*given.lock().unwrap(), orders);
}

#[test]
fn too_many_connections_are_turned_away_and_end_again() {
    let address = serve(&view(), ServerOptions::default());
    let mut pages: Vec<_> = (0..32).map(|_| stream(address)).collect();
    for page in &mut pages {
        event(page, "hello");
    }
    let mut text = String::new();
    let _ = connect(address).read_to_string(&mut text);
    assert!(text.starts_with("HTTP/1.1 503"), "{text}");
    drop(pages);
    // Each of their threads finds its page gone when it writes the next status.
    let served = (0..200).any(|_| {
        std::thread::sleep(Duration::from_millis(50));
        let mut stream = connect(address);
        let _ = write!(stream, "GET / HTTP/1.1\r\nHost: {address}\r\n\r\n");
        let mut text = String::new();
        let _ = stream.read_to_string(&mut text);
        text.starts_with("HTTP/1.1 200")
    });
    assert!(served);
}
