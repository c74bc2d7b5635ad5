#!/usr/bin/env python3
"""What scripts rely on: every JSON that the commands write is as its schema, which the
build writes, says, and the module deploy/examples/intaglio.py works on real processes.

    scripts_test.py --intaglio build/release/bin/intaglio --folder /tmp/scripts
        --schemas build/release/docs/schemas

Needs Debian's python3-jsonschema.
"""

import argparse
import copy
import dataclasses
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import unittest

import jsonschema

SOURCE = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = SOURCE / "deploy" / "examples"
sys.path.insert(0, str(EXAMPLES))
import intaglio  # noqa: E402  (the module that is tested)

PATIENCE_S = 120
options = argparse.Namespace()

KNOT = f"""name: "knot"
models {{ file: "{SOURCE / 'deploy/jobs/sample.obj'}" placement {{ fit_height_mm: 5 }} }}
block {{ size_mm {{ x: 30 y: 30 z: 15 }} }}
glass: "N-BK7"
discretization {{ min_spacing_mm: 0.5 }}
ordering {{ smooth {{ }} }}
machine_file: "{SOURCE / 'deploy/machines/els-03.textproto'}"
"""


def schema(name):
    """The schema, stricter than it is published: no member may be missing in it."""
    whole = json.loads((options.schemas / f"{name}.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(whole)

    def close(part):
        if isinstance(part, dict):
            if "properties" in part and part.get("type") == "object":
                part.setdefault("additionalProperties", False)
            for below in part.values():
                close(below)
        elif isinstance(part, list):
            for below in part:
                close(below)

    close(whole)
    return whole


def validate(value, name):
    jsonschema.Draft202012Validator(schema(name)).validate(value)


def typed(*words, exit_codes=(0,)):
    """Types a command; what it wrote to the standard output."""
    command = [options.intaglio, *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False,
                          stdin=subprocess.DEVNULL)
    if done.returncode not in exit_codes:
        raise AssertionError(f"{command} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return done.stdout


def typed_json(name, *words, exit_codes=(0,)):
    """The JSON of a command, as its schema says."""
    value = json.loads(typed(*words, exit_codes=exit_codes))
    validate(value, name)
    return value


class Folder(unittest.TestCase):
    """Each test class has a folder and no shop of others."""

    @classmethod
    def setUpClass(cls):
        cls.folder = options.folder / cls.__name__
        shutil.rmtree(cls.folder, ignore_errors=True)
        cls.folder.mkdir(parents=True)
        os.environ["INTAGLIO_MATERIALS_DB"] = str(cls.folder / "materials.db")
        cls.knot = cls.folder / "knot.textproto"
        cls.knot.write_text(KNOT)


class SchemasTest(Folder):
    def test_each_is_a_schema_and_refuses_what_is_not_as_it_says(self):
        for file in sorted(options.schemas.glob("*.schema.json")):
            whole = schema(file.name.split(".")[0])
            self.assertEqual(whole["$id"], file.name)
        event = json.loads(json.dumps(dataclasses.asdict(intaglio.Event())))
        validate(event, "event")
        for name, wrong in (("job", "1"), ("done", -1), ("armed", 0), ("state", None)):
            with self.assertRaises(jsonschema.ValidationError):
                validate({**event, name: wrong}, "event")
        missing = copy.copy(event)
        del missing["uid"]
        with self.assertRaises(jsonschema.ValidationError):
            validate(missing, "event")

    def test_the_dataclasses_of_the_module_have_all_members(self):
        for kind, name in ((intaglio.Event, "event"), (intaglio.Job, "job")):
            names = {field.name for field in dataclasses.fields(kind)}
            self.assertEqual(names, set(schema(name)["properties"]), name)
        for kind, name, message in ((intaglio.Statistics, "history", "JobStatistics"),
                                    (intaglio.Stage, "job", "StageRecord"),
                                    (intaglio.PieceWarning, "event", "WarningRecord")):
            names = {field.name for field in dataclasses.fields(kind)}
            self.assertEqual(names, set(schema(name)["$defs"][message]["properties"]), message)

    def test_what_works_without_a_shop(self):
        cloud, path = self.folder / "cloud.ply", self.folder / "path.ply"
        made = typed_json("cloud", "discretize", self.knot, "--out", cloud, "--json")
        self.assertEqual(made["file"], str(cloud))
        self.assertGreater(made["point_count"], 50)
        preview = typed_json("preview", "preview", self.knot, "--json",
                             "--out", self.folder / "preview")
        self.assertEqual(preview["cloud_checksum"], made["checksum"])
        block = ["--block", 30, 30, 15]
        order = typed_json("plan", "sort", "--cloud", cloud, "--out", path, *block, "--json")
        self.assertEqual(int(order["point_count"]), made["point_count"])
        typed_json("plan", "plan", "--path", path, *block, "--compare", "--json")
        measured = typed_json("quality", "measure", cloud, "--job", self.knot, "--json")
        self.assertEqual(int(measured["point_count"]), made["point_count"])
        fonts = typed_json("fonts", "fonts", "DejaVu Sans", "--text", "Ł\u0e01", "--json")["fonts"]
        self.assertGreater(len(fonts), 1)
        for font in fonts:
            self.assertIn("DejaVu Sans", font["family"])
            self.assertTrue(pathlib.Path(font["file"]).is_file())
            self.assertIn("\u0e01", font["missing"])  # a Thai letter, which DejaVu has not
            self.assertFalse(font["has_text"])
        typed_json("glass", "materials", "show", "N-BK7", "--json")
        self.assertGreater(len(typed_json("glasses", "materials", "list", "--json")), 3)
        job = json.loads((SOURCE / "deploy/jobs/rays.json").read_text())
        validate(job, "job_file")


class RunTest(Folder):
    def test_a_run_is_followed_and_proved(self):
        machine = intaglio.Intaglio(options.intaglio)
        out = self.folder / "out"
        with machine.run(self.knot, "--lockstep", "--warm-up", "0", out=out) as run:
            events = list(run)
        for event in events:
            validate(json.loads(json.dumps(dataclasses.asdict(event))), "event")
        self.assertEqual(events[0].event, "submitted")
        self.assertTrue(events[-1].ended)
        self.assertEqual(events[-1].verdict, "good")
        self.assertEqual(events[-1].result_directory, str(out))
        report = machine.report(out)
        validate(report, "report")
        self.assertEqual(int(report["points"]["made"]), events[-1].made)
        typed_json("report", "verify", out, "--json")
        recording = out / "session.mcap"
        info = typed_json("recording_info", "recording", "info", recording, "--json")
        listed = typed_json("recording_channels", "recording", "list", recording, "--json")
        self.assertEqual(info["channel_count"], len(listed["channels"]))
        compared = typed_json("replay_comparison", "replay", recording, "--against", "sorter", "--json")
        self.assertTrue(compared["identical"])

    def test_a_run_of_marks_is_proved(self):
        (self.folder / "square.svg").write_text(
            '<svg xmlns="http://www.w3.org/2000/svg" width="4mm" height="2mm" '
            'viewBox="0 0 4 2"><rect width="2" height="2"/><circle cx="3" cy="1" r="0.5"/></svg>')
        job = self.folder / "marks.textproto"
        job.write_text('machine_file: "galvo" marks { items { drawing { file: "square.svg" } } '
                       'pen { speed_mm_s: 500 } }')
        machine = intaglio.Intaglio(options.intaglio)
        out = self.folder / "marks"
        with machine.run(job, "--lockstep", "--no-record", out=out) as run:
            events = list(run)
        self.assertEqual(events[-1].verdict, "good")
        report = machine.report(out)
        validate(report, "report")
        self.assertEqual(int(report["marks"]["counts"]["made"]), 2)
        self.assertEqual(report["evidence"], "material")

    def test_a_wrong_job_raises_with_code_and_message(self):
        machine = intaglio.Intaglio(options.intaglio)
        with self.assertRaises(intaglio.WrongInput) as raised:
            list(machine.run("nowhere.textproto", out=self.folder / "none"))
        self.assertEqual(raised.exception.exit_code, 2)
        self.assertIn("nowhere.textproto", raised.exception.message)


class ShopTest(Folder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.bus = {"domain": 47, "tag": f"scripts-{os.getpid()}"}
        cls.words = ["--domain", "47", "--tag", cls.bus["tag"]]
        cls.shop = intaglio.Intaglio(options.intaglio, **cls.bus)
        cls.shop_folder = cls.folder / "shop"
        log = cls.folder / "up.txt"
        with log.open("w") as output:
            cls.up = subprocess.Popen(
                [options.intaglio, "up", "--lockstep", "--warm-up", "0", "--folder",
                 str(cls.shop_folder), "--block", "30", "30", "15", *cls.words],
                stdout=output, stderr=subprocess.STDOUT)
        cls.addClassCleanup(cls.close)
        end = time.monotonic() + PATIENCE_S
        while "the shop is open" not in log.read_text():
            if cls.up.poll() is not None or time.monotonic() > end:
                raise AssertionError(log.read_text())
            time.sleep(0.1)

    @classmethod
    def close(cls):
        cls.up.send_signal(signal.SIGINT)
        cls.up.wait(timeout=PATIENCE_S)

    def row(self, job):
        """Of the job's end in the history, which is written a moment after it."""
        for _ in range(PATIENCE_S * 10):
            rows = self.shop.history(folder=self.shop_folder, job=job)
            if rows and rows[0].verdict:
                return rows[0]
            time.sleep(0.1)
        raise AssertionError(f"job {job} is not in the history")

    def test_a_job_is_submitted_followed_and_in_the_history(self):
        accepted = self.shop.submit(self.knot, arm=True)
        self.assertEqual(accepted.name, "knot")
        with self.shop.watch(accepted.job) as watch:
            events = list(watch)
        for event in events:
            validate(json.loads(json.dumps(dataclasses.asdict(event))), "event")
        last, row = events[-1], self.row(accepted.job)
        self.assertTrue(last.ended)
        self.assertGreater(last.made, 50)
        for name in ("verdict", "planned", "made", "missed", "skipped", "uncertain", "uid", "state"):
            self.assertEqual(getattr(last, name), getattr(row, name), name)
        job = self.shop.job(accepted.job)
        self.assertEqual((job.verdict, job.made, job.planned), (row.verdict, row.made, row.planned))
        self.assertEqual(job.result_directory, row.result_directory)
        self.assertEqual(last.result_directory, row.result_directory)
        self.assertIn(job.uid, [listed.uid for listed in self.shop.jobs()])
        validate(json.loads((pathlib.Path(job.result_directory) / "statistics.json").read_text()),
                 "statistics")
        typed_json("jobs", "list", "--json", *self.words)
        typed_json("status", "status", "--json", *self.words, exit_codes=(0, 4))
        typed_json("job", "show", accepted.job, "--json", *self.words)
        typed_json("history", "history", "--folder", self.shop_folder, "--json")

    def test_what_the_shop_refuses_has_a_code(self):
        first, second = self.shop.submit(self.knot), self.shop.submit(self.knot)
        waits = typed_json("command_answer", "arm", second.job, "--json", *self.words,
                           exit_codes=(4,))
        self.assertEqual((waits["job"], waits["taken"], waits["code"]),
                         (second.job, False, "not_yet"))
        self.assertNotIn("not_yet", waits["message"])
        entries = typed_json("logs", "logs", second.job, "--folder", self.shop_folder,
                             "--json")["entries"]
        self.assertIn("job-service", [entry["service"] for entry in entries])
        self.assertTrue(all(entry["text"] and entry["time"] and entry["level"] for entry in entries))
        given = typed_json("command_answer", "submit", self.knot, "--json", *self.words)
        for job in (given["job"], second.job, first.job):
            ended = typed_json("command_answer", "cancel", job, "--json", *self.words)
            self.assertEqual((ended["job"], ended["code"]), (job, "taken"))
        with self.assertRaises(intaglio.WrongInput) as unknown:
            self.shop.job(4321)
        self.assertEqual(unknown.exception.code, "not_found")
        self.assertIn("4321", str(unknown.exception))

    def test_an_interrupted_watch_leaves_the_job_and_a_cancelled_one_raises(self):
        accepted = self.shop.submit(self.knot)
        watch = self.shop.watch(accepted.job)
        next(watch)
        watch.interrupt()
        with self.assertRaises(intaglio.StillRuns) as left:
            list(watch)
        self.assertEqual(left.exception.exit_code, 6)
        self.assertIn(f"intaglio cancel {accepted.job}", watch.text)
        self.assertNotIn(self.shop.job(accepted.job).state, ("done", "failed", "cancelled"))
        cancelled = typed_json("command_answer", "cancel", accepted.job, "--json", *self.words)
        self.assertEqual((cancelled["job"], cancelled["taken"], cancelled["code"]),
                         (accepted.job, True, "taken"))
        again = typed_json("command_answer", "cancel", accepted.job, "--json", *self.words,
                           exit_codes=(2,))
        self.assertEqual((again["job"], again["taken"], again["code"]),
                         (accepted.job, False, "ended_job"))
        with self.assertRaises(intaglio.Cancelled) as ended:
            list(self.shop.watch(accepted.job))
        self.assertEqual(ended.exception.exit_code, 5)
        row = self.row(accepted.job)
        for name in ("verdict", "planned", "made", "missed", "skipped", "uncertain", "state"):
            self.assertEqual(getattr(ended.exception.event, name), getattr(row, name), name)

    def test_a_batch_has_results_and_events(self):
        batch = self.folder / "knots.jsonl"
        batch.write_text('{"id": "a", "job": "knot.textproto"}\n'
                         '{"id": "b", "job": "knot.textproto", "overrides": {"name": "second"}}\n')
        results = self.folder / "results.json"
        lines = typed("batch", batch, "--arm", "--same-block", "--events", "--results", results,
                      *self.words)
        for line in lines.splitlines():
            validate(json.loads(line), "event")
        made = json.loads(results.read_text())
        validate(made, "batch_results")
        self.assertEqual(made["good"], 2)

    def test_the_example_follows_a_job(self):
        done = subprocess.run(
            ["/usr/bin/python3", str(EXAMPLES / "one_job.py"), str(self.knot), "--arm", "--folder",
             str(self.shop_folder), "--intaglio", options.intaglio, *self.words],
            capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertRegex(done.stdout, r"done +engrave +100 %")
        self.assertRegex(done.stdout, r"job \d+: done, good")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--intaglio", required=True)
    parser.add_argument("--folder", type=pathlib.Path, required=True)
    parser.add_argument("--schemas", type=pathlib.Path, required=True)
    options, rest = parser.parse_known_args()
    options.folder = options.folder.resolve()
    options.folder.mkdir(parents=True, exist_ok=True)
    unittest.main(argv=[sys.argv[0], "-v", *rest])
