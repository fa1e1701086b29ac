"""`lmpc view` in Chromium, driven by Playwright. Called by view.sh, inside its network namespace.

    view.py LMPC FOLDER [PICTURES] [--minutes N]
"""

import pathlib
import shutil
import subprocess
import sys
import time
import urllib.error
import urllib.request

from playwright.sync_api import sync_playwright

from programs import FAST, LMPC, OUT, end, running, start

PICTURES = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 and sys.argv[3] != "--minutes" else None
MINUTES = float(sys.argv[-1]) if "--minutes" in sys.argv else 0
BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
PORT = 8711
PAGE = f"http://127.0.0.1:{PORT}"


def until(page, what, expression, seconds=20):
    """Waits until an expression is true on the page."""
    try:
        page.wait_for_function(expression, timeout=1000 * seconds)
    except Exception:
        page.screenshot(path=OUT / "failed.png", full_page=True)
        raise AssertionError(f"never: {what}; see {OUT}/failed.png") from None
    print(f"ok: {what}", flush=True)


# Colours of the pixels of every canvas: a blank one has a single colour.
COLOURS = """() => [...document.querySelectorAll('.canvas')].map((box) => {
  const all = new Set();
  for (const canvas of box.querySelectorAll('canvas')) {
    const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
    for (let i = 0; i < data.length; i += 4) if (data[i + 3] > 200) all.add(data[i] << 16 | data[i + 1] << 8 | data[i + 2]);
  }
  return all.size;
})"""
PIXELS = "() => document.querySelectorAll('#map canvas')[1].toDataURL()"
WIDTH = "() => [document.documentElement.scrollWidth, document.documentElement.clientWidth]"


def status(path, headers=None, method="GET", body=None):
    request = urllib.request.Request(PAGE + path, data=body, headers=headers or {}, method=method)
    try:
        with urllib.request.urlopen(request, timeout=10) as reply:
            return reply.status, reply.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.read().decode()


def follows(page, view):
    """A car at 100 Hz with its controller, and restarts of controller and server."""
    serve = start("serve", "serve", *FAST)
    car = start("car", "vehicle", "sim", *FAST)
    until(page, "the track is known", "() => document.getElementById('track').textContent.startsWith('l,')")
    until(page, "a lap is in the table", "() => document.querySelectorAll('#laps tbody tr').length >= 1", 40)
    until(page, "the controller runs", "() => document.getElementById('chips').innerText.includes('lmpc RUNNING')")
    time.sleep(1)
    colours = page.evaluate(COLOURS)
    assert len(colours) >= 8 and min(colours) > 3, f"blank canvases: {colours}"
    first = page.evaluate(PIXELS)
    time.sleep(0.5)
    assert page.evaluate(PIXELS) != first, "the map does not move"
    rates = []
    for _ in range(5):
        time.sleep(1.1)
        rates.append(page.evaluate("() => [Number(document.body.dataset.fps), Number(document.body.dataset.states)]"))
    frames, states = (sorted(column)[2] for column in zip(*rates))
    print(f"measured: {frames:.0f} frames a second at {states:.0f} states a second (medians of {rates})", flush=True)
    assert states > 80 and 30 <= frames <= 61, rates
    end(serve)
    until(page, "the controller's silence is seen", "() => document.getElementById('chips').innerText.includes('lmpc silent')")
    serve = start("serve", "serve", *FAST)
    until(page, "the restarted controller is followed", "() => document.getElementById('chips').innerText.includes('lmpc RUNNING')")
    begun = page.evaluate("() => document.querySelectorAll('#laps tbody tr').length")
    until(page, "its laps come", f"() => document.querySelectorAll('#laps tbody tr').length > {begun}", 40)
    end(view)
    until(page, "the server's end is seen", "() => !document.getElementById('banner').hidden")
    view = start("view", "view")
    until(page, "the restarted server is followed", "() => document.getElementById('banner').hidden && Number(document.body.dataset.fps) > 0", 20)
    until(page, "its map is drawn again", "() => document.getElementById('track').textContent.startsWith('l,')")
    return view, serve, car


def stays_small(page, view):
    """The page's heap and the server's memory while a car drives on at 100 Hz."""
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable")

    def memory():
        session.send("HeapProfiler.collectGarbage")
        metrics = {m["name"]: m["value"] for m in session.send("Performance.getMetrics")["metrics"]}
        status = pathlib.Path(f"/proc/{view.pid}/status").read_text()
        resident = next(line for line in status.splitlines() if line.startswith("VmRSS"))
        fps, states = page.evaluate("() => [document.body.dataset.fps, document.body.dataset.states]")
        found = metrics["JSHeapUsedSize"] / 1e6, int(metrics["Nodes"]), int(resident.split()[1]) / 1e3
        print("minute %4.1f: heap %.2f MB, %d nodes; server %.1f MB" % (minute, *found), f"at {fps} frames, {states} states", flush=True)
        return found

    rows = []
    for half in range(int(2 * MINUTES) + 1):
        minute = half / 2
        rows.append(memory())
        time.sleep(30)
    # The table of laps is full by then.
    settled = rows[len(rows) // 2:]
    for column, most in ((0, 2.0), (1, 500), (2, 5.0)):
        values = [row[column] for row in settled]
        assert max(values) - min(values) <= most, f"memory grows: {values}"


def fits(page):
    for width in (1200, 390, 820):
        page.set_viewport_size({"width": width, "height": 844})
        time.sleep(0.4)
        scroll, client = page.evaluate(WIDTH)
        assert scroll <= client, f"{scroll} px wide on a screen of {client} px"
    print("ok: nothing scrolls sideways at 1200, 390 and 820 px", flush=True)


def guarded():
    """Only a page from here is answered."""
    assert status("/")[0] == 200
    assert status("/", {"Host": f"evil.example:{PORT}"})[0] == 403
    assert status("/stream", {"Origin": "http://evil.example"})[0] == 403
    assert status("/stream", {"Sec-Fetch-Site": "cross-site"})[0] == 403
    assert status("/../Cargo.toml")[0] == 404
    order = b'{"order": "estop"}'
    assert status("/order", {"Origin": PAGE, "X-Lmpc-Token": "0" * 32}, "POST", order)[0] == 403
    print("ok: foreign requests and orders are refused", flush=True)


def ordered(browser):
    """An operator with the key of the network arms, starts and stops a bridge."""
    key = OUT / "lmpc.key"
    subprocess.run([LMPC, "--quiet", "key", "new", key], check=True, stdout=subprocess.DEVNULL)
    without = subprocess.run([LMPC, "view", "--operator"], capture_output=True, text=True)
    assert without.returncode == 2 and "key" in without.stderr, without
    keyed = ["--key", str(key)]
    bridge = start("bridge", "bridge", "--black-box", "off", *FAST, *keyed)
    serve = start("serve", "serve", *FAST, *keyed)
    (OUT / "operator.txt").unlink(missing_ok=True)
    view = start("operator", "view", "--operator", *keyed)
    for _ in range(100):
        address = (OUT / "operator.txt").read_text().split("\n")[0]
        if "#operator=" in address:
            break
        time.sleep(0.1)
    order = b'{"order": "arm"}'
    assert status("/order", {"Origin": PAGE, "X-Lmpc-Token": "0" * 32}, "POST", order)[0] == 403
    page = browser.new_page()
    page.goto(address)
    until(page, "bridge and controller are there", "() => /bridge IDLE/.test(document.getElementById('chips').innerText) && /lmpc (IDLE|RUNNING)/.test(document.getElementById('chips').innerText)")
    assert "#" not in page.url
    for name, state in (("arm", "ARMED"), ("start", "RUNNING")):
        for _ in range(20):
            page.hover(f"[data-order={name}]")
            page.mouse.down()
            time.sleep(1)
            page.mouse.up()
            until(page, f"{name} is answered", "() => /^[✓✕]/.test(document.getElementById('answer').textContent)", 10)
            if page.inner_text("#answer").startswith("✓"):
                break
        until(page, f"{name}: {page.inner_text('#answer')}", f"() => document.getElementById('chips').innerText.includes('bridge {state}')")
    page.locator("#estop").dispatch_event("pointerdown")
    until(page, "an emergency stop is obeyed", "() => document.getElementById('chips').innerText.includes('bridge ESTOP')")
    page.set_viewport_size({"width": 390, "height": 844})
    scroll, client = page.evaluate(WIDTH)
    assert scroll <= client, (scroll, client)
    page.close()
    for program in (view, serve, bridge):
        end(program)


def main():
    assert BROWSER, "no chromium; tools/setup.sh test installs it"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1200, "height": 900})
        problems = []
        # While the server is away the browser itself writes that it does not reach it.
        page.on("console", lambda m: m.type in ("error", "warning") and "ERR_" not in m.text and problems.append(m.text))
        page.on("pageerror", lambda error: problems.append(str(error)))
        record = start("record", "record", str(OUT / "drive.log"))
        view = start("view", "view")
        for _ in range(100):
            try:
                page.goto(PAGE)
                break
            except Exception:
                time.sleep(0.1)
        until(page, "the page opens and waits", "() => document.getElementById('waiting').textContent.startsWith('Waiting for messages')")
        view, serve, car = follows(page, view)
        guarded()
        if MINUTES:
            stays_small(page, view)
        fits(page)
        for program in (car, serve, record, view):
            end(program)
        page.set_viewport_size({"width": 1200, "height": 900})
        view = start("log", "view", "--log", str(OUT / "drive.log"), "--speed", str(20 + 60 * MINUTES), "--at", "20")
        until(page, "a log is shown to its end", "() => document.getElementById('banner').textContent === 'end of the log'", 30)
        assert page.evaluate("() => document.querySelectorAll('#laps tbody tr').length") >= 2
        end(view)
        view = start("race", "view", "--race", "--speed", "8", "--laps", "40", "--set", "warm_up.laps=2")
        until(page, "a race is shown as it runs", "() => document.querySelectorAll('#laps tbody tr').length >= 5", 40)
        until(page, "with the time-optimal lap", "() => document.getElementById('n-optimum').textContent !== '–'")
        if PICTURES:
            until(page, "it is faster", "() => document.querySelectorAll('#laps tbody tr').length >= 10", 40)
            page.set_viewport_size({"width": 1200, "height": 990})
            until(page, "half a lap", "() => Number(document.getElementById('n-time').textContent) > 1.8")
            PICTURES.mkdir(parents=True, exist_ok=True)
            page.screenshot(path=PICTURES / "view-desktop.png")
            page.set_viewport_size({"width": 390, "height": 844})
            until(page, "half a lap again", "() => Math.abs(Number(document.getElementById('n-time').textContent) - 1.9) < 0.2")
            page.screenshot(path=PICTURES / "view-phone.png")
        end(view)
        page.close()
        ordered(browser)
        assert not problems, problems
        browser.close()
    print("ok: no error in the console", flush=True)


try:
    main()
finally:
    for program in running:
        program.kill()
