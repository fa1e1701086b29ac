#!/usr/bin/env python3
"""Median, 99th percentile and worst time of a learned control step, of the same race run several times.

The race is the same to the last bit each time, so each step's least time over the runs is its own: what
a busy machine adds is left out. Prints one line for each car, and ratios to the median.

usage: tools/step_times.py LMPC [RUNS [LAPS]]
"""

import csv
import subprocess
import sys
import tempfile

CASES = [("barc", "l"), ("iac", "road_course")]


def step_times(lmpc, car, track, laps):
    """Lap and time [us] of each step of a race."""
    with tempfile.TemporaryDirectory() as folder:
        command = [lmpc, "race", "--car", car, "--track", track, "--laps", str(laps), "--out", folder]
        # 3: an invalid lap, which is a lap as well.
        if subprocess.run(command, capture_output=True, check=False).returncode not in (0, 3):
            sys.exit(f"{' '.join(command)} failed")
        with open(f"{folder}/timings.csv", encoding="utf-8") as table:
            return [(int(row["lap"]), float(row["step_us"])) for row in csv.DictReader(table)]


def main():
    """Runs and prints."""
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    runs = int(sys.argv[2]) if len(sys.argv) > 2 else 9
    laps = int(sys.argv[3]) if len(sys.argv) > 3 else 50
    print(f"{'car':<6} {'steps':>6} {'median us':>10} {'p99 us':>10} {'worst us':>10} {'p99':>6} {'worst':>6}")
    for car, track in CASES:
        times = [step_times(sys.argv[1], car, track, laps) for _ in range(runs)]
        # After the first learned lap: what initial laps cost is another step.
        first = max(lap for lap, _ in times[0]) - laps + 1
        least = sorted(
            min(run[k][1] for run in times) for k, (lap, _) in enumerate(times[0]) if lap > first
        )
        median, p99, worst = (least[int(q * (len(least) - 1))] for q in (0.5, 0.99, 1.0))
        print(
            f"{car:<6} {len(least):>6} {median:>10.1f} {p99:>10.1f} {worst:>10.1f} "
            f"{p99 / median:>6.2f} {worst / median:>6.2f}"
        )


if __name__ == "__main__":
    main()
