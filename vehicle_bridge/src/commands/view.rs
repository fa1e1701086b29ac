//! `lmpc view`.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Result, bail};
use controller::{Config, Preset};
use lcm_types::channels;
use vehicle_model::{CarParams, Track};

use super::network::{connect, on_signal};
use super::{Outcome, setup, view_orders, view_source};
use command_line::ViewArgs;
use hosting::settings::Usage;
use live_view::{Clock, Reference, Resolve, Server, ServerOptions, View, Wanted};
use optimum_store::Store;
use protocol::convert;
use racing::RaceOptions;
use terminal::{Talk, WARN, paint, result};
use transport::{Filter, Message, Transport};

/// What is shown of a network that cannot hand out every channel.
const CHANNELS: [&str; 13] = [
    channels::STATE,
    channels::ACTUATION,
    channels::COMMAND,
    channels::COMMAND_DRY,
    channels::TELEMETRY,
    channels::LAP,
    channels::SETUP,
    channels::TRACK,
    channels::OPERATOR,
    channels::OPERATOR_ACK,
    "HB/lmpc",
    "HB/bridge",
    "HB/car",
];
/// Longest sleep, so that signals are seen.
const NAP: Duration = Duration::from_millis(50);

/// Serves the page until Ctrl-C.
pub(super) fn run(args: &ViewArgs, talk: Talk) -> Result<Outcome> {
    if args.operator && args.network.key().is_none() {
        bail!(Usage(
            "--operator needs the network's key: --key FILE, or LMPC_KEY; `lmpc key new FILE` makes one"
                .to_owned()
        ));
    }
    let options =
        setup::race(&args.controller, args.laps, Talk { quiet: talk.quiet || !args.race })?;
    let resolve = resolve(args, &options);
    let address = SocketAddr::new(args.listen, args.port);
    let stop = on_signal()?;
    let opened = |view: &Arc<View>, options: ServerOptions| -> Result<String> {
        let server = Server::start(address, Arc::clone(view), options)?;
        if !args.listen.is_loopback() {
            let text = "whoever reaches this address sees the drive: nothing is encrypted";
            talk.say(&paint(WARN, &format!("warning: {text}")));
        }
        Ok(format!("http://{}", server.address()))
    };
    // A network that nobody holds is left.
    let mut _joined = None;
    if let Some(log) = &args.log {
        let (log, clock) = view_source::Log::open(log, args.speed, args.at)?;
        let view = Arc::new(View::new(log.title(), clock, resolve));
        show(&opened(&view, ServerOptions::default())?, talk)?;
        log.play(&view, &stop)?;
    } else if args.race {
        let race = view_source::Race::new(options, args)?;
        let view = Arc::new(View::new(race.title(), race.clock(), resolve));
        show(&opened(&view, ServerOptions::default())?, talk)?;
        race.drive(&view, &stop)?;
    } else {
        let (network, notes, _) = connect(&args.network, false)?;
        for note in &notes {
            talk.say(&paint(WARN, &format!("warning: {note}")));
        }
        let clock: Clock = Box::new(|| transport::now().mono.as_ns());
        let view = Arc::new(View::new(args.network.url(), clock, resolve));
        subscribe(&network, &view)?;
        let orders = if args.operator { Some(view_orders::orders(&network)?) } else { None };
        let token = orders.as_ref().map(|orders| format!("/#operator={}", orders.token));
        let place = opened(&view, ServerOptions { orders })?;
        show(&(place + &token.unwrap_or_default()), talk)?;
        _joined = Some(network);
    }
    // What was shown can be looked at until the end is asked for.
    while !is_set(&stop) {
        std::thread::sleep(NAP);
    }
    Ok(Outcome::Done)
}

fn show(place: &str, talk: Talk) -> Result<()> {
    result(place)?;
    talk.say("open it in a browser; Ctrl-C ends");
    Ok(())
}

/// Hands every message of a network to the view.
pub(super) fn subscribe(network: &Arc<dyn Transport>, view: &Arc<View>) -> Result<()> {
    let view = Arc::clone(view);
    let take = move |message: &Message<'_>| {
        view.take(message.channel, message.payload, message.arrival.mono.as_ns());
    };
    match network.subscribe(Filter::All, Box::new(take.clone())) {
        // Through liblcm channels are known by their subscriptions alone.
        Err(transport::Error::Unsupported { .. }) => {
            for channel in CHANNELS {
                network.subscribe(Filter::channel(channel), Box::new(take.clone()))?;
            }
            Ok(())
        }
        subscribed => Ok(subscribed?),
    }
}

/// The cars and tracks this computer knows: those of the command line, then those that ship, by the names
/// the network has for them.
fn resolve(args: &ViewArgs, options: &RaceOptions) -> Resolve {
    let store = Store::of(&args.controller.track, args.store.as_deref());
    let (own_car, own_track) = (options.plant.car.clone(), Arc::clone(&options.track));
    let named_car = hosting::load::car(&args.controller.car).ok();
    let margin = options.config.limits.lane_margin;
    Box::new(move |wanted: &Wanted| {
        let is_car = |car: &CarParams| wanted.car_id == convert::car_id(car);
        let is_track = |track: &Track| wanted.track_id == convert::track_id(track);
        let given =
            wanted.car_id == 0 || named_car.as_ref().is_some_and(&is_car) || is_car(&own_car);
        let car = if given {
            own_car.clone()
        } else {
            CarParams::builtin(&wanted.car).ok().filter(|car| is_car(car))?
        };
        if is_track(&own_track) && given {
            let optimum = store.find(&car, &own_track, margin);
            return Some(Reference { car, optimum });
        }
        let shipped =
            || Track::builtin(&wanted.track).filter(|track| is_track(track)).map(Arc::new);
        let track = is_track(&own_track).then(|| Arc::clone(&own_track)).or_else(shipped);
        let optimum = track.and_then(|track| {
            let margin = Config::derived(Preset::Race, &car, &track).limits.lane_margin;
            store.find(&car, &track, margin)
        });
        Some(Reference { car, optimum })
    })
}

/// Whether the end was asked for.
pub(super) fn is_set(stop: &AtomicBool) -> bool {
    stop.load(Ordering::Relaxed)
}
