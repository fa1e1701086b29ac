"""Decodes every message of a log with lcm-gen's Python classes and counts them by channel.

    decode_log.py TYPES LOG LAPS

Fails on a message of a type that is not known or does not decode, if the channels of a drive are not
all there, or if there are fewer than LAPS results of valid laps.
"""

import collections
import sys

import lcm

from generated import classes

TYPES, LOG, LAPS = sys.argv[1], sys.argv[2], int(sys.argv[3])
known = {c._get_packed_fingerprint(): (name, c) for name, c in classes(TYPES).items()}
counts = collections.Counter()
laps = []
for event in lcm.EventLog(LOG):
    if event.channel == "LCM_SELF_TEST":
        continue
    name, kind = known[event.data[:8]]
    message = kind.decode(event.data)
    assert message.encode() == event.data, f"{event.channel}: encoded otherwise"
    counts[f"{event.channel} ({name})"] += 1
    if event.channel == "LMPC/LAP":
        laps.append(message)
for channel, count in sorted(counts.items()):
    print(f"{count:6} {channel}")
valid = [lap for lap in laps if lap.valid]
print(f"{len(valid)} of {len(laps)} laps valid, best {min(lap.lap_time for lap in valid):.3f} s")
for channel in ("CAR/STATE", "CAR/ACT", "LMPC/CMD", "LMPC/TELEM", "LMPC/LAP", "HB/lmpc"):
    assert any(seen.startswith(channel + " ") for seen in counts), f"nothing on {channel}"
# The last lap ends with the drive: its result may be cut off.
assert len(valid) == len(laps) >= LAPS - 1, [lap.lap for lap in laps]
