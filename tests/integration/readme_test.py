#!/usr/bin/env python3
"""Runs each command line of README.md's section "Engrave your own model" as it stands there,
with small files of the names that it uses. What it writes is looked for.

    readme_test.py --intaglio build/release/bin/intaglio --folder /tmp/readme
"""

import argparse
import base64
import contextlib
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

SOURCE = pathlib.Path(__file__).resolve().parents[2]
PATIENCE_S = 200

# A slender pyramid that stands on y, so that it has few points at README's height.
MODEL = """v -.02 0 -.02
v .02 0 -.02
v .02 0 .02
v -.02 0 .02
v 0 1 0
f 1 2 3 4
f 2 1 5
f 3 2 5
f 4 3 5
f 1 4 5
"""
# A white disc on black, 48 x 48 pixels.
PHOTO = base64.b64decode(
    "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDABQODxIPDRQSEBIXFRQYHjIhHhwcHj0sLiQySUBMS0dARkVQWnNi"
    "UFVtVkVGZIhlbXd7gYKBTmCNl4x9lnN+gXz/wAALCAAwADABAREA/8QAHwAAAQUBAQEBAQEAAAAAAAAAAAEC"
    "AwQFBgcICQoL/8QAtRAAAgEDAwIEAwUFBAQAAAF9AQIDAAQRBRIhMUEGE1FhByJxFDKBkaEII0KxwRVS0fAk"
    "M2JyggkKFhcYGRolJicoKSo0NTY3ODk6Q0RFRkdISUpTVFVWV1hZWmNkZWZnaGlqc3R1dnd4eXqDhIWGh4iJ"
    "ipKTlJWWl5iZmqKjpKWmp6ipqrKztLW2t7i5usLDxMXGx8jJytLT1NXW19jZ2uHi4+Tl5ufo6erx8vP09fb3"
    "+Pn6/9oACAEBAAA/AOUpVVnYKilmPQAZNX49GunUH5F9if8AClbRbpVJzGcdgTz+lUJInhcpIpVvQ02lRS7q"
    "qjLMcAV1WmaakEa/KDIR8zf57VsR2ox0pXtRjpWXqGnxzIVdQfQ9x9K5KaJoJWjkxuU84q7oqB77kfdUkfoP"
    "612dpGMCtKOMYpXjGKz7qMYNch4gjCzRMByQQfw//XUOhsFvuSBlCB78iuztHGBWlG4xSu4xWfdOMGuQ8QuG"
    "liAIyM8flWTFI0MqyIcMpyK67Tr9ZoVdSOeoz0PpWtHcjHWle5GOtZ17eJHGzOwCjqa466uGuZ2lfjPQZ6Co"
    "qfDNJA++JiretakevSqoDRBj6hsUr6/IykCEA9iWz/Ssy4uZbl90rZx0HYVFX//Z"
)
BOARD = """%FSLAX46Y46*%
%MOMM*%
%ADD10C,2*%
D10*
X0Y0D03*
X5000000Y0D03*
M02*
"""
HOLES = """M48
METRIC
T1C0.8
%
T1
X0.0Y0.0
X5.0Y0.0
M30
"""
PLATE = """<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" viewBox="0 0 40 30">
<path d="M5 5h30v20H5z"/></svg>
"""
# What a command leaves in the folder of its option --out.
LEFT_BY_RUN = ["report.json", "views.png"]


def commands():
    """The lines of the section's block, with those that end in a backslash joined."""
    text = (SOURCE / "README.md").read_text()
    section = text.split("## Engrave your own model", 1)[1]
    block = section.split("```", 2)[1].strip("\n")
    return block.replace("\\\n", " ").split("\n")


def make_files(folder):
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "bunny.obj").write_text(MODEL)
    (folder / "photo.jpg").write_bytes(PHOTO)
    (folder / "board.gbr").write_text(BOARD)
    (folder / "board.drl").write_text(HOLES)
    (folder / "plate.svg").write_text(PLATE)
    (folder / "deploy").symlink_to(SOURCE / "deploy")


def run(line, folder, environment):
    ended = subprocess.run(["bash", "-c", line], cwd=folder, env=environment, text=True,
                           stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                           timeout=PATIENCE_S, check=False)
    if ended.returncode != 0:
        sys.exit(f"{line}\nended with {ended.returncode}:\n{ended.stdout}")
    return ended.stdout


class Shop:
    """A shop that stays open, from its line on to the end of the test."""

    def __init__(self, line, folder, environment):
        self.line = line
        self.log = folder / "up.txt"
        with open(self.log, "w") as output:
            self.process = subprocess.Popen(["bash", "-c", "exec " + line], cwd=folder,
                                            env=environment, stdout=output,
                                            stderr=subprocess.STDOUT)
        deadline = time.monotonic() + PATIENCE_S
        while subprocess.run(["intaglio", "list"], env=environment, cwd=folder,
                             capture_output=True, check=False).returncode != 0:
            if self.process.poll() is not None or time.monotonic() > deadline:
                self.close()
                sys.exit(f"{line}\nanswers nothing:\n{self.log.read_text()}")
            time.sleep(0.2)

    def close(self):
        self.process.send_signal(signal.SIGINT)
        if self.process.wait(PATIENCE_S) != 0:
            sys.exit(f"{self.line}\nended with {self.process.returncode}:\n"
                     f"{self.log.read_text()}")


def word_after(line, option):
    words = line.split("#")[0].split()
    return words[words.index(option) + 1] if option in words else None


def check_files(line, folder):
    for option in ["--out", "--picture", "--page"]:
        name = word_after(line, option)
        if name is None:
            continue
        path = folder / name
        if not path.exists():
            sys.exit(f"{line}\nleft no {name}")
        for file in LEFT_BY_RUN if path.is_dir() else []:
            if not (path / file).exists():
                sys.exit(f"{line}\nleft no {name}/{file}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--intaglio", required=True, type=pathlib.Path)
    parser.add_argument("--folder", required=True, type=pathlib.Path)
    options = parser.parse_args()
    folder = options.folder.resolve()
    make_files(folder)
    environment = dict(os.environ)
    environment["PATH"] = f"{options.intaglio.resolve().parent}:{environment['PATH']}"
    environment["INTAGLIO_MATERIALS_DB"] = str(folder / "materials.db")
    environment["INTAGLIO_TAG"] = f"readme-{os.getpid()}"
    count = 0
    with contextlib.ExitStack() as shops:
        for line in commands():
            if line.startswith("PATH="):
                continue  # the test's own programs
            count += 1
            began = time.monotonic()
            if line.startswith("intaglio up"):
                shops.callback(Shop(line.split("#")[0].strip(), folder, environment).close)
            else:
                run(line, folder, environment)
                check_files(line, folder)
            print(f"{time.monotonic() - began:6.1f} s  {line}", flush=True)
    if count < 10:
        sys.exit(f"README.md has {count} command lines: is its section another one?")


if __name__ == "__main__":
    main()
