#!/usr/bin/python3
"""How fast the console's page shows a large cloud, and how soon its Stop is confirmed.

  console_page.py --bin FOLDER [--points N] [--runs N] [--presses N] [--folder FOLDER]

A shop of real processes with one job of random points that waits for its arm; Debian's
chromium draws it without a graphics card (SwiftShader). Each run is a new page, and counts
from the press on the job. The presses of Stop are the browser's own input, while the view turns
and another client fetches the plan again and again; "sent" counts from the time of the press
as the browser states it, "shown" to the page's line that the machine fires no pulse.
Needs chromium, chromium-driver and python3-selenium.
"""
import argparse
import contextlib
import os
import pathlib
import random
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from console_browser import missing, open_browser  # noqa: E402
from patience import eventually  # noqa: E402

BLOCK_MM, MARGIN_MM = 60, 5

TURN = """
const canvas = document.querySelector('canvas');
const send = (kind, x) => {
  const event = new PointerEvent(kind, {pointerId: 1, clientX: x, clientY: 200});
  canvas.dispatchEvent(event);
};
canvas.setPointerCapture = () => {};
send('pointerdown', 0);
let x = 0;
window.turning = setInterval(() => send('pointermove', x += 3), 16);
"""

WATCH_STOP = """
window.presses = [];
let pressed = 0, sent = 0;
const button = document.getElementById('stop');
button.addEventListener('pointerdown', (event) => { pressed = event.timeStamp; }, true);
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function (data) {
  const answer = send.call(this, data);
  if (pressed && String(data).includes('"stop"')) sent = performance.now();
  return answer;
};
new MutationObserver(() => {
  const line = document.querySelector('stop-button span').textContent;
  if (!pressed || !sent || !line.includes('no pulse is fired')) return;
  window.presses.push([sent - pressed, performance.now() - sent]);
  pressed = sent = 0;
}).observe(document.querySelector('stop-button'),
           {subtree: true, childList: true, characterData: true});
"""


def quantile(values, share):
    return sorted(values)[min(len(values) - 1, int(share * len(values)))]


def random_cloud(path, count):
    """Points of a cube, in millimetres, as text."""
    generator = random.Random(20261129)
    with open(path, "w") as out:
        for _ in range(count):
            out.write("%.3f %.3f %.3f\n" % tuple(
                generator.uniform(MARGIN_MM, BLOCK_MM - MARGIN_MM) for _ in range(3)))


def started_by(parent):
    """The process and all that it has started, directly or through others."""
    processes = [parent]
    for process in processes:
        try:
            processes += [int(child) for task in pathlib.Path(f"/proc/{process}/task").iterdir()
                          for child in (task / "children").read_text().split()]
        except OSError:
            pass  # it has ended
    return processes


def memory_mb(driver, kind):
    """Of the largest process of this kind of the browser, what is its own (PSS). Beside the
    renderer of a page chromium has another one ready, which has none."""
    largest = 0
    for process in started_by(driver.service.process.pid):
        try:
            place = pathlib.Path(f"/proc/{process}")
            if f"--type={kind}".encode() in (place / "cmdline").read_bytes():
                largest = max(largest, int(next(
                    line for line in (place / "smaps_rollup").read_text().splitlines()
                    if line.startswith("Pss:")).split()[1]))
        except OSError:
            pass  # it has ended
    return largest / 1000


def console_mb(folder):
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().split(b"\0")
            if words[0].endswith(b"intaglio-console") and \
                    str(folder / "shop/console.address").encode() in words:
                return int(next(line for line in (process / "status").read_text().splitlines()
                                if line.startswith("VmHWM")).split()[1]) / 1000
        except OSError:
            pass
    return 0


def show(driver, url):
    """A new page shows the job; the seconds until each mark, from the press on it."""
    from selenium.webdriver.common.by import By

    driver.get(url)

    def button():
        found = driver.find_elements(By.CSS_SELECTOR, "job-list li button")
        return found and found[0].is_displayed() and found[0]

    driver.execute_script("performance.mark('press'); arguments[0].click();",
                          eventually(button, 60))

    def marks():
        found = driver.execute_script(
            "return performance.getEntriesByType('mark').map((m) => [m.name, m.startTime])")
        at = {name.split(": ")[-1]: when for name, when in found}
        return "all drawn" in at and at

    at = eventually(marks, 300)
    return {name: (at[name] - at["press"]) / 1000 for name in
            ("first picture", "loaded", "all drawn")}


def frames_while_turning(driver, seconds=6):
    frames = "const d = document.querySelector('glass-view').dataset;" \
             "return [performance.now(), Number(d.frames), Number(d.budget)]"
    driver.execute_script(TURN)
    time.sleep(3)  # the number of points follows the time of a frame
    begin = driver.execute_script(frames)
    time.sleep(seconds)
    end = driver.execute_script(frames)
    return 1000 * (end[1] - begin[1]) / (end[0] - begin[0]), end[2]


@contextlib.contextmanager
def bulk_transfer(url):
    """Another client reads the plan again and again."""
    address, key = url.split("/?key=")
    ended = threading.Event()

    def fetch():
        while not ended.is_set():
            subprocess.run(["curl", "-s", "-H", f"Authorization: Bearer {key}", "-o",
                            "/dev/null", f"{address}/api/v1/jobs/1/plan"], check=True)

    thread = threading.Thread(target=fetch)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def press_stop(driver, intaglio, place, count):
    from selenium.webdriver.common.by import By

    driver.execute_script(WATCH_STOP)
    for press in range(count):
        driver.find_element(By.ID, "stop").click()
        eventually(lambda: driver.execute_script("return window.presses.length") > press, 20)
        subprocess.run([intaglio, "stop", "els-03", "--reset", *place], check=True,
                       stdout=subprocess.DEVNULL)
        time.sleep(0.3)
    return driver.execute_script("return window.presses")


def measure(given, folder, driver, place):
    intaglio = pathlib.Path(given.bin) / "intaglio"
    url = next(line.split()[-1] for line in (folder / "up.txt").read_text().splitlines()
               if line.startswith("web console: "))
    runs = [show(driver, url) for _ in range(given.runs)]
    print(f"{given.points} points, {given.runs} pages, load {os.getloadavg()[0]:.1f}")
    for name in runs[0]:
        times = [run[name] for run in runs]
        print(f"{name}: median {statistics.median(times):.2f} s, most {max(times):.2f} s")
    print(f"memory: renderer {memory_mb(driver, 'renderer'):.0f} MB, GPU process "
          f"{memory_mb(driver, 'gpu-process'):.0f} MB, console {console_mb(folder):.0f} MB")
    rate, budget = frames_while_turning(driver)
    print(f"while the view turns: {rate:.1f} frames a second of {budget} points")
    with bulk_transfer(url):
        presses = press_stop(driver, intaglio, place, given.presses)
    parts = {"press to sent": [press[0] for press in presses],
             "sent to shown": [press[1] for press in presses],
             "press to shown": [sum(press) for press in presses]}
    for name, times in parts.items():
        print(f"stop, {name}: median {statistics.median(times):.1f} ms, p99 "
              f"{quantile(times, 0.99):.1f} ms, most {max(times):.1f} ms of {len(times)}")


def bench_arguments(description, **counts):
    """What a bench of the console is given: programs, a folder, and these numbers."""
    parser = argparse.ArgumentParser(description=description,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", required=True, help="folder of the programs")
    for name, default in counts.items():
        parser.add_argument(f"--{name}", type=int, default=default)
    parser.add_argument("--folder", type=pathlib.Path)
    return parser.parse_args()


def main():
    given = bench_arguments(__doc__, points=1000000, runs=5, presses=60)
    if missing():
        print("not installed:", ", ".join(missing()), file=sys.stderr)
        return 2
    folder = given.folder or pathlib.Path(tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    random_cloud(folder / "cloud.xyz", given.points)
    place = ["--domain", "48", "--tag", f"page{os.getpid()}"]
    block = [str(BLOCK_MM)] * 3
    log = open(folder / "up.txt", "w")
    up = subprocess.Popen([f"{given.bin}/intaglio", "up", "--console", "--folder",
                           folder / "shop", "--materials", folder / "materials.db", "--block",
                           *block, *place], stdout=log, stderr=log)
    driver = None
    try:
        eventually(lambda: "the shop is open" in (folder / "up.txt").read_text(), 60)
        subprocess.run([f"{given.bin}/intaglio", "submit", folder / "cloud.xyz", "--block",
                        *block, *place], check=True)

        def waits():
            listed = subprocess.run([f"{given.bin}/intaglio", "list", "--json", *place],
                                    stdout=subprocess.PIPE, text=True).stdout
            assert '"state": "failed"' not in listed and '"state":"failed"' not in listed, listed
            return "waiting_for_arm" in listed

        eventually(waits, 600)
        driver = open_browser()
        measure(given, folder, driver, place)
    finally:
        if driver:
            driver.quit()
        up.send_signal(signal.SIGINT)
        up.wait(60)
        if not given.folder:
            shutil.rmtree(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
