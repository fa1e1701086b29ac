"""Lap times of all tools beside each other, from what `tools/fmu_check.sh` kept of each run.

    python fmu/tests/race_table.py folder laps

A file in the folder is one tool's output; its name is `order@tool`. Every tool must have finished
the laps; tools that couple in the same order must have the same lap times.
"""

import re
import sys
from pathlib import Path


def main():
    folder, laps = Path(sys.argv[1]), int(sys.argv[2])
    rows = []
    for file in sorted(folder.iterdir()):
        order, tool = file.name.split("@")
        rows.append((order, tool, re.findall(r"^lap \d+: ([0-9.]+) s", file.read_text(), re.M)))
    width = max(len(tool) for _, tool, _ in rows)
    heads = "".join(f"{f'lap {i}':>9}" for i in range(1, laps + 1))
    print(f"{'tool':<{width}}  {'coupling order':<36}{heads}   [s]")
    for order, tool, times in rows:
        print(f"{tool:<{width}}  {order:<36}" + "".join(f"{time:>9}" for time in times))
    for order, tool, times in rows:
        if len(times) != laps:
            sys.exit(f"{tool}: {len(times)} laps, expected {laps}")
        first = next(row for row in rows if row[0] == order)
        if not tool.startswith("foreign") and times != first[2]:
            sys.exit(f"{tool}: lap times differ from those of {first[1]}, which couples alike")


if __name__ == "__main__":
    main()
