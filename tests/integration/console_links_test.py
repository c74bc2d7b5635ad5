#!/usr/bin/python3
"""The console's page links to the consoles of other computers, and to nothing else that a message
on the bus may say.

  console_links_test.py --bin FOLDER_OF_PROGRAMS --folder FOLDER

Needs chromium, chromium-driver and python3-selenium; ends with 77 (skipped) without them.
"""
import os
import signal
import socket
import subprocess
import sys

from console_browser import open_browser, page_test_arguments
from patience import eventually

# What the page makes of services; the next state of the shop would change it again.
SHOW = """
const links = document.querySelector('console-links');
links.update(arguments[0]);
return [...links.children].map((line) => [line.textContent, line.querySelector('a')?.href ?? '']);
"""


def console(host, message):
    return {"role": "console", "host": host, "message": message}


def check_links(driver):
    shown = driver.execute_script(SHOW, [
        console("mill <b>room</b>", "https://mill.shop:8850"),
        console("office", "http://127.0.0.1:8850"),
        console("here", driver.execute_script("return location.origin")),
        console("evil", "javascript:alert(1)"), console("silent", ""),
        {"role": "sorter", "host": "mill", "message": "https://mill.shop:8850"}])
    assert shown == [["Console of mill <b>room</b>", "https://mill.shop:8850/"],
                     ["office has a console for that computer alone", ""]], shown


def main():
    given = page_test_arguments("--bin")
    folder = given.folder
    bus = ["--domain", "54", "--tag", f"links{os.getpid()}"]
    own = folder / "address"
    log = open(folder / "consoles.txt", "w")
    consoles = [subprocess.Popen([given.bin / "intaglio-console", "--address-file", file, *bus],
                                 stdout=log, stderr=log) for file in (own, folder / "other")]
    driver = None
    try:
        eventually(own.exists, 60)
        driver = open_browser()
        driver.get(own.read_text().strip())

        def line():
            return driver.find_element("css selector", "console-links").text

        host = socket.gethostname()
        eventually(lambda: line() == f"{host} has a console for that computer alone")
        check_links(driver)
        consoles[1].send_signal(signal.SIGKILL)
        eventually(lambda: line() == "", 60)
        print("links to others, and none to a console that has gone")
    finally:
        if driver:
            driver.quit()
        for process in consoles:
            process.send_signal(signal.SIGTERM)
            process.wait(30)
    return 0


if __name__ == "__main__":
    sys.exit(main())
