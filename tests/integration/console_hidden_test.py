#!/usr/bin/python3
"""A page of the console that nobody sees, as on a tablet that sleeps, costs nothing: it keeps no
connection, draws nothing and takes no processor time; once it is shown it is whole again, and
nothing has started by it. The same of one that was opened in the background.

  console_hidden_test.py --intaglio PROGRAM --folder FOLDER

Needs chromium, chromium-driver and python3-selenium; ends with 77 (skipped) without them.
"""
import os
import pathlib
import re
import signal
import subprocess
import sys
import time
import urllib.request

from console_browser import open_browser, page_test_arguments
from patience import eventually

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
# Within this time a hidden page has left, and the server has closed its idle connections.
LEFT_S = 40
WATCHED_S = 5
# A page in view takes 1.3 s of these 5 s, and a browser without a page 0.1 to 0.2 s.
MAX_PROCESSOR_S = 0.5
# Installed before the page begins.
COUNTERS = """
window.costs = { messages: 0, requests: 0, changes: 0 };
const Plain = window.WebSocket;
window.WebSocket = class extends Plain {
  constructor(...given) {
    super(...given);
    ++window.costs.requests;
    this.addEventListener('message', () => ++window.costs.messages);
  }
};
const plainFetch = window.fetch;
window.fetch = (...given) => {
  ++window.costs.requests;
  return plainFetch(...given);
};
new MutationObserver((changes) => (window.costs.changes += changes.length))
  .observe(document, { childList: true, subtree: true, attributes: true, characterData: true });
"""


def connections(port):
    """How many connections lead to this port of this computer, from whoever opened them."""
    lines = pathlib.Path("/proc/net/tcp").read_text().splitlines()[1:]
    return sum(words[2] == f"0100007F:{port:04X}" and words[3] == "01"
               for words in map(str.split, lines))


def processor_s(parent):
    """Of a process and all that descend from it, s."""
    ticks, children = {}, {}
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            fields = (process / "stat").read_text().rsplit(") ", 1)[1].split()
        except OSError:
            continue  # it has ended
        ticks[int(process.name)] = int(fields[11]) + int(fields[12])
        children.setdefault(int(fields[1]), []).append(int(process.name))
    total, open_ones = 0, [parent]
    while open_ones:
        one = open_ones.pop()
        total += ticks.get(one, 0)
        open_ones += children.get(one, [])
    return total / os.sysconf("SC_CLK_TCK")


def costs(driver):
    return driver.execute_script("return [document.hidden, {...window.costs}]")


def check_costs_nothing(driver, port, where):
    """It asks for nothing, draws nothing and computes nothing."""
    deadline = time.monotonic() + LEFT_S
    while connections(port):
        assert time.monotonic() < deadline, f"{where}: {connections(port)} connections are open"
        time.sleep(0.2)
    hidden, before = costs(driver)
    assert hidden, where
    begin = processor_s(driver.service.process.pid)
    end = time.monotonic() + WATCHED_S
    while time.monotonic() < end:
        assert connections(port) == 0, f"{where}: it connects"
        time.sleep(0.02)
    used = processor_s(driver.service.process.pid) - begin
    _, after = costs(driver)
    assert after == before, (where, before, after)
    assert used <= MAX_PROCESSOR_S, f"{where}: {used} s of processor time in {WATCHED_S} s"
    print(f"{where}: no connection, {used:.2f} s of processor time in {WATCHED_S} s")


def pause(url):
    """By another client of the console."""
    origin, key = url.split("/?key=")
    request = urllib.request.Request(f"{origin}/api/v1/jobs/1/pause", data=b"", method="POST")
    request.add_header("Authorization", "Bearer " + key)
    with urllib.request.urlopen(request) as answer:
        assert answer.status == 200


def shows(driver, selector, text):
    from selenium.webdriver.common.by import By

    def is_shown():
        found = driver.find_elements(By.CSS_SELECTOR, selector)
        return bool(found) and text in found[0].text

    eventually(is_shown)


def drawn(driver):
    from selenium.webdriver.common.by import By
    view = driver.find_element(By.CSS_SELECTOR, "glass-view")
    return int(view.get_attribute("data-drawn") or 0)


def check_page(driver, port, url):
    """Hidden by another page before it, it sleeps; what happened meanwhile is there when it is
    shown."""
    seen = driver.current_window_handle
    shows(driver, "job-list", "knot: engraving")
    eventually(lambda: drawn(driver) > 100)
    before = costs(driver)[1]["messages"]
    begin = processor_s(driver.service.process.pid)
    time.sleep(WATCHED_S)
    used = processor_s(driver.service.process.pid) - begin
    count = costs(driver)[1]["messages"] - before
    print(f"in view: {count} states, {used:.2f} s of processor time in {WATCHED_S} s")
    assert count > 5, "a page in view gets states"
    driver.switch_to.new_window("tab")
    other = driver.current_window_handle
    driver.switch_to.window(seen)  # of the driver; the browser still shows the other one
    driver.execute_cdp_cmd("Target.activateTarget", {"targetId": other})
    eventually(lambda: costs(driver)[0])
    check_costs_nothing(driver, port, "hidden")
    pause(url)
    driver.execute_cdp_cmd("Target.activateTarget", {"targetId": seen})
    eventually(lambda: not costs(driver)[0])
    shows(driver, "job-list", "knot: paused")
    shows(driver, "machine-list", "els-03")
    eventually(lambda: drawn(driver) > 100)
    time.sleep(2)
    shows(driver, "job-list", "knot: paused")
    assert not driver.find_element("css selector", "stop-button").text.startswith("No connection")
    print("whole again when it is shown, and nothing has started")
    return other


def check_background(driver, port, url, other):
    """One that was never in view."""
    driver.close()
    driver.switch_to.window(other)
    driver.execute_cdp_cmd("Target.createTarget", {"url": url, "background": True})
    page = next(one for one in driver.window_handles if one != other)
    driver.switch_to.window(page)
    driver.execute_cdp_cmd("Target.activateTarget", {"targetId": other})
    driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": COUNTERS})
    driver.get(url)
    eventually(lambda: costs(driver)[0])
    check_costs_nothing(driver, port, "opened in the background")
    driver.execute_cdp_cmd("Target.activateTarget", {"targetId": page})
    shows(driver, "job-list", "knot: paused")
    eventually(lambda: drawn(driver) > 100)


def main():
    given = page_test_arguments()
    folder = given.folder
    place = ["--domain", "53", "--tag", f"hidden{os.getpid()}"]

    log = open(folder / "up.txt", "w")
    up = subprocess.Popen([given.intaglio, "up", "--console", "--folder", folder / "shop",
                           "--materials", folder / "materials.db", "--warm-up", "1", *place],
                          stdout=log, stderr=log)
    driver = None
    try:
        eventually(lambda: "the shop is open" in (folder / "up.txt").read_text())
        url = (folder / "shop/console.address").read_text().strip()
        port = int(re.search(r":(\d+)/", url)[1])
        subprocess.run([given.intaglio, "submit", ROOT / "deploy/jobs/sample.textproto",
                        "--height", "12", "--spacing", "0.5", "--rate", "25", "--name", "knot",
                        "--arm", *place], check=True)
        driver = open_browser()
        driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": COUNTERS})
        driver.get(url)
        other = check_page(driver, port, url)
        check_background(driver, port, url, other)
    finally:
        if driver:
            driver.quit()
        up.send_signal(signal.SIGINT)
        up.wait(30)
    return 0


if __name__ == "__main__":
    sys.exit(main())
