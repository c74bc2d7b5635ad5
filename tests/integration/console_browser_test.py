#!/usr/bin/python3
"""The console's page in a browser, against a shop of real processes.

  console_browser_test.py --intaglio PROGRAM --folder FOLDER

Needs chromium, chromium-driver and python3-selenium; ends with 77 (skipped) without them. A
picture of the page is left in the folder; no points in it fail the test.
"""
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

from console_browser import canvas_png, open_browser, page_test_arguments
from patience import eventually
from png_files import pixels, png

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
NAME = "<b>knot</b>"


def languages(driver, say):
    """The page in each language that it has."""
    from selenium.webdriver.common.by import By
    from selenium.webdriver.support.ui import Select

    texts = ROOT / "services/console/page/texts"
    for code in ("de", "pl", "es", "zh", "en"):
        Select(driver.find_element(By.CSS_SELECTOR, "language-list select")).select_by_value(code)
        expected = json.loads((texts / f"{code}.json").read_text(encoding="utf-8"))

        def shown():
            return driver.find_element(By.TAG_NAME, "html").get_attribute("lang") == code and \
                driver.find_element(By.ID, "stop").text == expected["stop"] and \
                driver.find_element(By.ID, "jobs-title").text == expected["jobsTitle"]

        eventually(shown)
    say("five languages")


def by_hand(driver, say):
    """A machine moves while a button is held, and rests behind it."""
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By

    def place():
        panel = driver.find_element(By.CSS_SELECTOR, "jog-panel").text
        found = [line for line in panel.splitlines() if line.startswith("x ") and "." in line]
        return float(found[0].split()[1].rstrip(",")) if found else None

    def machine():
        return driver.find_elements(By.CSS_SELECTOR, "jog-panel select option")

    eventually(machine)

    def moves():
        button = driver.find_element(By.XPATH, "//jog-panel//button[text()='x +']")
        ActionChains(driver).move_to_element(button).click_and_hold().pause(1).perform()
        before = place()
        ActionChains(driver).pause(0.5).perform()
        after = place()
        ActionChains(driver).release().perform()
        return before is not None and after > before + 0.5

    eventually(moves)
    time.sleep(1)
    rests = place()
    time.sleep(1)
    assert place() == rests, "the stage rests when the button is let go"
    say(f"moved by hand to x = {rests} mm")


def new_job(driver, folder, say, preview):
    """A job is made from a file, placed by the mouse, shown and submitted; its file is one for
    the command line, and the page fits a phone."""
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By

    page = driver.find_element(By.CSS_SELECTOR, "job-page")

    def card(name):
        return page.find_element(By.XPATH, f".//fieldset/label[span[1]='{name}']/input")

    def field(name):
        return page.find_element(By.XPATH, f".//fieldset/label[starts-with(., '{name}')]/input")

    def boxes():
        return page.find_elements(By.CSS_SELECTOR, ".places figure:first-child .model")

    def previewed():
        picture = page.find_element(By.TAG_NAME, "img")
        return "points, about" in page.text and picture.get_attribute("naturalWidth") != "0" and \
            boxes() and page.text

    eventually(lambda: "here: els-03" in page.text and card("els-03").is_selected())
    assert card("N-BK7").is_selected() and "n 1.5195" in page.text
    page.find_element(By.CSS_SELECTOR, "input[type=file]").send_keys(
        str(ROOT / "deploy/jobs/sample.obj"))
    before = eventually(previewed, 120)
    from_x = float(boxes()[0].get_attribute("x"))
    driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", boxes()[0])
    ActionChains(driver).drag_and_drop_by_offset(boxes()[0], 30, -12).perform()
    moved = float(field("x").get_attribute("value"))
    assert moved > 1 and float(field("y").get_attribute("value")) > 0, "the box was dragged"
    card("sections").click()
    eventually(lambda: previewed() and previewed() != before, 120)
    # As the preview finds it in the points that it made.
    eventually(lambda: abs(float(boxes()[0].get_attribute("x")) - from_x - moved) < 0.5, 60)
    points = re.search(r"([\d,]+) points, about", eventually(previewed, 120))[1].replace(",", "")
    driver.set_window_size(1280, 1700)
    keep(driver, folder, "new_job", page.find_element(By.XPATH, ".."))
    driver.set_window_size(1280, 1000)
    driver.execute_script(
        "const made = URL.createObjectURL;"
        "URL.createObjectURL = (blob) => { blob.text().then((text) => (window.saved = text));"
        " return made.call(URL, blob); };")
    page.find_element(By.XPATH, ".//button[text()='Save job file']").click()
    (folder / "saved").mkdir()
    (folder / "saved/job.json").write_text(eventually(
        lambda: driver.execute_script("return window.saved")))
    shutil.copy(ROOT / "deploy/jobs/sample.obj", folder / "saved")
    assert preview(folder / "saved/job.json")["point_count"] == points
    say(f"a job of {points} points, placed by the mouse, is one for the command line")
    page.find_element(By.XPATH, ".//button[text()='Submit']").click()

    def submitted():
        return "Job 3 is submitted" in page.text and \
            "3 sample" in driver.find_element(By.CSS_SELECTOR, "job-list").text

    eventually(submitted, 120)
    say("a job of a dropped file is submitted")
    page.find_element(By.XPATH, ".//button[text()='Remove']").click()
    page.find_element(By.CSS_SELECTOR, "input[type=file]").send_keys(
        str(ROOT / "tests/data/boards/gap_is_tool.gbr"))
    eventually(lambda: card("board or sheet").is_selected() and card("mill").is_displayed())
    field_ = page.find_element(By.XPATH, ".//label[starts-with(., 'Diameter of the tool')]/input")
    field_.clear()
    field_.send_keys("0.1")
    shown = eventually(lambda: re.search(r"(\d+) contours?, \d+ holes, about", page.text), 60)
    assert int(shown[1]) > 0
    say(f"a dropped board is a job of {shown[1]} contours")
    driver.set_window_size(500, 900)
    width = driver.execute_script(
        "return [document.scrollingElement.scrollWidth, window.innerWidth]")
    assert width[0] <= width[1], f"wider than a phone: {width}"


def keep(driver, folder, name, element=None):
    """A picture of a part of the page, as docs/console.md shows it; INTAGLIO_WRITE_GOLDEN=1
    renews that one. No page is shown by an empty picture."""
    if element:
        driver.execute_script("arguments[0].scrollIntoView()", element)
    made = element.screenshot_as_png if element else driver.get_screenshot_as_png()
    (folder / f"{name}.png").write_bytes(made)
    kept = ROOT / f"docs/console/{name}.png"
    if os.environ.get("INTAGLIO_WRITE_GOLDEN"):
        kept.parent.mkdir(exist_ok=True)
        kept.write_bytes(made)

    def lit(picture):
        rows = pixels(picture)
        return len(rows[0]), sum(max(pixel) > 100 for row in rows for pixel in row)

    (width, bright), (kept_width, kept_bright) = lit(made), lit(kept.read_bytes())
    assert bright > 2000, f"{name}: nothing is shown"
    assert width == kept_width and 0.5 < bright / kept_bright < 2, \
        f"{kept} is not like the page any more: INTAGLIO_WRITE_GOLDEN=1 renews it"


def history(driver, folder, say):
    """The job that was cancelled is in the history, with its picture and its photo."""
    from selenium.webdriver.common.by import By

    past = driver.find_element(By.CSS_SELECTOR, "history-list")
    past.find_element(By.CSS_SELECTOR, "button").click()
    eventually(lambda: f"1 {NAME}: cancelled" in past.text, 30)
    assert "1 job, 1 shown" in past.text and " made" in past.text, past.text

    def width(selector):
        past.find_element(By.CSS_SELECTOR, f"{selector} button").click()
        time.sleep(1)
        picture = past.find_element(By.CSS_SELECTOR, f"{selector} img")
        return picture.is_displayed() and int(picture.get_attribute("naturalWidth"))

    assert eventually(lambda: width(".result"), 60) and eventually(lambda: width(".photo"), 60)
    keep(driver, folder, "history", past.find_element(By.XPATH, ".."))
    past.find_element(By.CSS_SELECTOR, "select").send_keys("good")
    past.find_element(By.CSS_SELECTOR, "button").click()
    eventually(lambda: "0 jobs" in past.text, 30)
    say("the history has what was made, with reason, picture and photo")


def reset(driver, say, cracks):
    """A stop that was read is released by two presses, and nothing starts."""
    from selenium.webdriver.common.by import By

    made = cracks()
    list_ = driver.find_element(By.CSS_SELECTOR, "machine-list")
    button = list_.find_element(By.CSS_SELECTOR, "[data-command=reset]")
    driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", button)
    button.click()
    time.sleep(1)
    assert "STOP PRESSED" in list_.text and "release its stop?" in button.text
    button.click()
    eventually(lambda: "stop released" in list_.text, 10)
    assert "STOP PRESSED" not in list_.text
    time.sleep(2)
    assert cracks() == made, "nothing starts by a reset"
    say("the stop is released on the page")


def hold_button(driver, name):
    """Of the first job, where it is shown with this name."""
    found = driver.find_elements("css selector", ".fire .hold")
    return found and found[0].is_displayed() and name in found[0].text and found[0]


def resume(driver, say, cracks):
    """What the stop has paused goes on by a press that is held."""
    from selenium.webdriver.common.action_chains import ActionChains

    made = cracks()

    def resumed():
        button = hold_button(driver, "RESUME")
        if button:
            ActionChains(driver).move_to_element(button).click_and_hold().pause(2.5).release() \
                .perform()
        return cracks() > made

    eventually(resumed, 60)
    say("resumed by a press that is held")


def arm(driver, say, cracks):
    """Only a button that is held arms the job."""
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By

    def button():
        return hold_button(driver, "ARM")

    def waits():
        return "waiting_for_arm" in driver.find_element(By.CSS_SELECTOR, "job-list").text

    def mounted():
        return "50 x 50 x 30" in driver.find_element(By.CSS_SELECTOR, ".fire").text

    def press(seconds, then):
        ActionChains(driver).move_to_element(eventually(button)).click_and_hold() \
            .pause(seconds).perform()
        then()
        ActionChains(driver).release().perform()

    eventually(waits)
    eventually(mounted)
    press(0.3, lambda: None)
    press(0.3, driver.refresh)
    eventually(waits)
    time.sleep(3)
    assert waits() and cracks() == 0, "a short press or a reload arms nothing"
    press(2.5, lambda: None)
    say("armed by a press that is held")


def photo(driver, folder, say):
    """A photo of the block is added, and shown again after a reload."""
    from selenium.webdriver.common.by import By

    (folder / "block.png").write_bytes(png(3000, 1000))
    (folder / "notes.png").write_text("no picture")

    def first(selector):
        return driver.find_element(By.CSS_SELECTOR, ".photo " + selector)

    def width():
        return first("img").is_displayed() and int(first("img").get_attribute("naturalWidth"))

    first("input").send_keys(str(folder / "notes.png"))
    eventually(lambda: "notes.png: is no JPEG or PNG file" in
               driver.find_element(By.CSS_SELECTOR, "job-list").text, 30)
    first("input").send_keys(str(folder / "block.png"))
    assert eventually(width, 30) == 2048, "as small as the page makes it"
    driver.refresh()
    eventually(lambda: driver.find_elements(By.CSS_SELECTOR, ".photo button"), 30)
    first("button").click()
    assert eventually(width, 30) == 2048
    driver.find_element(By.CSS_SELECTOR, "job-list").screenshot(str(folder / "photo.png"))
    kept = list(folder.glob("shop/jobs/1-*/block_photo.jpg"))
    assert kept and kept[0].read_bytes()[:3] == b"\xff\xd8\xff", kept
    say("a photo of the block is kept with its job")


def results(driver, say):
    """The job is cancelled, and its picture is shown."""
    from selenium.common.exceptions import (ElementClickInterceptedException,
                                            ElementNotInteractableException)
    from selenium.webdriver.common.by import By

    cancel = driver.find_element(By.CSS_SELECTOR, "[data-command=cancel]")

    def ended():
        if f"{NAME}: cancelled" in driver.find_element(By.CSS_SELECTOR, "job-list").text:
            return True
        # The second press counts within 4 s, which a busy computer may miss.
        for _ in range(2):
            try:
                if cancel.is_displayed():
                    cancel.click()
            except (ElementClickInterceptedException, ElementNotInteractableException):
                pass  # the job has ended meanwhile, and the button is gone
        return False

    def width():
        show = driver.find_element(By.CSS_SELECTOR, ".result button")
        show.click()
        time.sleep(1)
        picture = driver.find_element(By.CSS_SELECTOR, ".result img")
        return picture.is_displayed() and int(picture.get_attribute("naturalWidth"))

    eventually(ended)
    say(f"its picture is {eventually(width, 120)} pixels wide")

    def proof():
        driver.find_element(By.XPATH, "//job-list//button[text()='Proof']").click()
        time.sleep(1)
        picture = driver.find_element(By.CSS_SELECTOR, ".result img")
        return picture.is_displayed() and picture.get_attribute("alt") == "Proof" and \
            int(picture.get_attribute("naturalWidth"))

    say(f"its proof is {eventually(proof, 60)} pixels wide")


SET_CONTROL = """
const control = [...document.querySelectorAll('.glass-tools label')]
  .find((label) => label.textContent.startsWith(arguments[0])).querySelector('input, select');
if (control.tagName === 'SELECT') control.selectedIndex = arguments[1];
else control.value = arguments[1];
for (const kind of ['input', 'change']) control.dispatchEvent(new Event(kind));"""


def tools(driver, say):
    """A section, colours by order, and the cracks up to a time of the job."""
    def picture():
        return [pixel for row in pixels(canvas_png(driver)) for pixel in row]

    def white():
        return sum(min(pixel) > 170 for pixel in picture())

    def coloured():
        return sum(max(pixel) > 170 and max(pixel) - min(pixel) > 60 for pixel in picture())

    def lit():
        return sum(max(pixel) > 40 for pixel in picture())

    def expect(label, value, what):
        driver.execute_script(SET_CONTROL, label, value)
        eventually(what, 30)

    def set_section(axis, up_to):
        driver.execute_script(SET_CONTROL, "Section", axis)
        driver.execute_script(SET_CONTROL, "up to", up_to)
        time.sleep(1)  # until it is drawn

    def cuts(axis, up_to, ratio):
        """Points are made meanwhile, so the whole is looked at again each time."""
        set_section(0, 1000)
        whole = lit()
        set_section(axis, up_to)
        return lit() < ratio * whole

    expect("Made up to", 0, lambda: white() == 0)
    expect("Made up to", 1000, lambda: white() > 10)
    expect("Colours", 1, lambda: white() == 0 and coloured() > 10)
    expect("Colours", 0, lambda: white() > 10)
    eventually(lambda: cuts(3, 500, 0.9), 60)
    eventually(lambda: cuts(3, 0, 0.5) and white() == 0, 60)
    set_section(0, 1000)
    eventually(lambda: white() > 10, 30)
    say("section, colours and time of the cracks")


def over_the_cloud(driver):
    """How many pixels have the colour of the beam, that of the points that come next, and that
    of the machine's focus."""
    beam = following = focus = 0
    for row in pixels(canvas_png(driver)):
        for r, g, b in row:
            beam += r > 120 and r - g > 60 and r - b > 60
            following += b > 200 and g > 180 and r < 60
            focus += g > 200 and g - r > 90 and g - b > 90
    return beam, following, focus


def look(driver, folder, say, cracks, console_pid, submit):
    """What a person does with the page."""
    from selenium.webdriver.common.by import By

    def text(selector):
        return driver.find_element(By.CSS_SELECTOR, selector).text

    def engraving():
        return f"{NAME}: engraving" in text("job-list")

    def drawn():
        return int(driver.find_element(By.CSS_SELECTOR, "glass-view")
                   .get_attribute("data-drawn") or 0) > 100

    def made():
        return int(text("glass-view").split()[0]) >= 20

    def queue():
        return "els-03: 1 job takes " in text(".queue-times") and text(".queue-times")

    eventually(engraving)
    say("a name of a job is text")
    say(eventually(queue))
    submit("second")

    def about():
        found = re.search(r"els-03: about (.*) more for 1 job whose points are not made yet",
                          text(".queue-times"))
        return found and f"about {found[1]}" in text("job-list").split("second")[1] and found[1]

    say(f"the job that waits takes about {eventually(about, 120)}")
    eventually(drawn)
    eventually(made)

    def shown():
        canvas = canvas_png(driver)
        (folder / "glass.png").write_bytes(canvas)
        lit = sum(max(pixel) > 40 for row in pixels(canvas) for pixel in row)
        bright = sum(min(pixel) > 170 for row in pixels(canvas) for pixel in row)
        return lit > 500 and bright > 10 and f"{lit} lit pixels, {bright} of cracks"

    say(eventually(shown, 30))
    driver.execute_script("window.scrollTo(0, 0)")
    keep(driver, folder, "shop")

    def beam_is_shown():
        beam, following, focus = over_the_cloud(driver)
        return beam > 30 and following > 10 and focus > 20 and (beam, following, focus)

    say(f"beam, points that come next, focus: {eventually(beam_is_shown)} pixels")

    tools(driver, say)

    def confirmed():
        return "els-03: no pulse is fired" in text("stop-button")

    driver.find_element(By.ID, "stop").click()
    eventually(confirmed, 10)
    before = cracks()
    say("stopped")
    eventually(lambda: over_the_cloud(driver)[:2] == (0, 0))
    eventually(lambda: over_the_cloud(driver)[2] > 20)
    say("no beam where nothing is made, and the focus where the stage rests")
    driver.refresh()

    def held():
        return "STOP PRESSED" in text("machine-list")

    eventually(held)
    time.sleep(3)
    assert cracks() == before, "nothing starts by a reload"
    reset(driver, say, cracks)
    resume(driver, say, cracks)
    os.kill(console_pid(), signal.SIGSTOP)

    def lost():
        return "press the button of the machine" in text("stop-button")

    eventually(lost, 10)
    say("a lost connection is shown in the place of the stop")
    os.kill(console_pid(), signal.SIGCONT)

    def back():
        return not text("stop-button").startswith("No connection")

    eventually(back)
    photo(driver, folder, say)
    results(driver, say)
    history(driver, folder, say)
    errors = [line for line in driver.get_log("browser") if "Content Security" in line["message"]]
    assert not errors, errors


def main():
    given = page_test_arguments()
    folder = given.folder
    place = ["--domain", "47", "--tag", f"browser{folder.stat().st_ino}"]
    log = open(folder / "up.txt", "w")
    up = subprocess.Popen([given.intaglio, "up", "--console", "--folder", folder / "shop",
                           "--materials", folder / "materials.db", "--warm-up", "1",
                           "--block", "50", "50", "30", "--picture-size", "600", *place], stdout=log, stderr=log)
    driver = None
    try:
        def address():
            lines = (folder / "up.txt").read_text().splitlines()
            found = [line for line in lines if line.startswith("web console: ")]
            return "the shop is open" in "\n".join(lines) and found[0].split()[-1]

        def cracks():
            from socket import AF_UNIX, socket
            with socket(AF_UNIX) as panel:
                panel.connect(str(folder / "shop/panel"))
                panel.sendall(b"status\n")
                answer = panel.recv(65536).decode()
            return int(answer.split('"cracks": ')[1].split(",")[0].split("}")[0])

        def console_pid():
            for process in pathlib.Path("/proc").glob("[0-9]*"):
                try:
                    words = (process / "cmdline").read_bytes().split(b"\0")
                except OSError:
                    continue  # it has ended
                if words[0].endswith(b"intaglio-console") and \
                        str(folder / "shop/console.address").encode() in words:
                    return int(process.name)
            raise AssertionError("no console runs")

        def submit(name):
            subprocess.run([given.intaglio, "submit", ROOT / "deploy/jobs/sample.textproto",
                            "--height", "12", "--spacing", "0.5", "--rate", "25", "--name", name,
                            *place], check=True)

        def preview(job):
            made = subprocess.run([given.intaglio, "preview", job, "--json", "--materials",
                                   folder / "materials.db", "--out", folder / "saved/preview"],
                                  check=True, stdout=subprocess.PIPE)
            return json.loads(made.stdout)

        url = eventually(address)
        submit(NAME)
        driver = open_browser()
        driver.get(url)
        assert "key=" not in driver.current_url
        languages(driver, print)
        by_hand(driver, print)
        arm(driver, print, cracks)
        look(driver, folder, print, cracks, console_pid, submit)
        keep(driver, folder, "by_hand", driver.find_element("css selector", ".hand"))
        keep(driver, folder, "teach", driver.find_element("css selector", ".hand.wide"))
        new_job(driver, folder, print, preview)
    finally:
        if driver:
            driver.quit()
        up.send_signal(signal.SIGINT)
        up.wait(20)
    return 0


if __name__ == "__main__":
    sys.exit(main())
