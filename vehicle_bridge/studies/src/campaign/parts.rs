//! From the keys of a run to its race.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context as _, Result, bail, ensure};
use hosting::load;
use hosting::rule::TrackLimit;
use hosting::settings::{Layers, SettingOrigin};
use racing::{ModelErrorAt, Parts, RaceOptions, overlay_changes};
use toml::{Table, Value};
use vehicle_model::track::{ImportOptions, random};
use vehicle_model::{CarParams, Track, TrackError};

use super::file::Assignments;
use super::key::{Key, number, text};

/// How a generated track is named, before its seed.
const RANDOM: &str = "random-";
/// Learned laps of a race, unless the file says otherwise.
const LAPS: u32 = 20;

/// What runs share: cars and tracks are read once.
pub(super) struct Workshop {
    /// The folder of the campaign's file.
    folder: PathBuf,
    config: Option<PathBuf>,
    body: Option<bool>,
    /// Where the model's error is taken.
    pub(super) model_error: ModelErrorAt,
    cars: BTreeMap<String, CarParams>,
    tracks: BTreeMap<String, Arc<Track>>,
}

/// The keys of a run, sorted out.
#[derive(Default)]
struct Sorted {
    car: String,
    track: String,
    preset: Option<String>,
    plant: Vec<String>,
    nominal_mu: Option<f64>,
    laps: Option<u32>,
    body: Option<bool>,
    config: Vec<String>,
    car_keys: Vec<(String, Value)>,
    track_keys: Vec<(String, Value)>,
}

impl Workshop {
    pub(super) fn new(folder: &Path, config: Option<&Path>, body: Option<bool>) -> Result<Self> {
        let mut shop = Self {
            folder: folder.to_owned(),
            config: None,
            body,
            model_error: ModelErrorAt::Never,
            cars: BTreeMap::new(),
            tracks: BTreeMap::new(),
        };
        shop.config = config.map(|path| PathBuf::from(shop.place(&path.display().to_string())));
        Ok(shop)
    }

    /// A file's name: beside the campaign's file if there is one, else as it stands.
    fn place(&self, name: &str) -> String {
        let beside = self.folder.join(name);
        if beside.is_file() { beside.display().to_string() } else { name.to_owned() }
    }

    /// The race of a run, with seed 0. Of a key that is given several times the last counts.
    pub(super) fn build(&mut self, given: &Assignments) -> Result<RaceOptions> {
        let keys = Sorted::of(given)?;
        let car = self.car(&keys)?;
        let track = self.track(&keys, &car)?;
        for problem in track.problems_for(&car) {
            if matches!(problem, TrackError::TooNarrow { .. }) {
                bail!("{} does not fit on {}: {problem}", keys.car, keys.track);
            }
        }
        let mut layers = Layers::default();
        if let Some(path) = &self.config {
            layers.file(path)?;
        }
        if let Some(preset) = &keys.preset {
            let origin = SettingOrigin::CommandLine;
            layers.text(&format!("preset = {}", Value::String(preset.clone())), origin)?;
        }
        for assignment in &keys.config {
            layers.set(assignment)?;
        }
        let parts = Parts {
            name: &keys.car,
            car,
            track,
            plant: &keys.plant,
            nominal_mu: keys.nominal_mu,
            laps: keys.laps.unwrap_or(LAPS),
        };
        let mut options = parts.assemble(|car, track| layers.build_for(car, track))?;
        options.limit = match keys.body.or(self.body) {
            Some(true) => TrackLimit::Body,
            Some(false) => TrackLimit::CentreOfGravity,
            None => TrackLimit::of(&options.config),
        };
        options.model_error = self.model_error;
        Ok(options)
    }

    fn car(&mut self, keys: &Sorted) -> Result<CarParams> {
        let name = format!("{} {:?}", keys.car, keys.car_keys);
        if let Some(car) = self.cars.get(&name) {
            return Ok(car.clone());
        }
        let builtin = CarParams::builtin_names().contains(&keys.car.as_str());
        let place = if builtin { keys.car.clone() } else { self.place(&keys.car) };
        let mut car = load::car(&place)?;
        if !keys.car_keys.is_empty() {
            let text = edited(&car.to_toml(), &keys.car_keys)?;
            car = CarParams::from_toml(&text).context("with its `car.` keys")?;
        }
        self.cars.insert(name, car.clone());
        Ok(car)
    }

    fn track(&mut self, keys: &Sorted, car: &CarParams) -> Result<Arc<Track>> {
        let drawn = keys.track.strip_prefix(RANDOM).and_then(|seed| seed.parse::<u64>().ok());
        // Other cars get other random tracks.
        let scale = drawn.map(|_| car.fingerprint());
        let name = format!("{} {scale:?} {:?}", keys.track, keys.track_keys);
        if let Some(track) = self.tracks.get(&name) {
            return Ok(Arc::clone(track));
        }
        let track = match drawn {
            Some(seed) => {
                let drawn = random(seed, car);
                let drawn = drawn.with_context(|| format!("no {} for {}", keys.track, car.name))?;
                self.edit(Arc::new(drawn), None, keys)?
            }
            None if Track::builtin(&keys.track).is_some() => {
                self.edit(load::track(&keys.track)?, None, keys)?
            }
            None => {
                let place = self.place(&keys.track);
                let text = load::track_text(&place)?;
                self.edit(load::track(&place)?, Some((&place, &text)), keys)?
            }
        };
        self.tracks.insert(name, Arc::clone(&track));
        Ok(track)
    }

    /// A track with other values of keys of its file. A file in another format than ours is taken as
    /// what our importer makes of it.
    fn edit(
        &self,
        track: Arc<Track>,
        file: Option<(&str, &str)>,
        keys: &Sorted,
    ) -> Result<Arc<Track>> {
        if keys.track_keys.is_empty() {
            return Ok(track);
        }
        let text = match (file, track.to_toml()) {
            (_, Some(text)) => text,
            (Some((name, text)), None) => {
                match Track::import(name, text, &ImportOptions::default()) {
                    Ok(imported) => imported.to_toml(),
                    Err(_) => bail!("{name} cannot be written as a track file of ours"),
                }
            }
            (None, None) => bail!("{} takes no `track.` keys", keys.track),
        };
        let text = edited(&text, &keys.track_keys)?;
        Ok(Arc::new(Track::from_toml(&text).context("with its `track.` keys")?))
    }
}

/// A TOML text with other values of some keys, dotted where they stand in a section.
fn edited(text: &str, keys: &[(String, Value)]) -> Result<String> {
    let mut table: Table = toml::from_str(text)?;
    for (key, value) in keys {
        let (sections, name) = key.rsplit_once('.').unwrap_or(("", key));
        let mut place = &mut table;
        for section in sections.split('.').filter(|section| !section.is_empty()) {
            let inner = place.entry(section).or_insert_with(|| Value::Table(Table::new()));
            place = inner.as_table_mut().with_context(|| format!("`{section}` is no section"))?;
        }
        // A file's numbers are floats; a whole one of ours stands for the same value.
        let value = match (place.get(name), value) {
            (Some(Value::Float(_)), Value::Integer(whole)) => Value::Float(*whole as f64),
            _ => value.clone(),
        };
        place.insert(name.to_owned(), value);
    }
    Ok(toml::to_string(&table)?)
}

impl Sorted {
    fn of(given: &Assignments) -> Result<Self> {
        let mut keys = Self::default();
        for (name, value) in given {
            keys.take(name, value)?;
        }
        Ok(keys)
    }

    fn take(&mut self, name: &str, value: &Value) -> Result<()> {
        let word = || match value {
            Value::String(word) => Ok(word.clone()),
            other => bail!("{name}: found {other}, expected a text"),
        };
        match Key::parse(name)? {
            Key::Car => self.car = word()?,
            Key::Track => self.track = word()?,
            Key::Preset => self.preset = Some(word()?),
            Key::Plant => {
                let text = word()?;
                let changes = text.split(',').map(str::trim);
                let changes = changes.filter(|change| !change.is_empty() && *change != "none");
                let changes: Vec<String> = changes.map(str::to_owned).collect();
                overlay_changes(&mut self.plant, &changes)?;
            }
            Key::NominalMu => {
                let mu = number(value);
                self.nominal_mu =
                    Some(mu.with_context(|| format!("{name}: found {value}, expected a number"))?);
            }
            Key::Laps => {
                let laps = value.as_integer().and_then(|laps| u32::try_from(laps).ok());
                let laps = laps.filter(|laps| (1..=10_000).contains(laps));
                self.laps = Some(laps.with_context(|| {
                    format!("laps: found {value}, expected a whole number from 1 to 10000")
                })?);
            }
            Key::Body => {
                let body = value.as_bool();
                self.body =
                    Some(body.with_context(|| format!("body: found {value}, expected a switch"))?);
            }
            Key::Config(key) => {
                ensure!(key != "warm_up.seed", "config.warm_up.seed is that of `seeds`");
                self.config.push(format!("{key}={value}"));
            }
            Key::OfPlant(key) => {
                overlay_changes(&mut self.plant, &[format!("{key}={}", text(value))])?;
            }
            Key::OfCar(key) => self.car_keys.push((key, value.clone())),
            Key::OfTrack(key) => self.track_keys.push((key, value.clone())),
        }
        Ok(())
    }
}
