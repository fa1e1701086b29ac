//! `docs/reference/car.md` is the table of a car's parameters. `LMPC_WRITE_DOCS=1 cargo test -p
//! vehicle_model --test car_page` writes it anew.
#![allow(clippy::unwrap_used, reason = "code of tests")]

use std::fmt::Write as _;
use std::path::Path;

use vehicle_model::{CarGroup, CarParams};

const TOP: &str = "# Car parameters

Generated from the table behind car files, their checks, the fingerprint and the FMU's `car.*` variables. A
car file is TOML; `name` is its name in reports. [Cars](../cars.md) says where the numbers come from.
";

const END: &str = "
## Switches

| key | default | meaning |
|---|---|---|
| `front_force_yaw` | true | the force of steered front wheels along them turns the car |
| `combined_slip` | false | longitudinal force takes from the lateral one (friction ellipse) |

In place of `mu`, a tyre may give `peak_n`, the peak force of the axle at its static load [N]; in place of `b`,
either `cornering_stiffness_n_per_rad` or `cornering_stiffness_norm_per_rad`.
";

fn page() -> String {
    let mut text = TOP.to_owned();
    for group in CarGroup::ALL {
        let section = group.section();
        let place = if section.is_empty() { String::new() } else { format!(" `[{section}]`") };
        let heading = group.heading().trim_end_matches('.');
        write!(text, "\n## {heading}{place}\n\n").unwrap();
        text.push_str(
            "| key | symbol | unit | range | default | meaning | field, `car.` in the FMU |\n",
        );
        text.push_str("|---|---|---|---|---|---|---|\n");
        for key in group.keys() {
            let (range, default) = (key.range.interval(), key.default.text());
            writeln!(
                text,
                "| `{}` | {} | {} | {range} | {default} | {} | `{}` |",
                key.key, key.symbol, key.unit, key.meaning, key.field
            )
            .unwrap();
        }
    }
    text + END
}

#[test]
fn the_page_is_up_to_date() {
    let expected = page();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/reference/car.md");
    if std::env::var_os("LMPC_WRITE_DOCS").is_some() {
        std::fs::write(&path, &expected).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == expected, "the page is old: LMPC_WRITE_DOCS=1 writes it anew");
}

/// What the page says of an absent key: the file without it is the car with that default.
#[test]
fn what_the_table_says_of_absent_keys_holds() {
    use vehicle_model::CarDefault::{Derived, NoLimit, Off, Required};
    let car = CarParams::builtin("barc").unwrap();
    let text = car.to_toml();
    for key in CarGroup::ALL.into_iter().flat_map(CarGroup::keys) {
        if !key.group.section().is_empty() {
            continue;
        }
        let mut file: toml::Table = text.parse().unwrap();
        file.remove(key.key);
        let read = CarParams::from_toml(&file.to_string());
        match key.default {
            Required => assert!(read.is_err(), "{}", key.key),
            Off => assert_eq!((key.get)(&read.unwrap()), Some(0.0), "{}", key.key),
            NoLimit => assert_eq!((key.get)(&read.unwrap()), None, "{}", key.key),
            Derived(_) => {
                assert!((key.get)(&read.unwrap()).is_some_and(|v| v > 0.0), "{}", key.key)
            }
        }
    }
}
