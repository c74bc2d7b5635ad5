#!/usr/bin/env python3
"""A newcomer's first minutes and an operator's day, typed at terminals of 80 and of 40
columns: what is printed is true, fits, and says what to do next.

    terminal_test.py --intaglio build/release/bin/intaglio --folder /tmp/terminal
"""

import json
import os
import re
import shutil

from at_terminal import SOURCE, AtATerminal, main, options, screens_fit
from patience import eventually
from terminal import Terminal


class Newcomer(AtATerminal):
    def test_finds_the_way_from_a_bare_name_to_a_good_piece(self):
        bare = self.typed()
        for word in ("preview", "run", "--help"):
            self.assertIn(word, bare)
        self.assertIn("preview", self.typed("prewiew", exit_code=2))
        shutil.copy(SOURCE / "deploy/jobs/sample.obj", self.folder / "knot.obj")
        size = self.typed("preview", "knot.obj", "--height", "15", "--block", "a", "b", "c",
                          exit_code=2)
        self.assertIn("--block: 'a,b,c' cannot be read as numbers", size)
        job = ["knot.obj", "--up", "z", "--height", "15", "--block", "40x40x25", "--spacing", "0.4"]
        shown = self.typed("preview", *job, "--out", "look")
        self.assertRegex(shown, r"verdict +READY")
        page = re.search(r"page +(\S+)", shown).group(1)
        self.assertTrue((self.folder / page).is_file(), shown)
        for columns in (80, 40):
            out = f"out{columns}"
            made = self.typed("run", *job, "--lockstep", "--warm-up", "0", "--out", out,
                              columns=columns)
            self.assertRegex(made, r"verdict +GOOD")
            report = json.loads((self.folder / out / "report.json").read_text())
            self.assertEqual(report["points"]["made"], report["points"]["planned"])
            self.assertTrue((self.folder / out / "views.png").is_file())
        self.assertRegex(self.typed("verify", "out80"), r"verdict +GOOD")


class Operator(AtATerminal):
    """In real time, so that a person can intervene."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.shop = ["--domain", "48", "--tag", f"terminal-{os.getpid()}"]
        cls.job = cls.folder / "knot.textproto"
        cls.job.write_text(
            (SOURCE / "deploy/jobs/sample.textproto").read_text()
            .replace("sample.obj", str(SOURCE / "deploy/jobs/sample.obj"))
            .replace("../machines", str(SOURCE / "deploy/machines")))
        cls.up = Terminal([options.intaglio, "up", "--folder", "shop", "--block", "50", "50", "30",
                           "--warm-up", "0", *cls.shop], cwd=cls.folder)
        cls.addClassCleanup(cls.up.close)
        eventually(lambda: "the shop is open" in cls.up.text)

    def tell(self, *words, **given):
        return self.typed(*words, *self.shop, **given)

    def listed(self, number):
        """The record of a job, as programs read it."""
        jobs = json.loads(self.tell("list", "--json"))["jobs"]
        return next(job for job in jobs if job["job"] == number)

    def test_a_day(self):
        submitted = self.tell("submit", self.job, "--id", "order-1")
        self.assertIn("nothing of it fires before intaglio arm 1", submitted)
        again = self.tell("submit", self.job, "--id", "order-1")
        self.assertIn("job 1 ", again)
        self.tell("submit", self.job)
        queue = self.tell("list")
        self.assertIn("queued, place 1", queue)
        eventually(lambda: "job 1 waits for its arm" in self.tell("list"))
        status = self.tell("status", exit_code=4)
        self.assertIn("NEEDS A PERSON", status)
        self.assertIn("intaglio arm 1", status)
        self.tell("mount", "--block", "60", "30", "20")
        refused = self.tell("arm", "1", exit_code=4)
        self.assertIn("60 x 30 x 20", refused)
        self.tell("mount", "--block", "50", "50", "30")
        self.assertIn("50 x 50 x 30", self.tell("arm", "1"))
        for columns in (80, 40):
            watch = self.open("watch", "1", *self.shop, columns=columns)
            eventually(lambda: re.search(r"engrave.*[1-9]\d* %", watch.lines[-1]))
            watch.interrupt()
            self.assertEqual(watch.wait(), 6)
            self.assertTrue(screens_fit(watch), watch.redrawn())
            self.assertIn("left", watch.redrawn()[-1], "what changes stands in the line")
            self.assertIn("the job continues", watch.text)
        self.assertIn("intaglio resume 1", self.tell("pause", "1"))
        eventually(lambda: self.listed(1)["state"] == "paused")
        paused = self.tell("list")
        self.assertRegex(paused, r"paused .*\n +to do: .*intaglio resume 1")
        before = self.listed(1)["made"]
        self.assertEqual(self.listed(1)["made"], before, "nothing fires in a pause")
        self.tell("resume", "1")
        self.assertIn("50 %", self.tell("speed", "1", "50"))
        eventually(lambda: "at 50 % speed" in self.tell("list"))
        eventually(lambda: self.listed(1)["made"] > before)
        self.assertIn("at 50 % speed", self.tell("status", exit_code=0))
        self.tell("cancel", "1")
        self.tell("cancel", "2")
        self.check_what_became_of_them()
        self.up.interrupt()
        self.assertEqual(self.up.wait(), 0, self.up.text)

    def check_what_became_of_them(self):
        def settled():
            ended = json.loads(self.typed("history", "--folder", "shop", "--json"))["jobs"]
            rows = {row["job"]: row for row in ended}
            return len(rows) == 2 and all(row["verdict"] for row in rows.values()) and rows
        rows = eventually(settled)
        first, second = rows[1], rows[2]
        self.assertEqual((first["state"], first["verdict"]), ("cancelled", "not_good"))
        self.assertGreater(first["made"], 0)
        counted = sum(first[name] for name in ("made", "missed", "skipped", "uncertain"))
        self.assertEqual(counted, first["planned"])
        self.assertEqual((second["state"], second["verdict"], second["made"]),
                         ("cancelled", "none", 0))
        shown = self.tell("show", "1")
        self.assertRegex(shown, r"planned, [0-9 ]+ made")
        self.assertIn("cancelled by", shown)


if __name__ == "__main__":
    main(__doc__)
