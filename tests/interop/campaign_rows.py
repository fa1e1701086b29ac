"""Compares the tables of a built-in study with those of the campaign that says the same.

    campaign_rows.py STUDY BUILT_IN CAMPAIGN     both folders with their runs.csv
"""

import csv
import pathlib
import sys

STUDY, BUILT_IN, CAMPAIGN = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])


def table(file):
    with open(file, newline="") as opened:
        return list(csv.DictReader(opened))


def same(built_in, campaign):
    """Equal words, or texts of the same number."""
    if built_in == campaign:
        return True
    try:
        return float(built_in) == float(campaign)
    except ValueError:
        return False


def paper(row, laps):
    """What a campaign calls the columns of a study of the paper; times as its laps.csv has them."""
    cell = ("regression", "nominal", "control_rate_cost", "bandwidth", "seed")
    own = [lap for lap in laps if all(lap[name] == row[name] for name in cell)]
    done = [lap for lap in own if lap["kind"] == "learning" and lap["lap_time_s"]]
    times = [float(lap["lap_time_s"]) for lap in done[: int(row["laps_completed"])]]
    valid = [t for t, lap in zip(times, done) if lap["valid"] == "true"]
    assert row["best_lap_s"] == "" or float(row["best_lap_s"]) == min(times), row
    if row["ilt20_s"]:
        assert float(row["ilt20_s"]) == times[19], row
    return {
        "seed": row["seed"],
        "settings": row["settings"],
        "failure": row["failure"],
        "fail_lap": row["itf"],
        "laps_completed": row["laps_completed"],
        "fallbacks": row["fallbacks"],
        "best_lap_s": str(min(valid)) if valid else "",
        "last_lap_s": str(times[-1]) if times else "",
        "lap_times_s": " ".join(f"{t:.3f}" for t in times),
    }


def matrix(row):
    """What a campaign calls the columns of `lmpc study tracks`."""
    names = (
        "car track seed settings failure best_lap_s overhang_max_m clarabel_steps fallbacks clipped"
        " lap_times_s fail_lap fail_time_s fail_s_m fail_message"
    )
    return {name: row[name] for name in names.split()} | {"laps_completed": row["laps"]}


built_in, campaign = table(BUILT_IN / "runs.csv"), table(CAMPAIGN / "runs.csv")
assert len(built_in) == len(campaign) > 0, (len(built_in), len(campaign))
laps = [] if STUDY == "tracks" else table(BUILT_IN / "laps.csv")
values = 0
for number, (one, other) in enumerate(zip(built_in, campaign)):
    for name, value in (matrix(one) if STUDY == "tracks" else paper(one, laps)).items():
        assert same(value, other[name]), (STUDY, number, name, value, other[name])
        values += 1
failed = sum(bool(row["failure"]) for row in campaign)
print(f"campaign: {STUDY}: {len(campaign)} rows, {failed} of them failed runs, have the same {values} values")
