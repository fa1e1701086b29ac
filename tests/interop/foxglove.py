"""A client of Foxglove's WebSocket protocol at `lmpc view --foxglove`. Called by foxglove.sh, inside its
network namespace.

    foxglove.py LMPC FOLDER
"""

import json
import math
import pathlib
import re
import struct
import subprocess
import threading
import time
import urllib.request

from mcap.reader import make_reader
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from programs import FAST, LMPC, OUT, end, running, start

SCENE = {"scene/track", "scene/car", "scene/prediction", "scene/safe_set", "tf"}
# What the layout of the documents draws.
LAYOUT = set(re.findall(r'"value": "([A-Z/]+)\.', pathlib.Path("docs/foxglove-layout.json").read_text())) | SCENE


def address(name, scheme):
    """The address of that kind which a program has printed."""
    for _ in range(100):
        for line in (OUT / f"{name}.txt").read_text().splitlines():
            if line.startswith(scheme):
                return line
        time.sleep(0.1)
    raise AssertionError(f"{name}: no address {scheme}: {(OUT / f'{name}.txt').read_text()}")


class Client:
    """Subscribes to every topic and keeps what comes."""

    def __init__(self, url):
        self.socket = connect(url, subprotocols=["foxglove.sdk.v1"], max_size=None, legacy=True)
        self.info = json.loads(self.socket.recv(10))
        self.topics, self.messages, self.other = {}, [], []

    def receive(self, seconds):
        """Messages as topic, log time [ns] and bytes."""
        late = time.monotonic() + seconds
        while (left := late - time.monotonic()) > 0:
            try:
                frame = self.socket.recv(left)
            except TimeoutError:
                return
            if isinstance(frame, bytes):
                if frame[0] == 1:
                    number, log_time = struct.unpack_from("<IQ", frame, 1)
                    self.messages.append((self.topics[number]["topic"], log_time, frame[13:]))
                continue
            frame = json.loads(frame)
            if frame["op"] != "advertise":
                self.other.append(frame)
                continue
            for channel in frame["channels"]:
                self.topics[channel["id"]] = channel
            new = [{"id": c["id"], "channelId": c["id"]} for c in frame["channels"]]
            self.socket.send(json.dumps({"op": "subscribe", "subscriptions": new}))

    def of(self, topic):
        return [json.loads(data) for name, _, data in self.messages if name == topic]


def frames(url, found, over):
    """Events `frame` of the page's stream."""
    name = None
    with urllib.request.urlopen(url + "/stream", timeout=10) as stream:
        for line in stream:
            line = line.decode().rstrip("\n")
            if line.startswith("event: "):
                name = line.removeprefix("event: ")
            elif line.startswith("data: ") and name == "frame":
                found.append(json.loads(line.removeprefix("data: ")))
            if over.is_set():
                return


def short(value):
    """Four digits, halves away from zero, as the page gets them."""
    if value is None or not math.isfinite(value):
        return None
    return math.copysign(math.floor(abs(value) * 1e4 + 0.5) / 1e4, value) + 0.0


def place(x, y, yaw, v):
    return tuple(None if value is None else value + 0.0 for value in (x, y, yaw, v))


def listens():
    """Addresses of this namespace at which somebody accepts connections, as /proc writes them."""
    found = set()
    for table in ("tcp", "tcp6"):
        for line in pathlib.Path(f"/proc/net/{table}").read_text().splitlines()[1:]:
            fields = line.split()
            if fields[3] == "0A":
                found.add(fields[1].split(":")[0])
    return found


def network():
    """What a car and its controller send, at 100 Hz."""
    log = OUT / "drive.log"
    log.unlink(missing_ok=True)
    record = start("record", "record", str(log))
    view = start("view", "view", "--foxglove")
    page, url = address("view", "http://"), address("view", "ws://")
    assert url == "ws://127.0.0.1:8765", url
    assert listens() == {"0100007F"}, f"reached from outside: {listens()}"
    serve, car = start("serve", "serve", *FAST), start("car", "vehicle", "sim", *FAST)
    time.sleep(12)

    client, seen, over = Client(url), [], threading.Event()
    assert client.info["name"] == "lmpc view" and client.info["capabilities"] == [], client.info
    client.receive(1)
    begun = time.time_ns()
    reader = threading.Thread(target=frames, args=(page, seen, over))
    reader.start()
    # An order of a client: the server takes nothing.
    client.socket.send(json.dumps({"op": "advertise", "channels": [{"id": 1, "topic": "OP/CMD", "encoding": "json", "schemaName": ""}]}))
    client.socket.send(b"\x01" + struct.pack("<I", 1) + b"{}")
    client.receive(5)
    over.set()
    reader.join()
    client.receive(0.5)

    by_topic = {c["topic"]: c for c in client.topics.values()}
    assert len(LAYOUT) > 7 and LAYOUT <= set(by_topic), LAYOUT - set(by_topic)
    for topic in LAYOUT:
        assert client.of(topic), f"nothing on {topic}"
    states = client.of("CAR/STATE")
    assert len(states) > 500, len(states)
    numbers = [state["h"]["seq"] for state in states]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers))), "states are missing"
    for topic, log_time, _ in client.messages:
        assert begun - 2e9 < log_time < time.time_ns(), (topic, log_time)
    sent = {place(*(short(s[k]) for k in ("x", "y", "yaw", "vx"))) for s in states}
    shown = [place(*(f["car"][k] for k in ("x", "y", "yaw", "v"))) for f in seen if "car" in f]
    assert len(set(shown)) > 150, len(shown)
    apart = [values for values in shown if values not in sent]
    assert not apart, f"{len(apart)} of {len(shown)} places of the page are of no state: {apart[:3]}"
    cubes = [u["entities"][0]["cubes"][0]["pose"]["position"] for u in client.of("scene/car")]
    drawn = {(short(p["x"]), short(p["y"])) for p in cubes}
    assert {values[:2] for values in shown} <= drawn, "the scene's car is elsewhere"
    lines = [u["entities"][0]["lines"][0]["points"] for u in client.of("scene/prediction")]
    planned = {tuple((short(p["x"]), short(p["y"])) for p in points) for points in lines}
    plans = [tuple((p[0], p[1]) for p in f["plan"]["x"]) for f in seen if f.get("plan")]
    assert len(plans) > 150 and set(plans) <= planned, "plans of the page that nobody sent"
    edges = client.of("scene/track")[0]["entities"][0]["lines"]
    assert len(edges) == 2 and all(len(edge["points"]) > 100 for edge in edges)
    print(f"ok: {len(shown)} places and {len(plans)} plans of the page are among {len(states)} states and {len(lines)} plans of the server", flush=True)

    late = Client(url)
    late.receive(2.5)
    assert late.of("scene/track"), "who comes late has no track"
    late.socket.close()
    try:
        connect(url, legacy=True)
        raise AssertionError("a connection without the protocol's name was taken")
    except InvalidStatus:
        pass
    for program in (car, serve, record):
        end(program)
    client.socket.close()
    end(view)
    exported(client, log)


def exported(client, log):
    """The log of the same drive as MCAP has the same topics, schemas and messages."""
    file = OUT / "drive.mcap"
    subprocess.run([LMPC, "export", str(log), "--mcap", str(file)], check=True, stdout=subprocess.DEVNULL)
    schemas, messages = {}, {}
    with open(file, "rb") as opened:
        for schema, channel, message in make_reader(opened).iter_messages():
            schemas[channel.topic] = (schema.name, json.loads(schema.data), schema.encoding, channel.message_encoding)
            messages.setdefault(channel.topic, set()).add(message.data)
    compared = 0
    for channel in client.topics.values():
        topic = channel["topic"]
        found = channel["schemaName"], json.loads(channel["schema"]), channel["schemaEncoding"], channel["encoding"]
        assert found == schemas[topic], topic
    assert set(schemas) == {c["topic"] for c in client.topics.values()}, set(schemas)
    for topic, _, data in client.messages:
        # The scene has the time of arrival, which each receiver takes by itself.
        if topic not in SCENE:
            assert data in messages[topic], (topic, data)
            compared += 1
    print(f"ok: {len(schemas)} topics with their schemas and {compared} messages are those of lmpc export", flush=True)


def race():
    """A race as it runs, at a port that is free."""
    view = start("race", "view", "--race", "--speed", "4", "--port", "0", "--foxglove", "0", "--set", "warm_up.laps=1")
    client = Client(address("race", "ws://"))
    client.receive(4)
    assert len(client.of("CAR/STATE")) > 20 and client.of("scene/track") and client.of("scene/car")
    client.socket.close()
    end(view)
    taken = subprocess.run([LMPC, "view", "--race", "--port", "8799", "--foxglove", "8799"], capture_output=True, text=True, timeout=20)
    assert taken.returncode == 1 and "8799" in taken.stderr, taken
    print("ok: a race as it runs", flush=True)


try:
    network()
    race()
finally:
    for program in running:
        program.kill()
