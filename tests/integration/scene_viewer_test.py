#!/usr/bin/python3
"""The scene of a recording in Rerun's viewer: planned points turn into cracks along its time.

  scene_viewer_test.py --intaglio PROGRAM --folder FOLDER --viewer FOLDER_OF_ITS_PACKAGE

Needs chromium, chromium-driver, python3-selenium and the viewer's package of npm; ends with 77
(skipped) without them. The pictures are left in the folder.
"""
import argparse
import base64
import datetime
import functools
import http.server
import io
import json
import pathlib
import shutil
import subprocess
import sys
import threading

from console_browser import missing, open_browser
from console_browser_test import pixels
from patience import eventually

PAGE = """<!doctype html><body style="margin:0;height:100vh"><script type="module">
import { WebViewer } from "/index.js";
window.viewer = new WebViewer();
await viewer.start(location.origin + "/scene.mcap", document.body, {
  width: "100%", height: "100%", render_backend: "webgl", hide_welcome_screen: true});
</script>"""

# Sets the time to a share of the time line of the recording. The viewer reads the file
# meanwhile: false until it has a time line.
SET_TIME = """
const id = viewer.get_active_recording_id();
const line = id && viewer.get_active_timeline(id);
const range = line && viewer.get_time_range(id, line);
if (!range || range.max <= range.min) return false;
viewer.set_playing(id, false);
viewer.set_current_time(id, line, range.min + arguments[0] * (range.max - range.min));
return true;"""


class Handler(http.server.SimpleHTTPRequestHandler):
    """The viewer's package; its page imports a module without its ending."""
    extensions_map = {".js": "text/javascript", ".html": "text/html", ".wasm": "application/wasm",
                      "": "application/octet-stream"}

    def __init__(self, *args, scene, **more):
        self.scene = scene
        super().__init__(*args, **more)

    def translate_path(self, path):
        if path == "/scene.mcap":
            return str(self.scene)
        found = super().translate_path(path)
        return found + ".js" if pathlib.Path(found + ".js").exists() else found

    def do_GET(self):
        if self.path != "/":
            return super().do_GET()
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        shutil.copyfileobj(io.BytesIO(PAGE.encode()), self.wfile)

    def log_message(self, *args):
        pass


# The view of the cloud in the viewer's page, at half its size: fewer pixels to read.
VIEW = {"x": 210, "y": 60, "width": 870, "height": 530, "scale": 0.5}


def picture(driver):
    taken = driver.execute_cdp_cmd("Page.captureScreenshot", {"format": "png", "clip": VIEW})
    return base64.b64decode(taken["data"])


def blue(png):
    """How many of its pixels are those of cracks."""
    return sum(b - r > 100 and b > 150 for row in pixels(png) for r, _, b in row)


def half_time(intaglio, session, scene):
    """The share of the scene's time at which half of the pulses were reported: before it the
    computer ordered and planned for as long as it took."""
    def output(*words):
        return subprocess.run([intaglio, "recording", *words], check=True, timeout=60,
                              capture_output=True, text=True).stdout

    info = json.loads(output("info", scene, "--json"))
    begin = datetime.datetime.fromisoformat(info["start_utc"]).timestamp()
    lines = output("export", session, "--topic", "PulseEventBatch").splitlines()
    reports = [json.loads(line) for line in lines]
    at = reports[len(reports) // 2]["log_time_ns"] / 1e9
    return (at - begin) / info["duration_s"]


def main():
    parser = argparse.ArgumentParser()
    for name in ("--intaglio", "--folder", "--viewer"):
        parser.add_argument(name, required=True, type=pathlib.Path)
    given = parser.parse_args()
    absent = missing() + ([] if (given.viewer / "index.js").exists() else ["@rerun-io/web-viewer"])
    if absent:
        print("not installed: " + ", ".join(absent))
        return 77
    shutil.rmtree(given.folder, ignore_errors=True)
    given.folder.mkdir(parents=True)
    run, scene = given.folder / "run", given.folder / "scene.mcap"
    for words in (["run", "sample", "--lockstep", "--out", run],
                  ["recording", "export", run / "session.mcap", "--format", "foxglove",
                   "--out", scene]):
        subprocess.run([given.intaglio, *words], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL, timeout=120)
    server = http.server.ThreadingHTTPServer(
        ("127.0.0.1", 0), functools.partial(Handler, scene=scene, directory=given.viewer))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    driver = open_browser(1400, 950)
    try:
        driver.get(f"http://127.0.0.1:{server.server_port}/")

        def shows(share, what):
            """The number of blue pixels at that share of the time, once it is as expected and
            has settled: the viewer draws while it reads, and moves the points at rest by parts
            of a pixel."""
            found = []

            def is_so():
                if not driver.execute_script("return window.viewer?.ready === true"):
                    return False
                if not driver.execute_script(SET_TIME, share):
                    return False
                png = picture(driver)
                (given.folder / f"{round(100 * share)}.png").write_bytes(png)
                found.append(blue(png))
                last = found[-3:]
                settled = len(last) == 3 and max(last) - min(last) <= 0.01 * max(last)
                return settled and what(last[-1])

            try:
                eventually(is_so)
            except AssertionError:
                raise AssertionError(f"{found[-3:]} blue pixels at {share:.0%} of the time") from None
            return found[-1]

        end = shows(1, lambda count: count > 1000)
        assert shows(0, lambda count: count < 0.05 * end) < end
        shows(half_time(given.intaglio, run / "session.mcap", scene),
              lambda count: 0.05 * end < count < 0.95 * end)
    finally:
        driver.quit()
        server.shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
