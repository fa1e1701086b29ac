//! One run, from a case to its row.

use controller::fhocp::Backend;
use racing::record::{is_fallback, median};
use racing::{Race, RaceError};

use super::case::CampaignCase;
use super::file::Campaign;
use super::rows::{CampaignColumns, CampaignRow};

/// The word for a race that cannot begin, or whose vehicle fails.
const REFUSED: &str = "refused";

/// Drives a case. A race that cannot begin is a failed run.
#[must_use]
pub fn drive(campaign: &Campaign, columns: &CampaignColumns, case: &CampaignCase) -> CampaignRow {
    let race = || -> Result<Race, RaceError> {
        let mut race = Race::new(case.options.clone())?;
        race.run(|_| {})?;
        Ok(race)
    };
    let mut row = CampaignRow::new(case, columns);
    let mut set = |name: &str, value: String| row.set(columns, name, value);
    match race() {
        Ok(race) => {
            usual(&race, &mut set);
            for measure in &campaign.measures {
                set(&measure.name, measure.of_race(&race));
            }
        }
        Err(error) => {
            set("failure", REFUSED.to_owned());
            set("fail_message", error.to_string());
        }
    }
    let limits = campaign.limits.broken(columns, &row);
    row.set(columns, "limits", limits);
    row
}

/// What every campaign records.
fn usual(race: &Race, set: &mut impl FnMut(&str, String)) {
    let learned = || race.laps.iter().filter(|lap| lap.is_learning());
    let times = || learned().map(|lap| lap.result.lap_time);
    let valid = learned().filter(|lap| lap.result.valid).map(|lap| lap.result.lap_time);
    let number = |value: f64| if value.is_finite() { value.to_string() } else { String::new() };
    let some = |value: Option<f64>| value.map_or(String::new(), number);
    set("laps_completed", learned().count().to_string());
    set("best_lap_s", some(valid.min_by(f64::total_cmp)));
    set("median_lap_s", number(median(&mut times().collect::<Vec<f64>>())));
    set("last_lap_s", some(times().next_back()));
    let overhang = race.steps.iter().map(|step| step.overhang).fold(f64::NAN, f64::max);
    let beyond = race.failure.map_or(overhang, |failure| overhang.max(failure.beyond));
    set("overhang_max_m", number(beyond));
    let count = |of: fn(&controller::Status) -> bool| {
        race.steps.iter().filter(|step| of(&step.status)).count().to_string()
    };
    set("fallbacks", count(is_fallback));
    set("clipped", count(|status| status.clipped));
    set("clarabel_steps", count(|status| status.solver == Some(Backend::Clarabel)));
    set("lap_times_s", times().map(|time| format!("{time:.3}")).collect::<Vec<_>>().join(" "));
    if let Some(failure) = &race.failure {
        set("failure", failure.reason.as_str().to_owned());
        set("fail_lap", failure.iteration.to_string());
        set("fail_time_s", number(failure.time));
        set("fail_s_m", number(failure.x.s));
        set("fail_message", failure.to_string());
    }
}
