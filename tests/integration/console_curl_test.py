#!/usr/bin/python3
"""The lines of curl in docs/console.md, as they stand there, against a shop; what they answer
is what docs/openapi.json says.

  console_curl_test.py --bin FOLDER_OF_PROGRAMS --folder FOLDER

Ends with 77 (skipped) where curl is not installed.
"""
import argparse
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

import jsonschema

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
DOCS = ROOT / "docs"


def documented_lines():
    """The code blocks between the two marks of the page."""
    text = (DOCS / "console.md").read_text()
    part = text.split("### With curl alone")[1].split("\n## ")[0]
    return "\n".join(re.findall(r"```\n(.*?)```", part, re.S))


def eventually(condition, seconds=60):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.2)
    raise AssertionError(f"not within {seconds} s: {condition.__name__}")


def check_answers(folder, ask):
    """Each answer without a choice is of the schema that the OpenAPI file names."""
    described = json.loads((DOCS / "openapi.json").read_text())
    checked = 0
    for path, operations in described["paths"].items():
        if "get" not in operations:
            continue
        content = operations["get"]["responses"]["200"]["content"]
        schema = content.get("application/json", {}).get("schema")
        if not schema or path.endswith("/report"):
            continue
        answer = json.loads(ask(path.replace("{job}", "1")))
        jsonschema.validate(answer, json.loads((DOCS / schema["$ref"]).read_text()))
        checked += 1
    assert checked >= 4, checked
    report = described["paths"]["/api/v1/jobs/{job}/report"]["get"]["responses"]["200"]
    schema = report["content"]["application/json"]["schema"]["$ref"]
    jsonschema.validate(json.loads((folder / "report.json").read_text()),
                        json.loads((DOCS / schema).read_text()))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", required=True, type=pathlib.Path)
    parser.add_argument("--folder", required=True, type=pathlib.Path)
    given = parser.parse_args()
    if not shutil.which("curl"):
        print("skipped: not installed: curl")
        return 77
    folder = given.folder
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    intaglio = given.bin / "intaglio"
    place = ["--domain", "49", "--tag", f"curl{os.getpid()}"]
    subprocess.run(["sh", "-c", f"mkdir -p shop && echo 'correct horse' | {intaglio} console user "
                    "add anna --role operator --users shop/console.users"], cwd=folder, check=True)
    log = open(folder / "up.txt", "w")
    up = subprocess.Popen([intaglio, "up", "--console", "--folder", "shop", "--materials",
                           "materials.db", "--warm-up", "1", "--speed", "4", "--picture-size",
                           "400", *place], cwd=folder, stdout=log, stderr=log)
    try:
        def is_open():
            assert up.poll() is None, (folder / "up.txt").read_text()
            return "the shop is open" in (folder / "up.txt").read_text()

        eventually(is_open)
        subprocess.run([intaglio, "submit", ROOT / "deploy/jobs/sample.textproto", "--height", "4",
                        "--spacing", "0.5", *place], check=True, capture_output=True)
        script = "set -e\n" + documented_lines()
        done = subprocess.run(["bash", "-c", script], cwd=folder, text=True, timeout=200,
                              capture_output=True)
        assert done.returncode == 0, (done.stdout, done.stderr)

        def ask(path):
            return subprocess.run(["curl", "-sf", "-b", "cookies",
                                   "http://127.0.0.1:" + re.search(
                                       r":(\d+)/", (folder / "shop/console.address").read_text())[1]
                                   + path], cwd=folder, check=True, capture_output=True,
                                  text=True).stdout

        check_answers(folder, ask)
    finally:
        up.send_signal(signal.SIGINT)
        up.wait(30)
    return 0


if __name__ == "__main__":
    sys.exit(main())
