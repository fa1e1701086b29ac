//! `kill -9` at any moment: no learned lap is lost, and no damaged file is ever loaded.
//!
//! `LMPC_KILLS` and `LMPC_SAVER_KILLS` change how often.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "code of tests")]
#![allow(clippy::print_stdout, reason = "figures for `--nocapture`")]

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant, SystemTime};

use common::{MULTICAST, Program, URL, isolated};
use controller::{Config, Controller};
use hosting::learned;
use lcm_types::{ActuationCommand, Checked as _, channels};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use transport::{Filter, Inbox};
use vehicle_model::{CarParams, Track};

mod common;

const PATIENCE: Duration = Duration::from_secs(60);

fn setting(name: &str, default: u32) -> u32 {
    std::env::var(name).map_or(default, |text| text.parse().unwrap())
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("lmpc-{name}-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn controller() -> Controller {
    let nominal = CarParams::builtin("barc").unwrap().with_mu(1.2);
    let track = Arc::new(Track::builtin("l").unwrap());
    let mut config = Config::derived(controller::Preset::Race, &nominal, &track);
    config.warm_up.laps = 1;
    Controller::new(config, nominal, track).unwrap()
}

/// The bits of all lap times in a file, which must be whole.
fn laps(path: &Path) -> Vec<u64> {
    let mut controller = controller();
    learned::load(path, &mut controller).unwrap();
    controller.laps().iter().map(|lap| lap.result.lap_time.to_bits()).collect()
}

/// `lmpc serve`, and how many laps it said to have loaded.
fn serve(path: &Path) -> (Program, usize) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lmpc"));
    command.args(["serve", "--url", URL, "--set", "warm_up.laps=1", "--learned"]).arg(path);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let line = lines.find(|line| line.contains("laps loaded from")).expect("a count of laps");
    // It goes on talking: somebody has to listen.
    std::thread::spawn(move || lines.for_each(drop));
    (Program(child), line.split_whitespace().next().unwrap().parse().unwrap())
}

/// When a file was last written. One from an earlier kill stays until the next save.
fn written(path: &Path) -> Option<SystemTime> {
    fs::metadata(path).and_then(|found| found.modified()).ok()
}

/// Waits for the next message.
fn heard(inbox: &Inbox, what: &str) {
    let received = inbox.wait(PATIENCE).unwrap_or_else(|| panic!("no {what}"));
    inbox.recycle(received);
}

/// Waits for so many commands to drive.
fn driven(commands: &Inbox, count: u32) {
    let end = Instant::now() + PATIENCE;
    let mut seen = 0;
    while seen < count {
        let received = commands.wait_until(end).expect("commands to drive");
        seen += u32::from(ActuationCommand::open(&received.payload).unwrap().enable);
        commands.recycle(received);
    }
}

#[test]
fn a_service_killed_in_mid_lap_drives_on_with_the_same_laps() {
    isolated("a_service_killed_in_mid_lap_drives_on_with_the_same_laps", MULTICAST, URL, || {
        let folder = folder("kill");
        let path = folder.join("learned.lmpc");
        let unfinished = folder.join("learned.lmpc.new");
        let network = transport::open(URL, None).unwrap();
        let (commands, ends) = (Inbox::queue(10_000), Inbox::queue(100));
        network.subscribe(Filter::channel(channels::COMMAND), commands.sink()).unwrap();
        network.subscribe(Filter::channel(channels::LAP), ends.sink()).unwrap();
        let _car = Program::start(&["vehicle", "sim", "--lock-step", "--url", URL]);
        let mut rng = Pcg64::seed_from_u64(9);
        let (mut known, mut in_saving) = (Vec::new(), 0);
        for kill in 0..setting("LMPC_KILLS", 100) {
            let before = written(&unfinished);
            let (mut program, loaded) = serve(&path);
            assert_eq!(loaded, known.len(), "kill {kill}");
            while commands.take().is_some() || ends.take().is_some() {}
            if kill % 2 == 0 {
                // While the end of a lap is being saved.
                heard(&ends, "end of a lap");
                std::thread::sleep(Duration::from_micros(rng.random_range(0..40_000)));
            } else {
                driven(&commands, rng.random_range(2..80));
            }
            program.0.kill().unwrap();
            program.0.wait().unwrap();
            in_saving += u32::from(written(&unfinished).is_some_and(|at| before != Some(at)));
            if path.exists() {
                let found = laps(&path);
                assert_eq!(known, found[..known.len()], "kill {kill}");
                known = found;
            }
        }
        assert!(known.len() > 10, "{} laps", known.len());
        // It drives on with all of them.
        let (program, loaded) = serve(&path);
        assert_eq!(loaded, known.len());
        while commands.take().is_some() {}
        driven(&commands, 20);
        println!("{loaded} laps in the end, {in_saving} kills while a file was being written");
        drop(program);
        fs::remove_dir_all(&folder).unwrap();
    });
}

#[test]
fn a_thousand_kills_of_a_saver_leave_whole_files() {
    let folder = folder("saver");
    let kills = setting("LMPC_SAVER_KILLS", 1000).to_string();
    let mut command = Command::new(env!("CARGO_BIN_EXE_lmpc"));
    command.args(["hil", "probe", "saver-kills", "--seed", "20", "--kills", &kills, "--dir"]);
    let output = command.arg(&folder).output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{output:?}");
    println!("{text}");
    let measured = |name: &str| -> u32 {
        let line = text.lines().find_map(|line| line.strip_prefix(name)).unwrap();
        line.trim().parse().unwrap()
    };
    assert_eq!(measured("kills").to_string(), kills);
    assert_eq!((measured("corrupt_files"), measured("missing_files")), (0, 0));
    assert!(measured("mid_write") > 0);
    fs::remove_dir_all(&folder).unwrap();
}
