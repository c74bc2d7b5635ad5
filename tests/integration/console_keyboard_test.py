#!/usr/bin/python3
"""The console's page without a mouse, and for eyes that see little: on each page every control
has a name, is reached by Tab in the order of the document with a focus that is seen, and no text
is faint; Escape stops from everywhere. A job is made by keys alone.

  console_keyboard_test.py --intaglio PROGRAM --folder FOLDER

Needs chromium, chromium-driver and python3-selenium; ends with 77 (skipped) without them.
"""
import os
import pathlib
import signal
import subprocess
import sys
import time

from console_browser import open_browser, page_test_arguments
from patience import eventually

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
# WCAG 2.1, 1.4.3: text that is not large.
MIN_CONTRAST = 4.5
COMMANDS = "[data-command], .hold, .fire input, job-page input, jog-panel select, " \
    "teach-panel .hold, teach-panel select"


class Page:
    """The page, by keys."""

    def __init__(self, driver):
        self.driver = driver

    def open(self, url):
        self.driver.get(url)
        self.prepare()

    def prepare(self):
        """The functions of console_keyboard.js, and a count of the stops that are sent."""
        self.driver.execute_script((HERE / "console_keyboard.js").read_text())
        self.driver.execute_script("""
            window.stops = 0;
            const send = window.fetch;
            window.fetch = (path, ...rest) => {
              if (String(path).endsWith('/stop')) ++window.stops;
              return send(path, ...rest);
            };""")

    def ask(self, call):
        return self.driver.execute_script(f"return keyboardTest.{call}")

    def press(self, *keys):
        from selenium.webdriver.common.action_chains import ActionChains
        ActionChains(self.driver).send_keys(*keys).perform()

    def text(self, selector):
        from selenium.webdriver.common.by import By
        return self.driver.find_element(By.CSS_SELECTOR, selector).text

    def shown(self, selector):
        from selenium.webdriver.common.by import By
        return [element for element in self.driver.find_elements(By.CSS_SELECTOR, selector)
                if element.is_displayed()]

    def to_the_top(self):
        """Tab begins at the top of the document."""
        self.driver.execute_script("""
            document.body.tabIndex = -1;
            document.body.focus();
            document.body.removeAttribute('tabindex');""")

    def tab_to(self, selector):
        """As a person does it: Tab until it has the focus."""
        from selenium.webdriver.common.keys import Keys
        self.to_the_top()
        for _ in range(100):
            self.press(Keys.TAB)
            if self.driver.execute_script("return document.activeElement.matches(arguments[0])",
                                          selector):
                return
        raise AssertionError(f"Tab does not reach {selector}")

    def tab_order(self, last=None):
        """The elements that have the focus one after the other, each with its fault; with a last
        one, those before it, backwards."""
        from selenium.webdriver.common.action_chains import ActionChains
        from selenium.webdriver.common.keys import Keys
        order = []
        if last:
            self.driver.execute_script("arguments[0].focus()", last)
            order.append((last, ""))
        else:
            self.to_the_top()
        for _ in range(200):
            if last:
                ActionChains(self.driver).key_down(Keys.SHIFT).send_keys(Keys.TAB) \
                    .key_up(Keys.SHIFT).perform()
            else:
                self.press(Keys.TAB)
            element = self.driver.switch_to.active_element
            if element.tag_name == "body" or element in [one for one, _ in order]:
                return order
            order.append((element, self.ask("focusFault()")))
        raise AssertionError("Tab comes to no end")


def outline(element):
    return element.get_attribute("outerHTML")[:100]


def check(page, where, say):
    """The rules for one page. What the shop changes in the middle of it is checked again."""
    def faults():
        controls = page.ask("controls()")
        found = [f"no name: {outline(one)}" for one in [*controls, *page.ask("named()")]
                 if not one.accessible_name.strip()]
        order = page.tab_order()
        reached = [one for one, _ in order]
        found += [f"not reached: {outline(one)}" for one in controls if one not in reached]
        found += [f"focus not seen, {fault}: {outline(one)}" for one, fault in order if fault]
        back = page.tab_order(controls[-1])
        found += [f"backwards, {fault}: {outline(one)}" for one, fault in back if fault]
        if not found and (reached != controls or [one for one, _ in back] != controls[::-1]):
            found.append("not in the order of the document")
        if page.ask("positiveTabindex()"):
            found.append("a tabindex above 0")
        texts = page.ask(f"faintTexts({MIN_CONTRAST})")
        found += [f"contrast {ratio}: {text}" for ratio, text in texts["faint"]]
        return found, len(controls), texts["checked"]

    for _ in range(4):
        found, controls, texts = faults()
        if not found:
            say(f"{where}: {controls} controls, {texts} texts")
            return
    raise AssertionError("\n".join([where, *found]))


def check_stop(page, where, say):
    """Escape stops whatever has the focus."""
    from selenium.webdriver.common.keys import Keys
    controls = page.ask("controls()")
    assert page.shown("#stop"), where
    for control in controls:
        before = page.driver.execute_script("return window.stops")
        page.driver.execute_script("arguments[0].focus()", control)
        page.press(Keys.ESCAPE)
        after = page.driver.execute_script("return window.stops")
        assert after == before + 1, (where, outline(control), before, after)
    page.tab_to("#stop")
    before = page.driver.execute_script("return window.stops")
    page.press(Keys.ENTER)
    assert page.driver.execute_script("return window.stops") == before + 1, where
    say(f"{where}: Escape stops from {len(controls)} controls")


def log_in(page, name, password):
    from selenium.webdriver.common.keys import Keys
    eventually(lambda: page.shown("log-in"))
    page.tab_to("log-in input[autocomplete=username]")
    page.press(name, Keys.TAB, password, Keys.ENTER)
    eventually(lambda: page.shown("main") and not page.shown("log-in"))


def log_out(page):
    from selenium.webdriver.common.keys import Keys
    page.tab_to("session-line button:last-child")
    page.press(Keys.ENTER)


def state_is(page, state):
    return eventually(lambda: f"knot: {state}" in page.text("job-list") or None)


def check_new_job(page, say):
    """A file is chosen, which has a preview, is placed and may be removed, all by keys."""
    from selenium.webdriver.common.keys import Keys
    page.driver.find_element("css selector", "job-page input[type=file]").send_keys(
        str(ROOT / "deploy/jobs/sample.obj"))
    eventually(lambda: "points, about" in page.text("job-page"))
    check(page, "a new job", say)
    page.tab_to(".places .model")
    page.press(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.ARROW_UP)
    place = [field.get_attribute("value")
             for field in page.shown("job-page fieldset:not(.cards) input[type=number]")[:3]]
    assert place == ["2", "1", "0"], f"the arrow keys move the model: {place}"
    page.tab_to("job-page input[value=glass]")
    page.press(Keys.ARROW_RIGHT)
    eventually(lambda: "Diameter of the tool" in page.text("job-page"))
    page.press(Keys.ARROW_LEFT)
    eventually(lambda: "points, about" in page.text("job-page"))


def make_a_job(page, submit, say):
    """An operator makes and ends a job by keys."""
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.keys import Keys

    def drawn():
        return int(page.driver.find_element("css selector", "glass-view")
                   .get_attribute("data-drawn") or 0)

    submit()
    state_is(page, "waiting_for_arm")
    eventually(lambda: "50 x 50 x 30" in page.text(".fire"))
    check(page, "a job that waits for its arm", say)
    page.driver.set_window_size(500, 900)
    check(page, "the same on a phone", say)
    page.driver.set_window_size(1280, 1000)
    page.tab_to(".fire .hold")
    ActionChains(page.driver).key_down(Keys.ENTER).pause(0.3).key_up(Keys.ENTER).perform()
    time.sleep(3)
    state_is(page, "waiting_for_arm")
    ActionChains(page.driver).key_down(Keys.ENTER).pause(2.5).key_up(Keys.ENTER).perform()
    state_is(page, "engraving")
    page.tab_to("[data-command=pause]")
    page.press(Keys.ENTER)
    state_is(page, "paused")
    page.driver.refresh()
    page.prepare()
    state_is(page, "paused")
    time.sleep(2)
    state_is(page, "paused")
    check(page, "a paused job", say)
    eventually(lambda: drawn() > 100)
    before = page.shown("canvas")[0].screenshot_as_png
    page.tab_to("canvas")
    page.press(Keys.ARROW_LEFT, Keys.ARROW_LEFT, Keys.ARROW_LEFT, "+")
    eventually(lambda: page.shown("canvas")[0].screenshot_as_png != before)
    say("turned by keys")
    page.tab_to("[data-command=cancel]")
    page.press(Keys.ENTER, Keys.ENTER)
    state_is(page, "cancelled")
    check(page, "a job that has ended", say)


def main():
    given = page_test_arguments()
    folder = given.folder
    (folder / "shop").mkdir()
    for name, role in (("anna", "operator"), ("office", "observer")):
        subprocess.run([given.intaglio, "console", "user", "add", name, "--role", role, "--users",
                        folder / "shop/console.users"], input=b"correct horse\n", check=True)
    place = ["--domain", "52", "--tag", f"keys{os.getpid()}"]
    log = open(folder / "up.txt", "w")
    up = subprocess.Popen([given.intaglio, "up", "--console", "--folder", folder / "shop",
                           "--materials", folder / "materials.db", "--warm-up", "1", *place],
                          stdout=log, stderr=log)
    driver = None

    def submit():
        subprocess.run([given.intaglio, "submit", ROOT / "deploy/jobs/sample.textproto",
                        "--height", "12", "--spacing", "0.5", "--rate", "25", "--name", "knot",
                        *place], check=True)

    try:
        eventually(lambda: "the shop is open" in (folder / "up.txt").read_text())
        url = (folder / "shop/console.address").read_text().split("?")[0]
        driver = open_browser()
        page = Page(driver)
        page.open(url)
        eventually(lambda: page.shown("log-in"))
        check(page, "the log-in", print)
        check_stop(page, "the log-in", print)
        log_in(page, "anna", "correct horse")
        check_new_job(page, print)
        make_a_job(page, submit, print)
        log_out(page)
        log_in(page, "office", "correct horse")
        eventually(lambda: page.driver.execute_script("return document.body.dataset.role")
                   == "observer")
        assert not page.shown(COMMANDS), "an observer commands nothing"
        check(page, "an observer", print)
        check_stop(page, "an observer", print)
        eventually(lambda: "STOP PRESSED" in page.text("machine-list"))
    finally:
        if driver:
            driver.quit()
        up.send_signal(signal.SIGINT)
        up.wait(30)
    return 0


if __name__ == "__main__":
    sys.exit(main())
