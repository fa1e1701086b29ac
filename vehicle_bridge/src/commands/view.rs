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
use super::view_foxglove::App;
use super::{Outcome, setup, view_orders, view_source};
use command_line::ViewArgs;
use hosting::settings::Usage;
use live_view::{Clock, Reference, Resolve, Server, ServerOptions, View, Wanted};
use optimum_store::OptimumStore;
use protocol::convert;
use racing::RaceOptions;
use terminal::{Talk, WARN, paint, result};
use transport::{Arrival, Filter, ReceivedMessage, Transport};

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

/// Who is shown a drive: the page, and the Foxglove app if that is asked for.
pub(super) struct Audience {
    page: Arc<View>,
    app: Option<App>,
}

impl Audience {
    /// Shows a message that was received at `arrival`, its monotonic time being that of what is shown.
    pub(super) fn take(&self, channel: &str, payload: &[u8], arrival: Arrival) {
        self.page.take(channel, payload, arrival.mono.as_ns());
        if let Some(app) = &self.app {
            app.take(channel, payload, arrival.utime);
        }
    }

    /// Says that nothing more will come, for this reason.
    pub(super) fn end(&self, why: &str) {
        self.page.end(why);
    }
}

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
    let app =
        args.foxglove.map(|port| App::serve(SocketAddr::new(args.listen, port))).transpose()?;
    let audience = |title: String, clock: Clock| {
        let page = Arc::new(View::new(title, clock, resolve));
        Arc::new(Audience { page, app })
    };
    let opened = |audience: &Audience, options: ServerOptions| -> Result<String> {
        let server = Server::start(address, Arc::clone(&audience.page), options)?;
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
        let audience = audience(log.title(), clock);
        show(&opened(&audience, ServerOptions::default())?, &audience, talk)?;
        log.play(&audience, &stop)?;
    } else if args.race {
        let race = view_source::RaceSource::new(options, args)?;
        let audience = audience(race.title(), race.clock());
        show(&opened(&audience, ServerOptions::default())?, &audience, talk)?;
        race.drive(&audience, &stop)?;
    } else {
        let (network, notes, _) = connect(&args.network, false)?;
        for note in &notes {
            talk.say(&paint(WARN, &format!("warning: {note}")));
        }
        let clock: Clock = Box::new(|| transport::now().mono.as_ns());
        let audience = audience(args.network.url(), clock);
        subscribe(&network, &audience)?;
        let orders = if args.operator { Some(view_orders::orders(&network)?) } else { None };
        let token = orders.as_ref().map(|orders| format!("/#operator={}", orders.token));
        let place = opened(&audience, ServerOptions { orders })?;
        show(&(place + &token.unwrap_or_default()), &audience, talk)?;
        _joined = Some(network);
    }
    // What was shown can be looked at until the end is asked for.
    while !is_set(&stop) {
        std::thread::sleep(NAP);
    }
    Ok(Outcome::Done)
}

fn show(place: &str, audience: &Audience, talk: Talk) -> Result<()> {
    result(place)?;
    if let Some(app) = &audience.app {
        result(&format!("ws://{}", app.address()))?;
        talk.say(
            "open the first in a browser, the second as a connection of Foxglove; Ctrl-C ends",
        );
    } else {
        talk.say("open it in a browser; Ctrl-C ends");
    }
    Ok(())
}

/// Shows every message of a network.
pub(super) fn subscribe(network: &Arc<dyn Transport>, audience: &Arc<Audience>) -> Result<()> {
    let audience = Arc::clone(audience);
    let take = move |message: &ReceivedMessage<'_>| {
        audience.take(message.channel, message.payload, message.arrival);
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
    let store = OptimumStore::of(&args.controller.track, args.store.as_deref());
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
