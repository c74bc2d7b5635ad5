#!/usr/bin/python3
"""The colours of points on the console's page, against a shop of real processes: by outcome, order,
tick and channel, by the pixels of each. A job in two channels is paused in the middle, and goes on
behind some points that are left out for good. Then its journal gets points that were missed,
skipped and uncertain, while the page is open.

  console_colours_test.py --intaglio PROGRAM --folder FOLDER

Needs chromium, chromium-driver and python3-selenium; ends with 77 (skipped) without them.
"""
import json
import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import sys
import time
import zlib

from console_browser import canvas_png, open_browser, page_test_arguments
from console_browser_test import SET_CONTROL
from patience import eventually
from png_files import pixels

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
COLOURS = (ROOT / "services/console/page/colours.ts").read_text()
LEFT_OUT = 30
OUTCOMES = {"missed": 2, "skipped": 3, "uncertain": 4}  # PointOutcome
OF_EACH = 25
MODES = ("outcome", "order", "tick", "channel")


def palette(name):
    """The colours of this name in colours.ts, 0..255."""
    body = COLOURS[COLOURS.index(f"export const {name}:"):]
    body = body[body.index("= "):body.index(";")]
    return [tuple(255 * float(part) for part in colour.split(","))
            for colour in re.findall(r"\[([\d., ]+)\]", body)]


def counts(driver, colours):
    """Of the bright pixels, how many are near each of these colours."""
    found = [0] * len(colours)
    for row in pixels(canvas_png(driver)):
        for pixel in row:
            if max(pixel) < 130:
                continue
            near = [sum((a - b) ** 2 for a, b in zip(pixel, colour)) for colour in colours]
            if min(near) < 40 ** 2:
                found[near.index(min(near))] += 1
    return found


def choose(driver, mode):
    driver.execute_script(SET_CONTROL, "Colours", MODES.index(mode))
    time.sleep(2)


def colours(driver, folder, say):
    from selenium.webdriver.common.by import By

    def legend():
        return driver.find_element(By.CSS_SELECTOR, ".legend").text.split("\n")

    planned, made, _, _, _, left_out = palette("ofOutcome")
    choose(driver, "outcome")
    assert legend() == ["planned", "made", "missed", "skipped", "uncertain", "left out"], legend()
    white, teal = eventually(
        lambda: (lambda found: all(found) and found)(counts(driver, [made, left_out])), 60)
    assert white > 30 and teal > 10, (white, teal)
    say(f"by outcome: {white} pixels made, {teal} left out")

    first, last = palette("first")[0], palette("last")[0]
    along = [tuple(a + t * (b - a) for a, b in zip(first, last))
             for t in (0.05, 0.1, 0.45, 0.5, 0.2, 0.3, 0.6, 0.7, 0.8, 0.9, 0.95)]
    by = {}
    for mode in ("order", "tick"):
        choose(driver, mode)
        found = counts(driver, [made, *along])
        by[mode] = {"white": found[0], "first": sum(found[1:3]), "middle": sum(found[3:5]),
                    "last": sum(found[9:])}
        assert legend() == ["first", "last"], legend()
        assert by[mode]["white"] < white // 10, by
        assert by[mode]["first"] > 5 and by[mode]["last"] > 5, by
        driver.save_screenshot(str(folder / f"{mode}.png"))
    # Nothing was fired in the pause, which is the middle of the job's time, but not of its order.
    assert by["order"]["middle"] > 10 > 5 * by["tick"]["middle"], by
    say(f"by order and by tick: {by}")

    choose(driver, "channel")
    assert legend() == [f"Channel {i}" for i in (1, 2, 3, 4)], legend()
    found = eventually(
        lambda: (lambda found: found[0] < white // 10 and min(found[1:3]) > 15 and found)(
            counts(driver, [made, *palette("ofChannel")])), 60)
    assert found[3] == 0 and found[4] == 0, found
    driver.find_element(By.CSS_SELECTOR, ".legend").location_once_scrolled_into_view
    driver.save_screenshot(str(folder / "channel.png"))
    say(f"by channel: {found[1:]} pixels")


def write_outcomes(journal, planned):
    """As a synchronizer appends them (engrave/formats/journal_file.h), of points all along the
    order."""
    with open(journal, "ab") as out:
        for i in range(OF_EACH):
            for which, outcome in enumerate(OUTCOMES.values()):
                point = i * (planned // OF_EACH) + 2 * which
                record = struct.pack("<BBBBIQIfI", 2, outcome, 0, 0, 1, 0, point, 0, 0)
                out.write(record + struct.pack("<I", zlib.crc32(record)))


def other_outcomes(driver, folder, planned, say):
    """What was not made has its colour: as it comes, and in a page that is opened later."""
    every = palette("ofOutcome")
    wanted = [every[outcome] for outcome in OUTCOMES.values()]
    choose(driver, "outcome")
    before = counts(driver, [every[1], every[5], *wanted])
    # Where cracks and what is left out overlap, few pixels resemble another colour.
    assert max(before[2:]) < OF_EACH, before
    journal = next(folder.glob("shop/jobs/1-*/journal.bin"))
    write_outcomes(journal, planned)

    def found():
        now = counts(driver, [every[1], every[5], *wanted])
        more = [now[i] - before[i] for i in (2, 3, 4)]
        return min(more) > OF_EACH and dict(zip(OUTCOMES, more))

    say(f"as they come, pixels of {eventually(found, 60)}")
    driver.save_screenshot(str(folder / "outcome.png"))
    driver.refresh()
    say(f"in a new page, pixels of {eventually(found, 60)}")


def main():
    given = page_test_arguments()
    folder = given.folder
    shutil.copy(ROOT / "deploy/jobs/sample.obj", folder)
    knots = "".join(
        f'models {{ file: "sample.obj" channels: {channel} placement {{ up: UP_AXIS_Z '
        f"fit_height_mm: 6 move_mm {{ x: {x} y: 0 z: 0 }} }} }}\n"
        for channel, x in ((1, -10), (2, 10)))
    (folder / "job.textproto").write_text(
        'name: "two channels"\n' + knots + "block { size_mm { x: 50 y: 50 z: 30 } }\n"
        'glass: "N-BK7"\ndiscretization { min_spacing_mm: 1 }\nlaser { channels: [1, 2] }\n'
        'machine_file: "els-03"\n')
    place = ["--domain", "53", "--tag", f"colours{os.getpid()}"]

    def typed(*words):
        return subprocess.run([given.intaglio, *words, *place], check=True, text=True,
                              cwd=folder, stdout=subprocess.PIPE).stdout

    def job():
        return json.loads(typed("show", "1", "--json"))

    with open(folder / "up.txt", "w") as log:
        up = subprocess.Popen([given.intaglio, "up", "--console", "--folder", folder / "shop",
                               "--materials", folder / "materials.db", "--warm-up", "1",
                               "--block", "50", "50", "30", *place], stdout=log, stderr=log)
    driver = None
    try:
        eventually(lambda: "the shop is open" in (folder / "up.txt").read_text())
        typed("submit", "job.textproto", "--rate", "25")
        eventually(lambda: job()["state"] == "waiting_for_arm")
        typed("arm", "1")
        eventually(lambda: job()["made"] > job()["planned"] * 0.3)
        typed("pause", "1")
        eventually(lambda: job()["state"] == "paused" and not job()["armed_count"])
        stopped = job()
        print(f"{stopped['made']} of {stopped['planned']} points made before the pause")
        assert stopped["made"] < stopped["planned"] * 0.45, stopped
        # As long as the whole job takes, at 25 ticks a second.
        time.sleep(stopped["planned"] / 25)
        typed("resume", "1", "--from", str(stopped["made"] + LEFT_OUT))

        def done():
            # On a computer that is too busy for its lines a job pauses; the operator goes on.
            if job()["state"] == "paused":
                typed("resume", "1")
            return job()["state"] == "done"

        eventually(done)
        driver = open_browser()
        driver.get((folder / "shop/console.address").read_text().strip())
        colours(driver, folder, print)
        other_outcomes(driver, folder, job()["planned"], print)
        errors = [line for line in driver.get_log("browser") if line["level"] == "SEVERE"
                  and "favicon" not in line["message"]]
        assert not errors, errors
    finally:
        if driver:
            driver.quit()
        up.send_signal(signal.SIGINT)
        up.wait(30)
    return 0


if __name__ == "__main__":
    sys.exit(main())
