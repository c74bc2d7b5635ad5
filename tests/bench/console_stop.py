#!/usr/bin/python3
"""How soon a Stop at the console is confirmed, with many pages open.

  console_stop.py --bin FOLDER [--pages N] [--presses N] [--points N] [--folder FOLDER]

A shop of real processes with a job of random points. Pages are clients that read the state ten
times a second, as those of a browser; another one fetches the plan again and again. Each press
stops a machine that was not stopped, and counts from the sent request, or message, to the answer
that the machine fires no pulse, its shutters are closed and its stage rests; between two presses
the stop is released. Then the same with the job service killed: no stop is released then, and
each press is confirmed by its own number. Needs curl.
"""
import contextlib
import http.client
import json
import os
import pathlib
import re
import selectors
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "integration"))
from console_jog_test import Finger  # noqa: E402
from console_page import bench_arguments, bulk_transfer, quantile, random_cloud  # noqa: E402
from patience import eventually  # noqa: E402

PONG = bytes([0x8a, 0x80]) + bytes(4)
BLOCK_MM = ["60", "60", "60"]


@contextlib.contextmanager
def open_pages(port, key, count):
    """So many clients that get the state, and read it; how many bytes have come."""
    pages = [Finger(port, key).socket for _ in range(count)]
    ended, got = threading.Event(), [0]

    def read():
        with selectors.DefaultSelector() as ready:
            for page in pages:
                ready.register(page, selectors.EVENT_READ)
            alive_s = time.monotonic()
            while not ended.is_set():
                if time.monotonic() > alive_s + 2:  # as a browser, which answers each ping
                    alive_s = time.monotonic()
                    for page in pages:
                        page.sendall(PONG)
                for one, _ in ready.select(0.2):
                    taken = one.fileobj.recv(1 << 20)
                    assert taken, "the console has closed a page"
                    got[0] += len(taken)

    thread = threading.Thread(target=read)
    thread.start()
    try:
        yield got
    finally:
        ended.set()
        thread.join()
        for page in pages:
            page.close()


class Shop:
    def __init__(self, given, folder):
        self.intaglio = pathlib.Path(given.bin) / "intaglio"
        self.place = ["--domain", "49", "--tag", f"stop{os.getpid()}"]
        log = folder / "up.txt"
        with open(log, "w") as out:
            self.up = subprocess.Popen(
                [self.intaglio, "up", "--console", "--folder", folder / "shop", "--materials",
                 folder / "materials.db", "--block", *BLOCK_MM, *self.place],
                stdout=out, stderr=out)
        eventually(lambda: "the shop is open" in log.read_text(), 60)
        self.url = next(line.split()[-1] for line in log.read_text().splitlines()
                        if line.startswith("web console: "))
        self.port = int(re.search(r":(\d+)/", self.url)[1])
        self.key = "Authorization: Bearer " + self.url.split("key=")[1]

    def run(self, *words):
        return subprocess.run([self.intaglio, *words, *self.place], check=True,
                              stdout=subprocess.PIPE, text=True).stdout

    def process(self, name):
        """The id of this program, which `up` has started."""
        for child in pathlib.Path(f"/proc/{self.up.pid}/task/{self.up.pid}/children") \
                .read_text().split():
            words = pathlib.Path(f"/proc/{child}/cmdline").read_bytes().split(b"\0")
            if words[0].decode().endswith("/" + name):
                return int(child)
        raise AssertionError(f"{name} does not run")

    def kill_job_service(self):
        """For good: `up`, which would start it again, rests from now on."""
        service = self.process("intaglio-job-service")
        self.up.send_signal(signal.SIGSTOP)
        os.kill(service, signal.SIGKILL)

    def reset(self):
        self.run("stop", "els-03", "--reset")

    def close(self):
        self.up.send_signal(signal.SIGCONT)
        self.up.send_signal(signal.SIGINT)
        self.up.wait(60)


def press_by_request(shop, connection):
    """How long it takes, s, and the number of the press."""
    began = time.monotonic()
    connection.request("POST", "/api/v1/stop", headers=dict([shop.key.split(": ")]))
    answer = json.loads(connection.getresponse().read())
    took = time.monotonic() - began
    assert answer["confirmed"], answer
    return took, answer["number"]


def read_message(page):
    first, size = page._take(2, 20)
    if size == 126:
        size = int.from_bytes(page._take(2, 5), "big")
    elif size == 127:
        size = int.from_bytes(page._take(8, 5), "big")
    body = page._take(size, 5)
    return json.loads(body) if first & 15 == 1 else {}


def press_by_message(page, number):
    """To the first state in which each machine has confirmed this press."""
    text = b'{"stop": {}}'
    began = time.monotonic()
    page.socket.sendall(bytes([0x81, 0x80 | len(text)]) + bytes(4) + text)
    while True:
        stop = read_message(page).get("stop", {})
        if stop.get("number") == number and stop.get("confirmed"):
            return time.monotonic() - began


def measure(shop, what, presses, between):
    connection = http.client.HTTPConnection("127.0.0.1", shop.port, timeout=60)
    times = {"request": [], "message": []}
    for _ in range(presses):
        between()
        took, number = press_by_request(shop, connection)
        times["request"].append(took)
    for _ in range(presses):
        between()
        page = Finger(shop.port, shop.key)
        number += 1
        times["message"].append(press_by_message(page, number))
        page.socket.close()
    for way, took in times.items():
        ms = [1000 * one for one in took]
        print(f"{what}, by a {way}: median {quantile(ms, 0.5):.1f} ms, p99 "
              f"{quantile(ms, 0.99):.1f} ms, most {max(ms):.1f} ms of {len(ms)}, load "
              f"{os.getloadavg()[0]:.1f}", flush=True)


def main():
    given = bench_arguments(__doc__, pages=50, presses=200, points=100000)
    folder = given.folder or pathlib.Path(tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)
    random_cloud(folder / "cloud.xyz", given.points)
    shop = Shop(given, folder)
    try:
        shop.run("submit", folder / "cloud.xyz", "--block", *BLOCK_MM)
        eventually(lambda: "waiting_for_arm" in shop.run("list", "--json"), 600)
        with open_pages(shop.port, shop.key, given.pages) as got, bulk_transfer(shop.url):
            measure(shop, f"{given.pages} pages and a bulk transfer", given.presses,
                    shop.reset)
            shop.kill_job_service()
            measure(shop, "the job service is killed, too", given.presses,
                    lambda: time.sleep(0.1))
        print(f"the pages have read {got[0] / 1e6:.1f} MB")
        rss = next(line for line in pathlib.Path(
            f"/proc/{shop.process('intaglio-console')}/status").read_text().splitlines()
                   if line.startswith("VmHWM"))
        print(f"console: {int(rss.split()[1]) / 1000:.0f} MB")
    finally:
        shop.close()
        if not given.folder:
            shutil.rmtree(folder)
    return 0


if __name__ == "__main__":
    sys.exit(main())
