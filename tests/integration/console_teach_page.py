"""Teaching on the console's page, in a browser: what console_teach_test.py does there."""
import json
import re
import time

from console_browser import open_browser
from patience import eventually


class TeachPage:
    """The page, as a person uses it."""

    def __init__(self, driver, shop):
        self.driver, self.shop = driver, shop

    def element(self, path):
        from selenium.webdriver.common.by import By
        return self.driver.find_element(By.XPATH, "//teach-panel" + path)

    def field(self, label):
        return self.element(f"//label[contains(., '{label}')]/*")

    def text(self):
        return self.element("").text

    def fill(self, label, value):
        field = self.field(label)
        field.clear()
        field.send_keys(value)
        # Whatever the field had before, it has this now.
        assert field.get_attribute("value") == value

    def submit(self, label):
        """The number of the job of this button."""
        self.element(f"//button[.='{label}']").click()
        return int(eventually(
            lambda: re.search(r"Job (\d+) is submitted", self.text()), 60)[1])

    def show(self, title):
        self.driver.execute_script("arguments[0].scrollIntoView()",
                                   self.element(f"//*[.='{title}']"))

    def job_line(self, job):
        from selenium.webdriver.common.by import By
        found = self.driver.find_elements(By.XPATH, self.line(job))
        return found[0].text if found else ""

    @staticmethod
    def line(job):
        return f"//job-list//li[div[@id='job-{job}-title']]"

    def arm(self, job, seconds):
        """Holds the button of this job so long; what the page answers."""
        from selenium.webdriver.common.action_chains import ActionChains
        from selenium.webdriver.common.by import By

        button = eventually(lambda: self.driver.find_elements(
            By.XPATH, self.line(job) + "//div[@class='fire']/button"), 20)[0]
        ActionChains(self.driver).move_to_element(button).click_and_hold().pause(seconds) \
            .release().perform()
        time.sleep(0.5)
        return self.job_line(job)

    def fire(self, job, state):
        """Held until the job is under way: after a pause it is resumed, then armed."""
        for _ in range(6):
            if state(job) not in ("waiting_for_arm", "paused"):
                return
            self.arm(job, 2.5)
            time.sleep(1)

    def hold(self, label, until, seconds=6):
        """A button, held to the answer as a person does it; again on a busy computer."""
        from selenium.webdriver.common.action_chains import ActionChains
        for _ in range(5):
            ActionChains(self.driver).move_to_element(self.element(f"//button[.='{label}']")) \
                .click_and_hold().perform()
            end = time.monotonic() + seconds
            while time.monotonic() < end and not (value := until()):
                time.sleep(0.1)
            ActionChains(self.driver).release().perform()
            if value:
                return
        raise AssertionError(f"{label}: {self.text()}")


def make_test_jobs(page, shop, folder):
    """A test pulse and a focus series, armed by a held press and by nothing else; the first
    crack moves the zero as `intaglio teach focus --first` does."""
    def state(job):
        return json.loads(shop.ask("GET", f"jobs/{job}")[1])["state"]

    def waits(job):
        return eventually(lambda: state(job) == "waiting_for_arm" or None, 60)

    def fires(job, cracks):
        """On a computer that is too busy for its lines a job pauses; the operator goes on."""
        def done():
            if state(job) == "paused":
                shop.typed("resume", str(job))
            return state(job) == "done"

        eventually(done, 120)
        assert shop.cracks() == cracks, shop.cracks()

    shop.typed("mount", "--block", "50", "50", "30", "--index", "1.51947", "--lens", "f43")
    for axis, value in (("x", "50"), ("y", "50"), ("z", "30")):
        page.fill(f"Block {axis}, mm", value)
    from selenium.webdriver.support.ui import Select
    Select(page.field("Lens")).select_by_value("f43")
    Select(page.field("Channel")).select_by_value("1")
    pulse = page.submit("Submit a test pulse")
    waits(pulse)
    eventually(lambda: "50 x 50 x 30" in page.job_line(pulse), 20)
    page.arm(pulse, 0.3)
    page.driver.refresh()
    time.sleep(3)
    assert (shop.cracks(), state(pulse)) == (0, "waiting_for_arm"), "a tap or a reload fires"
    shop.ask_panel("door open")
    eventually(lambda: not shop.status()["door_closed"], 10)
    assert "door" in page.arm(pulse, 2.5), "at an open door"
    time.sleep(2)
    shop.ask_panel("door close")
    eventually(lambda: shop.status()["door_closed"], 10)
    time.sleep(2)
    # The open door has paused it: it goes on by a held press, too.
    there = shop.cracks(), state(pulse)
    assert there == (0, "paused"), ("it fires after the door", there)
    page.fire(pulse, state)
    fires(pulse, 1)
    print("a test pulse fires when its button is held at a closed door", flush=True)

    for axis, value in (("x", "50"), ("y", "50"), ("z", "30")):
        page.fill(f"Block {axis}, mm", value)
    page.fill("Points", "6")
    page.fill("Depth from point to point", "0.1")
    shop.typed("teach", "move", "12", "25", "29", "--speed", "50")
    time.sleep(1)
    series = page.submit("Submit a focus series")
    waits(series)
    eventually(lambda: "50 x 50 x 30" in page.job_line(series), 20)
    page.fire(series, state)
    fires(series, 7)
    eventually(lambda: page.field("Job of the series").text.strip() == str(series), 20)
    page.fill("Number of the first visible crack", "9")
    eventually(lambda: "points 1 to 6" in page.text(), 20)
    page.fill("Number of the first visible crack", "4")
    moves = eventually(lambda: re.search(r"moves by (-?[\d.]+) mm", page.text()), 20)
    page.show("Focus series")
    page.driver.save_screenshot(str(folder / "teach_focus.png"))
    before, number = shop.zero(1), shop.teaching()["taught_number"]
    page.hold("Move the zero", lambda: shop.teaching()["taught_number"] == number + 1)
    moved = shop.zero(1)["z_mm"] - before["z_mm"]
    assert abs(moved - float(moves[1])) < 0.0006, (moved, moves[1])
    shop.typed("teach", "undo")
    written = next((shop.folder / "uploads").glob("focus-*/.written"))
    shop.typed("teach", "focus", "--out", str(written), "--first", "4", "--materials",
               "materials.db")
    assert abs(shop.zero(1)["z_mm"] - before["z_mm"] - moved) < 1e-9, "as the command does"
    print(f"a focus series moves the zero by {moved:.3f} mm", flush=True)


def limit_on_the_page(page, shop):
    """The fields have the machine's limits; what is saved there is the machine's, and goes."""
    def limits():
        return [[axis["limit_min"], axis["limit_max"]] for axis in shop.status()["axes"]]

    def shown():
        return [[float(page.field(f"{axis} {end}").get_attribute("value") or "nan")
                 for end in ("from", "to")] for axis in "xyz"]

    travel = limits()
    eventually(lambda: shown() == travel, 10)
    wanted = [[low + 5, high - 4] for low, high in travel]
    for axis, (low, high) in zip("xyz", wanted):
        page.fill(f"{axis} from", f"{low:g}")
        page.fill(f"{axis} to", f"{high:g}")
    page.hold("Save the limits", lambda: limits() == wanted)
    page.hold("Remove the limits", lambda: limits() == travel)
    eventually(lambda: shown() == travel, 10)


def teach_on_the_page(shop, folder):
    from selenium.webdriver.common.by import By
    from selenium.webdriver.support.ui import Select

    driver = open_browser(1280, 1400)
    try:
        page = TeachPage(driver, shop)
        driver.get(f"http://127.0.0.1:{shop.port}/?key=" + shop.key.split()[-1])
        eventually(lambda: "zero, of the profile: " in page.text(), 30)
        assert [one.text for one in Select(page.field("Lens")).options] == ["f43", "f70"]
        Select(page.field("Lens")).select_by_value("f70")
        Select(page.field("Channel")).select_by_value("3")
        text, number = shop.profile(), shop.teaching()["taught_number"]
        page.hold("Save the zero here", lambda: "Give the height" in page.text(), 3)
        page.field("Height of the block").send_keys("12")
        page.element("//button[.='Save the zero here']").click()
        time.sleep(1)
        assert shop.profile() == text, "a tap saves nothing"
        page.hold("Save the zero here", lambda: "zero, taught: " in page.text())
        assert shop.teaching()["taught_number"] == number + 1
        zero = next(zero for zero in shop.teaching()["zeros"]
                    if zero["lens"] == "f70" and zero["channel"] == 3)
        place = [axis["position"] for axis in shop.status()["axes"]]
        assert zero["taught"] and abs(zero["z_mm"] - (place[2] - 12)) < 0.01, (zero, place)
        eventually(lambda: "last change: zero of channel 3, lens f70" in page.text(), 5)
        driver.execute_script("arguments[0].scrollIntoView()",
                              driver.find_element(By.ID, "teach-title"))
        driver.save_screenshot(str(folder / "teach.png"))
        wide = driver.execute_script(
            "return [document.scrollingElement.scrollWidth, window.innerWidth]")
        assert wide[0] <= wide[1], f"wider than the window: {wide}"
        page.hold("Undo the last change", lambda: "zero, of the profile: " in page.text())
        limit_on_the_page(page, shop)
        page.hold("Lamp, while held", lambda: shop.status()["lamp_on"])
        eventually(lambda: not shop.status()["lamp_on"], 10)
        page.hold("Shutter, while held", lambda: shop.status()["shutters_open"] == [3])
        eventually(lambda: not shop.status()["shutters_open"], 10)
        text = shop.profile()
        driver.refresh()
        eventually(lambda: "zero, of the profile: " in page.text(), 30)
        time.sleep(2)
        assert shop.profile() == text and not shop.status()["lamp_on"], "a reload sends nothing"
        assert shop.cracks() == 0
        print("taught on the page", flush=True)
        make_test_jobs(page, shop, folder)
    finally:
        driver.quit()
