#!/usr/bin/python3
"""The lines of curl in docs/console.md, as they stand there, against a shop; what they answer
is what docs/openapi.json says.

  console_curl_test.py --bin FOLDER_OF_PROGRAMS --schemas build/release/docs/schemas --folder FOLDER

Ends with 77 (skipped) where curl is not installed.
"""
import argparse
import csv
import io
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys

import jsonschema

from patience import eventually
from png_files import png

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
DOCS = ROOT / "docs"


def documented_lines():
    """The code blocks of this part of the page."""
    text = (DOCS / "console.md").read_text()
    part = re.split(r"\n##+ ", text.split("### With curl alone")[1])[0]
    return "\n".join(re.findall(r"```\n(.*?)```", part, re.S))


def check_answers(folder, schemas, ask):
    """Each answer without a choice is of the schema that the OpenAPI file names."""
    described = json.loads((DOCS / "openapi.json").read_text())
    checked = 0
    for path, operations in described["paths"].items():
        if "get" not in operations:
            continue
        content = operations["get"]["responses"]["200"]["content"]
        schema = content.get("application/json", {}).get("schema")
        # The first is made later, the other is of a focus series (console_teach_test.py).
        if not schema or path.endswith(("/report", "/zero_move")):
            continue
        parts = {"{cell}": "els-03", "{job}": "1", "{id}": "order-7", "{file}": "sample.obj"}
        for part, value in parts.items():
            path = path.replace(part, value)
        answer = json.loads(ask(path))
        jsonschema.validate(answer, json.loads((schemas.parent / schema["$ref"]).read_text()))
        checked += 1
    assert checked >= 4, checked
    report = described["paths"]["/api/v1/jobs/{job}/report"]["get"]["responses"]["200"]
    schema = report["content"]["application/json"]["schema"]["$ref"]
    jsonschema.validate(json.loads((folder / "report.json").read_text()),
                        json.loads((schemas.parent / schema).read_text()))


def check_photo(curl, folder):
    """A photo of the block is kept in the job's folder; what is none is refused by its name."""
    good = png(40, 30)
    kept = list((folder / "shop/jobs").glob("1-*"))[0]
    assert curl("/photos/1")[0] == 404
    for name, content, status, reason in (
            ("notes.jpg", b"no picture", 422, "save the photo as one of these"),
            ("cut.png", good[:60], 422, ""),
            ("huge.png", png(5000, 3000), 413, ""),
            ("long.png", b"\x89PNG\r\n" + bytes(9 << 20), 413, "fewer pixels")):
        (folder / name).write_bytes(content)
        code, refused = curl(f"/photos/1?name={name}", "--data-binary", "@" + name)
        assert code == status and refused["message"].startswith(name + ": ") and \
            reason in refused["message"], (name, code, refused)
    assert not list(kept.glob("block_photo*")), "nothing of these is kept"
    (folder / "good.png").write_bytes(good)
    code, taken = curl("/photos/1?name=good.png", "--data-binary", "@good.png")
    assert code == 200 and taken["taken"], taken
    assert (kept / "block_photo.png").read_bytes() == good
    assert curl("/photos/9", "--data-binary", "@good.png")[0] == 404


def check_submissions(folder, schemas):
    """Everything again submits nothing twice; what is wrong with a job is answered."""
    address = re.search(r":(\d+)/", (folder / "shop/console.address").read_text())[1]
    url = f"http://127.0.0.1:{address}/api/v1"

    def curl(path, *words):
        done = subprocess.run(["curl", "-s", "-b", "cookies", "-w", "\n%{http_code}", *words,
                               url + path], cwd=folder, check=True, capture_output=True,
                              text=True)
        body, code = done.stdout.rsplit("\n", 1)
        return int(code), json.loads(body)

    def schema(name):
        return json.loads((schemas / f"{name}.schema.json").read_text())

    file, order = "/submissions/order-7/files/sample.obj", "/submissions/order-7"
    code, sent = curl(file, "--data-binary", "@sample.obj")
    assert code == 200 and sent["complete"], (code, sent)
    jsonschema.validate(sent, schema("upload_answer"))
    code, again = curl(order, "--data-binary", "@knot.textproto")
    assert code == 200 and again["job"] == 1, (code, again)
    jsonschema.validate(again, schema("submit_answer"))
    (folder / "other.textproto").write_text(
        (folder / "knot.textproto").read_text().replace("trefoil", "other"))
    code, other = curl(order, "--data-binary", "@other.textproto")
    assert code == 422 and "was used for another job" in other["message"], (code, other)
    code, preview = curl(order + "/preview", "--data-binary", "@knot.textproto")
    assert code == 200 and preview["verdict"].startswith("ready"), (code, preview)
    jsonschema.validate(preview, schema("preview"))
    picture = subprocess.run(["curl", "-sf", "-b", "cookies", url + order + "/preview"], cwd=folder,
                             check=True, capture_output=True).stdout
    assert picture[:4] == b"\x89PNG", picture[:60]
    (folder / "ice.textproto").write_text(
        re.sub('glass: "[^"]*"', 'glass: "ICE"', (folder / "knot.textproto").read_text()))
    curl("/submissions/order-9/files/sample.obj", "--data-binary", "@sample.obj")
    for target, reason in ((order + "/preview", "not_found"),
                           ("/submissions/order-9", "refused")):
        code, refused = curl(target, "--data-binary", "@ice.textproto")
        assert code == 422 and refused["code"] == reason, (target, code, refused)
        assert refused["message"].startswith('glass: there is no glass "ICE"'), refused
    code, nothing = curl("/nothing")
    assert code == 404 and nothing["code"] == "not_found", (code, nothing)
    check_photo(curl, folder)
    for method, path, allow in (("POST", "/status", "GET"), ("GET", "/jobs/1/arm", "POST"),
                                ("GET", order, "POST")):
        head = subprocess.run(["curl", "-s", "-b", "cookies", "-o", "/dev/null", "-D", "-", "-X",
                               method, url + path], cwd=folder, check=True, capture_output=True,
                              text=True).stdout.splitlines()
        assert " 405 " in head[0] and f"Allow: {allow}" in head, (method, path, head)
    code, other = curl(file, "--data-binary", "@other.textproto")
    assert code == 409, (code, other)
    (folder / "wrong.textproto").write_text('models { file: "/etc/passwd" }')
    code, wrong = curl("/submissions/order-8", "--data-binary", "@wrong.textproto")
    assert code == 422 and "models[0].file" in wrong["message"], (code, wrong)
    (folder / "wrong.textproto").write_text('name: "no model" glass: "N-BK7"')
    code, wrong = curl("/submissions/order-8", "--data-binary", "@wrong.textproto")
    assert code == 422 and "models" in wrong["message"], (code, wrong)
    assert curl("/jobs")[1]["jobs"] and len(curl("/jobs")[1]["jobs"]) == 1
    code, history = curl("/history?name=TREFOIL")
    assert code == 200 and len(history["jobs"]) == 1, (code, history)
    assert not curl("/history?verdict=none")[1]["jobs"]
    assert curl("/history?verdict=splendid")[0] == 400
    assert curl("/days.csv?since=splendid")[0] == 400
    days = list(csv.DictReader((folder / "days.csv").open(newline="")))
    assert len(days) == 1 and days[0]["pieces"] == "1" and float(days[0]["engraving_s"]) > 0, days
    assert days[0]["cell"] == "els-03" and days[0]["good"] == "1", days
    # A connection that breaks in the middle, and the rest after it.
    large = os.urandom(3_000_000)
    (folder / "large.stl").write_bytes(large)
    (folder / "half.stl").write_bytes(large[:1_000_001])
    file = "/submissions/order-9/files/large.stl"
    code, part = curl(file + f"?size={len(large)}", "--data-binary", "@half.stl")
    assert code == 200 and part["received_bytes"] == 1_000_001 and not part["complete"], part
    (folder / "rest.stl").write_bytes(large[1_000_001:])
    code, whole = curl(file + "?offset=1000001", "--data-binary", "@rest.stl")
    assert code == 200 and whole["complete"], (code, whole)
    assert (folder / "shop/uploads/order-9/large.stl").read_bytes() == large


def check_client(folder):
    """The module of python3-intaglio, and the script of deploy/examples that uses it."""
    sys.path.insert(0, str(ROOT / "deploy/python"))
    sys.dont_write_bytecode = True
    import intaglio_console

    line = re.search(r"^deploy/examples/submit_order.py .*$", (DOCS / "console.md").read_text(),
                     re.M)[0]
    submitted = subprocess.run(["sh", "-c", f"{ROOT}/{line}"], cwd=folder, check=True,
                               capture_output=True, text=True).stdout
    assert submitted == "job 1\n", submitted
    shop = intaglio_console.Console((folder / "shop/console.address").read_text().strip())
    assert shop.session()["name"] == "this computer"
    again = shop.submit("order-7", folder / "knot.textproto", [folder / "sample.obj"])
    assert again["job"] == 1, again
    seen = []
    state = shop.upload("order-10", folder / "large.stl", lambda *now: seen.append(now))
    assert state["complete"] and seen == [(3_000_000, 3_000_000)], (state, seen)
    (folder / "longer.stl").write_bytes(os.urandom(9_000_000))
    assert shop.upload("order-10", folder / "longer.stl", lambda *now: seen.append(now))["complete"]
    assert len(seen) == 4, seen
    assert (folder / "shop/uploads/order-10/longer.stl").read_bytes() == \
        (folder / "longer.stl").read_bytes()
    assert [record["state"] for record in shop.follow(1)] == ["done"]
    assert shop.report(1)["name"] == "trefoil knot"
    assert shop.picture(1)[:4] == b"\x89PNG"
    planned = shop.history(name="knot")[0]["planned"]
    table = list(csv.DictReader(io.StringIO(shop.history_table(name="knot"))))
    assert len(table) == 1 and table[0]["planned"] == str(planned), table
    assert len(list(csv.DictReader(io.StringIO(shop.days_table(verdict="none"))))) == 0
    points, made = shop.plan(1), shop.made(1)
    assert len(points) == planned == len(made), (len(points), planned, len(made))
    assert all(0 < points[0][axis] < limit for axis, limit in enumerate((50, 50, 30)))
    assert "intaglio_pieces_total" in shop.metrics()
    try:
        shop.pause(1)
        raise AssertionError("a job that has ended was paused")
    except intaglio_console.Refused as refused:
        assert refused.status == 409 and refused.code == "ended_job", refused.answer
    assert shop.stop("smoke")["sent"]
    # The dashboard of deploy/ shows figures that there are.
    shown = set(re.findall(r"\bintaglio_[a-z_]+", (ROOT / "deploy/grafana/shop.json").read_text()))
    unknown = [name for name in shown if name not in shop.metrics()]
    assert not unknown and len(shown) >= 6, (unknown, shown)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", required=True, type=pathlib.Path)
    parser.add_argument("--schemas", required=True, type=pathlib.Path)
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
        shutil.copy(ROOT / "deploy/jobs/sample.obj", folder)
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

        check_answers(folder, given.schemas, ask)
        check_submissions(folder, given.schemas)
        check_client(folder)
    finally:
        up.send_signal(signal.SIGINT)
        up.wait(30)
    return 0


if __name__ == "__main__":
    sys.exit(main())
