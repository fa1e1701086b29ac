//! From texts in memory to a controller.

use std::ffi::{CStr, c_char};
use std::sync::Arc;

use controller::{Config, Controller, Preset};
use vehicle_model::{CarParams, Track};

use crate::{Handle, explain, guarded};

/// The text of an argument, or why it is none.
///
/// # Safety
/// The text is null or ends with a zero byte and lives through the call.
unsafe fn text<'a>(what: &str, text: *const c_char) -> Result<Option<&'a str>, String> {
    if text.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's promise.
    let text = unsafe { CStr::from_ptr(text) }.to_str();
    text.map(Some).map_err(|e| format!("{what}: {e}"))
}

/// Names that ship are one line.
fn is_file(text: &str) -> bool {
    text.contains(['\n', '=', ','])
}

fn car(text: &str) -> Result<CarParams, String> {
    let car = if is_file(text) { CarParams::from_toml(text) } else { CarParams::builtin(text) };
    car.map_err(|e| format!("car: {e}"))
}

fn track(text: &str) -> Result<Track, String> {
    if !is_file(text) {
        let known = || Track::builtin_names().collect::<Vec<_>>().join(", ");
        return Track::builtin(text).ok_or_else(|| {
            format!("track '{text}' is neither the text of a file nor one of {}", known())
        });
    }
    // A CSV table has no assignment.
    let name = if text.contains('=') { "track.toml" } else { "track.csv" };
    Track::parse(name, text).map_err(|e| format!("track: {e}"))
}

fn config(text: Option<&str>, car: &CarParams, track: &Track) -> Result<Config, String> {
    match text {
        Some(text) => Config::from_toml_for(text, car, track).map_err(|e| format!("config: {e}")),
        None => Ok(Config::derived(Preset::Race, car, track)),
    }
}

#[inline(never)]
fn make(
    config_text: Option<&str>,
    car_text: Option<&str>,
    track_text: Option<&str>,
) -> Result<Box<Handle>, String> {
    let missing = |what: &str| format!("{what} is NULL; expected a name or the text of a file");
    let car_text = car_text.ok_or_else(|| missing("car"))?;
    let track = track(track_text.ok_or_else(|| missing("track"))?)?;
    let car = car(car_text)?;
    let config = config(config_text, &car, &track)?;
    let mut identity = postcard::to_allocvec(&config).map_err(|e| e.to_string())?;
    identity.extend(car.fingerprint().to_le_bytes());
    identity.extend(track.fingerprint().to_le_bytes());
    let identity = u64::from(crc32fast::hash(&identity));
    let controller = Controller::new(config, car, Arc::new(track)).map_err(|e| e.to_string())?;
    Ok(Box::new(Handle { controller, identity }))
}

// SAFETY: the name stands once in a program; the arguments are as in lmpc.h.
#[unsafe(no_mangle)]
unsafe extern "C" fn lmpc_create(
    config: *const c_char,
    car: *const c_char,
    track: *const c_char,
    error: *mut c_char,
    error_size: usize,
) -> *mut Handle {
    let made = guarded(Err("internal error".to_owned()), || {
        // SAFETY: the caller's promise.
        let texts = unsafe { (text("config", config)?, text("car", car)?, text("track", track)?) };
        make(texts.0, texts.1, texts.2)
    });
    // SAFETY: the caller's promise.
    unsafe { explain(error, error_size, made.as_ref().err().map_or("", String::as_str)) };
    made.map_or(std::ptr::null_mut(), Box::into_raw)
}
