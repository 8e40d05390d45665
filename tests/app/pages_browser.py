#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The pages of `view` and `report` in a headless browser: on a desk's screen and a telephone's, by day and by
night. What is asserted is asked of the page; a picture of each stays in FOLDER/pictures to be looked at. By
day it is taken when all is drawn, where LOOK is in the environment: software draws for half a minute.
Skipped (77) where there is no Chromium.

  LOOK=1 pages_browser.py SPLINEVOX FOLDER
"""
import http.server
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import threading

SCREENS = {"desk": (1280, 800), "telephone": (390, 844)}

# Common to both pages: nothing is wider than the screen, and the page is as dark as was asked for.
WHOLE = """
  await until(() => document.readyState !== "loading");
  result.wide = [document.documentElement.scrollWidth, innerWidth];
  const bright = e => getComputedStyle(e).backgroundColor.match(/[0-9.]+/g).slice(0, 3)
    .reduce((sum, v) => sum + Number(v), 0) / 765;
  result.bright = bright(document.body);
"""
VIEW = """
  const $$ = id => document.getElementById(id), seen = e => getComputedStyle(e).visibility === "visible" &&
    getComputedStyle(e).display !== "none";
  result.loading = [seen($$("poster")), seen($$("canvas"))];
  const app = await splinevox;
  await until(() => !document.body.classList.contains("loading"));
  result.drawn = [seen($$("poster")), seen($$("canvas"))];
  result.start = [app.header.start.view, app.state.view];
""" + WHOLE + """
  result.stage = bright($$("stage"));
  result.boxes = [...document.querySelectorAll("#panel button, #panel input, #panel select")]
    .filter(e => e.offsetParent).map(e => e.getBoundingClientRect())
    .map(b => [b.left, b.top, b.right, b.bottom]);
  app.goTo(app.header.start.view);
  document.querySelector("#layers button[data-layer=flow]").click();
  result.legend = $$("legend").innerText;
  document.querySelector("#layers button[data-layer=rigidity]").click();
  result.moves = $$("legend").innerText;
  document.querySelector("#layers button[data-layer=rgb]").click();
  result.bare = $$("legend").hidden;
  document.querySelector("#layers button[data-layer=depth]").click();
  result.depth = $$("legend").innerText;
  app.compare();
  const patience = performance.now() + PATIENCE;
  if (!matchMedia("(prefers-color-scheme: dark)").matches)
    await until(() => app.painter.nextRow >= app.canvas.height || performance.now() > patience);
  result.truth = $$("truth").innerText;
"""
PLAYS = """
  const app = await splinevox;
  await until(() => app.state.playing);
  result.from = app.header.start.time;
  await until(() => !app.state.playing);
  result.rests = app.state.time;
  let file = null;
  HTMLAnchorElement.prototype.click = function() { file = [this.download, fetch(this.href)]; };
  document.getElementById("record").click();
  result.begins = [app.state.time, document.getElementById("record").getAttribute("aria-pressed")];
  await until(() => file);
  const film = await (await file[1]).blob();
  result.film = [file[0], film.type, film.size, app.state.time];
"""
NO_WEBGL = """
  result.app = await splinevox;
  const seen = id => getComputedStyle(document.getElementById(id)).display !== "none";
  result.seen = [seen("poster"), seen("problem"), seen("panel")];
  result.problem = document.getElementById("problem").innerText;
"""
REPORT = WHOLE + """
  const box = e => e.getBoundingClientRect();
  result.facts = document.querySelector(".facts").innerText;
  result.links = [...document.querySelectorAll(".links a")].map(a => a.getAttribute("href"));
  result.colours = [...document.querySelectorAll("canvas[data-chart]")].map(c =>
    JSON.parse(c.dataset.chart).series.map(s => s.color));
  const charts = [...document.querySelectorAll(".chart")].map(box);
  result.filled = charts.every(c => charts.filter(o => o.top === c.top).reduce((w, o) => w + o.width, 0) >
    0.9 * box(document.querySelector(".charts")).width);
  const pictures = [...document.querySelectorAll(".views img")];
  result.small = Math.min(...pictures.map(p => box(p).width));
  result.captions = [...document.querySelectorAll(".views .row")][0].innerText;
  pictures[1].closest("button").click();
  const large = document.querySelector("#large img");
  await until(() => large.complete);
  result.large = [box(large).width, large.alt];
  large.click();
  result.next = large.alt;
  document.querySelector("#large button").click();
  result.closed = !document.getElementById("large").open;
  const drawn = c => c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
  result.dots = [...document.querySelectorAll("canvas")].map(c =>
    drawn(c).filter((value, i) => i % 4 == 3 && value > 0).length);
  result.fetched = performance.getEntriesByType("resource").map(r => r.name).filter(name =>
    !name.startsWith("data:") && !name.endsWith("/hold"));
"""


class Shown(http.server.BaseHTTPRequestHandler):
    """The page with a script behind it. It is not loaded before the script has posted its result."""

    def do_GET(self):
        if self.path == "/hold":
            self.server.done.wait(400)
        body = {"/": self.server.frame, "/page": self.server.page}.get(self.path, b"")
        self.send_response(200)
        self.send_header("Content-Type", "text/html; charset=utf-8" if body else "image/png")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def do_POST(self):
        text = self.rfile.read(int(self.headers["Content-Length"]))
        self.server.result = json.loads(text)
        self.do_GET()
        self.server.done.set()

    def log_message(self, *_):
        pass


def opened(browser, folder, name, page, script, screen, dark, before=""):
    """What `script` found on the page, and a picture of it under that name."""
    added = ('<img src="/hold" hidden alt=""><script>(async () => { const result = {};\n'
             f"const PATIENCE = {45000 if 'LOOK' in os.environ else 0};\n"
             "const until = async test => { while (!test()) await new Promise(r => setTimeout(r, 30)); };\n"
             f"try {{ {script} }} catch (e) {{ result.thrown = String(e.stack); }}\n"
             'await fetch("/result", {method: "POST", body: JSON.stringify(result)}); })();</script>')
    text = page.replace("<body", before + "<body", 1)
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Shown)
    server.page = text.replace("</body>", added + "</body>").encode()
    width, height = screen  # of a frame: a window is no narrower than 500 pixels
    server.frame = (f'<!doctype html><style>:root {{ color-scheme: light dark }} body {{ margin: 0 }}</style>'
                    f'<iframe src="/page" allow="fullscreen" style="border: 0; width: {width}px; '
                    f'height: {height}px"></iframe>').encode()
    server.done, server.result = threading.Event(), None
    threading.Thread(target=server.serve_forever, daemon=True).start()
    picture = folder / "pictures" / f"{name}.png"
    ended = subprocess.run(
        ["timeout", "420", browser, "--headless=new", "--no-sandbox", "--use-gl=angle",
         "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--enable-logging=stderr",
         "--hide-scrollbars", "--timeout=410000", f"--window-size={width},{height}",
         f"--blink-settings=preferredColorScheme={0 if dark else 1}", f"--user-data-dir={folder / 'profile'}",
         f"--screenshot={picture}", f"http://127.0.0.1:{server.server_address[1]}/"],
        capture_output=True, text=True, check=False)
    server.shutdown()
    said = [line for line in ended.stderr.splitlines() if "CONSOLE" in line and "ReadPixels" not in line]
    assert not said, f"{name}: the browser's console is not empty: {said}"
    assert server.result is not None, f"{name}: the page did not answer:\n{ended.stderr[-2000:]}"
    assert "thrown" not in server.result, f"{name}: {server.result['thrown']}"
    assert struct.unpack(">II", picture.read_bytes()[16:24]) == screen, f"{name}: a picture of another size"
    return server.result


def check_view(r, name, screen, dark):
    assert r["loading"] == [True, False], f"{name}: before it has drawn, poster and canvas: {r['loading']}"
    assert r["drawn"] == [False, True], f"{name}: once it has drawn: {r['drawn']}"
    assert r["start"][0] == r["start"][1] >= 0, f"{name}: it begins elsewhere: {r['start']}"
    assert r["wide"][0] <= r["wide"][1] == screen[0], f"{name}: wider than the screen: {r['wide']}"
    for box in r["boxes"]:
        assert box[0] >= 0 and box[2] <= r["wide"][1], f"{name}: a control is off the screen: {box}"
    assert (r["bright"] < 0.4) == dark and (r["stage"] < 0.4) == dark, f"{name}: {r['bright']}, {r['stage']}"
    assert "displacement" in r["legend"] and "scene units" in r["legend"], f"{name}: {r['legend']}"
    assert "1 moves" in r["moves"] and r["bare"], f"{name}: {r['moves']}"
    near, far = r["depth"].split()[1], r["depth"].split()[-1]
    assert 0 <= float(near) < float(far), f"{name}: {r['depth']}"
    assert r["truth"].startswith("truth: test view "), f"{name}: {r['truth']}"


def check_report(r, name, screen, dark):
    assert r["wide"][0] <= r["wide"][1], f"{name}: wider than the screen: {r['wide']}"
    assert (r["bright"] < 0.4) == dark, f"{name}: {r['bright']}"
    for fact in ("data set", "scene", "fingerprint", "trained", "splinevox", "command", "--max-steps"):
        assert fact in r["facts"], f"{name}: {fact} is not on it: {r['facts']}"
    assert r["links"] == ["run/a%20film.mp4", "view.html"], f"{name}: {r['links']}"
    assert all(len(set(c)) == len(c) for c in r["colours"]), f"{name}: two series of one colour"
    assert r["filled"], f"{name}: a column of charts is empty"
    assert len(r["dots"]) == 3 and min(r["dots"]) > 500, f"{name}: dots of charts: {r['dots']}"
    assert not r["fetched"], f"{name}: the page fetches {r['fetched']}"
    assert r["small"] >= 130, f"{name}: pictures of {r['small']} pixels"
    assert "displacement" in r["captions"] and "what moves" in r["captions"], f"{name}: {r['captions']}"
    assert r["large"][0] >= 0.95 * min(screen), f"{name}: enlarged to {r['large']}"
    assert "render of test view" in r["large"][1] and "error of" in r["next"] and r["closed"], f"{name}: {r}"


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    found = [shutil.which(b) for b in ("chromium", "chromium-browser", "google-chrome")]
    browser = next((b for b in found if b), None)
    if not browser:
        print("skipped: there is no Chromium here (apt-get install chromium)")
        sys.exit(77)
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "pictures").mkdir(parents=True)

    def splinevox(*words):
        ended = subprocess.run([program, *words], cwd=folder, check=True, capture_output=True, text=True)
        return ended.stdout

    splinevox("synth", "dancer", "--out", "scene", "--size", "64", "--frames", "24")
    splinevox("train", "scene", "--out", "run", "--preset", "draft", "--max-steps", "100", "--quiet",
              "--effects", "motion,rigidity", "--set", "sampling.rays=1024",
              "--set", "grid.radiance=16,24,32", "--set", "grid.motion=4,8",
              "--set", "grid.motion_start=0,0.2", "--set", "sampling.occupancy_cells=24")
    assert "test view" in splinevox("eval", "run")
    (folder / "run" / "a film.mp4").write_bytes(b"beside it")
    splinevox("view", "run", "--out", "view.html")
    splinevox("report", "run", "--out", "report.html", "--views", "3")
    view, report = (folder / "view.html").read_text(), (folder / "report.html").read_text()
    for screen, size in SCREENS.items():
        for dark in (False, True):
            for what, page, script, check in (("view", view, VIEW, check_view),
                                              ("report", report, REPORT, check_report)):
                name = f"{what}_{screen}_{'dark' if dark else 'light'}"
                check(opened(browser, folder, name, page, script, size, dark), name, size, dark)
    r = opened(browser, folder, "view_plays", view, PLAYS, (320, 320), False)
    assert r["rests"] == r["from"], f"it does not rest where it began: {r}"
    assert r["begins"] == [0, "true"] and r["film"][3] == 1, f"a film is of all of time: {r}"
    assert "webm" in r["film"][1] and r["film"][2] > 2000, f"no film: {r['film']}"
    no_webgl = "<script>HTMLCanvasElement.prototype.getContext = () => null;</script>"
    r = opened(browser, folder, "view_no_webgl", view, NO_WEBGL, SCREENS["telephone"], False, no_webgl)
    assert r["app"] is None and r["seen"] == [True, True, False] and "WebGL 2" in r["problem"], str(r)
    print(f"pictures: {folder / 'pictures'}")


if __name__ == "__main__":
    main()
