//! `lmpc car`.

use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use vehicle_model::CarParams;

use hosting::load;

use super::Outcome;
use command_line::{CarAction, CarFileArgs, NewCarArgs, RandomCarArgs};
use file_check::facts;
use terminal::result;

/// Does what the options say.
pub(super) fn run(args: &CarFileArgs) -> Result<Outcome> {
    match &args.action {
        CarAction::New(args) => new(args),
        CarAction::Random(args) => random(args),
        CarAction::Show(args) => {
            let car = load::car(&args.car)?;
            // As comments, so that the whole is a car file.
            for fact in facts(&car) {
                result(&format!("# {fact}"))?;
            }
            result("")?;
            result(car.to_toml().trim_end())?;
            Ok(Outcome::Done)
        }
    }
}

fn new(args: &NewCarArgs) -> Result<Outcome> {
    if args.name.trim().is_empty() || args.name.contains(['/', '\\']) {
        bail!(
            "`{}` is no name of a car; expected words without a slash, and the folder with --out",
            args.name
        );
    }
    let mut car = load::car(&args.like)?;
    car.name.clone_from(&args.name);
    let path = args.out.clone().unwrap_or_else(|| PathBuf::from(format!("{}.toml", args.name)));
    write(&path, &car)?;
    let (shown, like) = (path.display(), &args.like);
    result(&format!("{shown}: the numbers of {like}, to be changed; then `lmpc check {shown}`"))?;
    Ok(Outcome::Done)
}

fn random(args: &RandomCarArgs) -> Result<Outcome> {
    let car = CarParams::random(args.seed);
    let path = args.out.clone().unwrap_or_else(|| PathBuf::from(format!("{}.toml", car.name)));
    write(&path, &car)?;
    for fact in facts(&car) {
        result(&fact)?;
    }
    Ok(Outcome::Done)
}

/// Writes a car file that is not there yet.
fn write(path: &Path, car: &CarParams) -> Result<()> {
    let shown = path.display();
    if path.exists() {
        bail!("{shown} is there already; give --out another file, or remove it");
    }
    let mut file = File::create_new(path).with_context(|| format!("cannot write {shown}"))?;
    file.write_all(car.to_toml().as_bytes()).with_context(|| format!("cannot write {shown}"))
}
