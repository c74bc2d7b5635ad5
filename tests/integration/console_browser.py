"""Debian's chromium for tests of the console's page."""
import argparse
import pathlib
import shutil
import sys


def missing():
    """What is not installed."""
    names = [p for p in ("chromium", "chromedriver") if not pathlib.Path("/usr/bin", p).exists()]
    try:
        import selenium  # noqa: F401
    except ImportError:
        names.append("python3-selenium")
    return names


def page_test_arguments(programs="--intaglio"):
    """What a test of the page is given: its programs and a folder, which is made anew. Ends with
    77 (skipped) where the browser is not installed."""
    parser = argparse.ArgumentParser()
    parser.add_argument(programs, required=True, type=pathlib.Path)
    parser.add_argument("--folder", required=True, type=pathlib.Path)
    given = parser.parse_args()
    if missing():
        print("skipped: not installed:", ", ".join(missing()))
        sys.exit(77)
    shutil.rmtree(given.folder, ignore_errors=True)
    given.folder.mkdir(parents=True)
    return given


def open_browser(width=1280, height=1000):
    """A browser without a screen, with what its page reports."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    for flag in ("--headless=new", "--no-sandbox", f"--window-size={width},{height}",
                 "--use-angle=swiftshader", "--enable-unsafe-swiftshader"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)


def canvas_png(driver):
    """The view of the glass; a screenshot has only what is in the window."""
    canvas = driver.find_element("css selector", "canvas")
    driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", canvas)
    return canvas.screenshot_as_png
