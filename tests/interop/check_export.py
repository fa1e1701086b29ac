"""Compares what `lmpc export` made of a log with what lcm-gen's Python classes decode from it.

    check_export.py TYPES LOG MCAP TABLES
"""

import collections
import csv
import json
import math
import pathlib
import struct
import sys

import lcm
from mcap.reader import make_reader

from generated import classes

TYPES, LOG, MCAP, TABLES = sys.argv[1:]
known = {c._get_packed_fingerprint(): (name, c) for name, c in classes(TYPES).items()}
csv.field_size_limit(1 << 30)


def same_number(found, sent, kind):
    """Singles are compared as singles: a table holds their shortest digits."""
    if kind == "float" and math.isfinite(sent):
        return struct.pack(">f", found) == struct.pack(">f", sent)
    return found == sent


def same(found, sent, kind):
    """True if JSON equals a decoded value."""
    if hasattr(sent, "__slots__"):
        members = zip(sent.__slots__, sent.__typenames__)
        return set(found) == set(sent.__slots__) and all(
            same(found[m], getattr(sent, m), k) for m, k in members
        )
    if isinstance(sent, (list, tuple)):
        return len(found) == len(sent) and all(map(same, found, sent, [kind] * len(sent)))
    if isinstance(sent, float):
        return found is None if not math.isfinite(sent) else same_number(found, sent, kind)
    return type(found) is type(sent) and found == sent


def cells(sent, kind, name, out):
    """The single values of a message by the paths that name the columns."""
    if hasattr(sent, "__slots__"):
        for member, inner in zip(sent.__slots__, sent.__typenames__):
            cells(getattr(sent, member), inner, f"{name}.{member}" if name else member, out)
    elif isinstance(sent, (list, tuple)) and len(sent) > 256:
        out[name] = (list(sent), kind)
    elif isinstance(sent, (list, tuple)):
        for i, value in enumerate(sent):
            cells(value, kind, f"{name}[{i}]", out)
    else:
        out[name] = (sent, kind)


def same_cell(text, sent, kind):
    if isinstance(sent, list):
        return same(json.loads(text), sent, kind)
    if isinstance(sent, str):
        return text == sent
    if isinstance(sent, float):
        return math.isnan(sent) and math.isnan(float(text)) or same_number(float(text), sent, kind)
    return int(text) == int(sent)


messages = collections.defaultdict(list)
for event in lcm.EventLog(LOG):
    if event.channel != "LCM_SELF_TEST":
        name, kind = known[event.data[:8]]
        messages[event.channel].append((event.timestamp, name, kind.decode(event.data)))

derived = collections.Counter()
exported = collections.defaultdict(list)
with open(MCAP, "rb") as file:
    reader = make_reader(file, validate_crcs=True)
    for schema, channel, message in reader.iter_messages(log_time_order=False):
        assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
        assert json.loads(schema.data)["title"] == schema.name
        if schema.name.startswith("foxglove."):
            derived[channel.topic] += 1
        else:
            value = json.loads(message.data)
            exported[channel.topic].append((message.log_time, schema.name, value))
assert set(exported) == set(messages), set(exported) ^ set(messages)
values = 0
for channel, sent in sorted(messages.items()):
    assert len(exported[channel]) == len(sent), channel
    for (log_time, name, found), (utime, expected, message) in zip(exported[channel], sent):
        assert (log_time, name) == (utime * 1000, expected), channel
        assert same(found, message, name), (channel, found)
    with open(pathlib.Path(TABLES) / (channel.replace("/", "_") + ".csv"), newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(sent), channel
    for row, (utime, _, message) in zip(rows, sent):
        assert row.pop("time_s") == f"{utime // 10**6}.{utime % 10**6:06}"
        expected = {}
        cells(message, None, "", expected)
        assert all(row[name] == "" for name in set(row) - set(expected)), channel
        for name, (value, kind) in expected.items():
            assert same_cell(row[name], value, kind), (channel, name, row[name], value)
        values += len(expected)
    print(f"{len(sent):6} {channel}: equal in MCAP and CSV")
states, steps = len(messages["CAR/STATE"]), len(messages["LMPC/TELEM"])
assert derived["scene/car"] == derived["tf"] == states, derived
assert derived["scene/prediction"] == derived["scene/safe_set"] == steps, derived
assert derived["scene/track"] == 1, derived
print(f"{values} values equal; {sum(derived.values())} messages of the scene")
