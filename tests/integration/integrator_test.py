#!/usr/bin/env python3
"""The week of an integrator: a profile for a new machine, its glass, what is taught at it,
who may do what, and its web console for other programs.

    integrator_test.py --intaglio build/release/bin/intaglio --folder /tmp/integrator
"""
import json
import os
import re
import subprocess
import urllib.error
import urllib.request

from at_terminal import AtATerminal, InAShop, main, options
from patience import eventually
from terminal import Terminal


class Profiles(AtATerminal):
    """Without a shop."""

    def test_1_a_machine_of_ones_own(self):
        self.assertIn("els-03", self.typed("machine", "new"))
        new = ["machine", "new", "els-03", "--no-questions", "--out", "shop-1.textproto"]
        self.assertIn("els-03", self.refused("not_found", "machine", "new", "els-04", "--out",
                                             "shop-1.textproto"))
        self.assertIn("it has: rates_hz", self.refused("not_found", *new, "--set",
                                                       "laser.rate=100"))
        self.assertFalse((self.folder / "shop-1.textproto").exists())
        made = self.typed(*new, "--name", "shop-1")
        self.assertIn("intaglio machine check shop-1.textproto", made)
        self.assertIn("exists already", self.refused("invalid_value", *new))
        checked = self.answered("machine", "check", "shop-1.textproto")
        self.assertEqual((checked["good"], checked["findings"]), (True, []))
        self.assertIn("/dev/ttyUSB0", checked["lines"][0]["not_compared"])
        (self.folder / "bad.textproto").write_text("name: 3")
        self.refused("unreadable", "machine", "check", "bad.textproto")

    def test_2_a_glass(self):
        self.assertIn("N-BK7", self.refused("not_found", "materials", "show", "N-BK8"))
        self.assertIn("n=1.52", self.refused("invalid_value", "materials", "show", "n=9"))
        self.assertRegex(self.typed("materials", "show", "n=1.52"), r"index +1\.52000\n")
        add = ["materials", "add", "own", "--formula", "rii_formula_5", "--coefficients", "1.53",
               "--range", "0.3", "2", "--source", "melt sheet"]
        self.assertEqual(self.answered(*add)["message"], "own: added")
        self.assertIn("is 2", self.refused("invalid_value", "materials", "replace", "own",
                                           "--poisson-ratio", "2"))
        self.assertIn("own: removed", self.typed("materials", "remove", "own"))
        preview = ["preview", "sample", "--height", "4", "--spacing", "0.5", "--set",
                   "models[0].placement.up=UP_AXIS_Z", "--out", "look"]
        self.assertRegex(self.typed(*preview, "--glass-index", "1.52"), r"verdict +READY")
        self.refused("invalid_value", *preview, "--glass-index", "1.5", "--glass", "K9")

    def test_3_a_material_test_that_no_machine_makes_is_refused_at_once(self):
        grid = ["test-grid", "--out", "grid"]
        for code, words, says in (
                ("not_found", ["--glass", "K99"], "K99"),
                ("invalid_value", ["--energies", "500"], "pulse_energy_mj"),
                ("invalid_value", ["--spacings", "-1"], "distance_mm"),
                ("outside_block", ["--block", "10", "10", "10"], "--patch")):
            with self.subTest(words=words):
                self.assertIn(says, self.refused(code, *grid, *words))
                self.assertFalse((self.folder / "grid/test_grid.textproto").exists())
        made = self.typed(*grid, "--glass", "K9", "--energies", "10", "20", "--spacings", "0.2",
                          "0.3")
        self.assertIn("intaglio preview grid/test_grid.textproto", made)
        shown = self.answered("preview", "grid/test_grid.textproto", "--out", "look")
        self.assertEqual(shown["verdict"], "ready", shown)

    def test_4_what_the_environment_says_is_named_by_its_variable(self):
        def refused(name, value):
            os.environ[name] = value
            self.addCleanup(os.environ.pop, name, None)
            sentence = self.typed("list", exit_code=2)
            del os.environ[name]
            return sentence
        self.assertIn("INTAGLIO_DOMAIN: 'abc'", refused("INTAGLIO_DOMAIN", "abc"))
        self.assertIn("intaglio security new", refused("INTAGLIO_SECURITY", "/nowhere"))
        self.assertIn("--security", refused("INTAGLIO_INTERFACE", "eth0"))
        self.assertIn("--domain: '999'", self.typed("list", "--domain", "999", exit_code=2))


class AtAMachine(InAShop):
    domain = "56"
    up_words = ("--machine", "shop-1.textproto", "--console")

    @classmethod
    def prepare(cls):
        super().prepare()
        subprocess.run([options.intaglio, "machine", "new", "els-03", "--no-questions", "--name",
                        "shop-1", "--out", "shop-1.textproto"], cwd=cls.folder, check=True,
                       capture_output=True)

    def teach(self, *words, exit_code=0):
        return self.typed("teach", *words, exit_code=exit_code)

    def test_1_teaching(self):
        self.assertIn("x 5.0000 mm, y 0.0000 mm", self.teach("jog", "x", "5", "--speed", "50"))
        self.assertIn("x 10.0000 mm, y 10.0000 mm", self.teach("move", "10", "10", "10", "--speed", "50"))
        self.assertIn("version 1: zero of channel 1, lens f43",
                      self.teach("zero", "--lens", "f43", "--height", "30"))
        self.assertIn("f43, f70", self.teach("zero", "--lens", "f99", exit_code=4))
        span = ["limits", "--min", "0", "0", "0", "--max", "100", "100", "50"]
        self.assertIn("version 2: soft limits", self.teach(*span))
        self.assertIn("0 to 100", self.teach("jog", "x", "200", exit_code=4))
        exchanged = self.teach("limits", "--min", "50", "0", "0", "--max", "10", "100", "50",
                               exit_code=4)
        self.assertIn("exchange them", exchanged)
        self.assertIn("version 3: no soft limits", self.teach("limits", "--forget"))
        self.assertIn("version 4: sample position", self.teach("sample"))
        self.assertIn("undo of 4: sample position", self.teach("undo"))
        self.assertIn("undo of 3: no soft limits", self.teach("undo"))
        axes = self.answered("teach", "status")["axes"]
        self.assertEqual([axis["limit_max"] for axis in axes], [100, 100, 50])
        self.assertEqual(len(self.teach("history").strip().splitlines()), 7)
        self.assertRegex(self.teach("home", "--yes"), r"x -?[0-9.]+ mm, y ")

    def test_2_lamp_shutter_and_stop(self):
        self.assertIn("the lamp is on", self.teach("lamp", "--for", "0.5"))
        self.assertIn("channel 1 is open", self.teach("shutter", "1", "--for", "0.5"))
        self.assertIn("from 1 to 4", self.refused("invalid_value", "teach", "shutter", "9"))
        self.assertIn("it is known of shop-1", self.typed("mount"))
        self.assertIn("50 x 50 x 30", self.typed("mount", "--machine", "shop-1.textproto"))
        self.assertIn("shop-1: stopped", self.typed("stop"))
        self.assertIn("intaglio stop --reset", self.refused("refused", "teach", "jog", "x", "1",
                                                            exit_code=4))
        self.assertIn("shop-1: reset", self.typed("stop", "shop-1", "--reset"))

    def http(self, path, body=None, key=None):
        """Status and answer, which is JSON whatever becomes of the request."""
        address = (self.folder / "shop/console.address").read_text()
        port, own = re.search(r":(\d+)/\?key=(\w+)", address).groups()
        request = urllib.request.Request(
            f"http://127.0.0.1:{port}/api/v1/{path}", data=body,
            headers={"Authorization": f"Bearer {own if key is None else key}"})
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return answer.status, json.load(answer)
        except urllib.error.HTTPError as error:
            return error.code, json.loads(error.read())

    def test_3_other_programs(self):
        eventually(lambda: (self.folder / "shop/console.address").is_file())
        self.assertEqual(self.http("jobs"), (200, {"jobs": [], "queues": []}))
        for status, code, words in (
                (401, "not_logged_in", ["jobs", None, "nonsense"]),
                (404, "not_found", ["nothing"]),
                (404, "not_found", ["jobs/99"]),
                (404, "not_found", ["jobs/99/pause", b""]),
                (400, "invalid_value", ["jobs/1/speed", b"nonsense"]),
                (400, "invalid_value", ["submissions/a%20b/files/x"]),
                (422, "missing", ["submissions/order-1", b'name: "x"'])):
            with self.subTest(words=words):
                answered, answer = self.http(*words)
                self.assertEqual((answered, answer["code"]), (status, code), answer)
                self.assertTrue(answer["message"])
        sent, _ = self.http("submissions/order-2/files/sample.obj",
                            (self.folder / "sample.obj").read_bytes())
        self.assertEqual(sent, 200)
        knot = (self.folder / "knot.textproto").read_bytes()
        first, again = (self.http("submissions/order-2", knot) for _ in range(2))
        self.assertEqual((first[0], again[0]), (200, 200), first)
        self.assertEqual(first[1]["job"], again[1]["job"])
        self.assertEqual(self.http(f"jobs/{first[1]['job']}/cancel", b"")[1]["code"], "taken")


class Identities(AtATerminal):
    """A shop whose programs need one, on this computer."""

    def test_what_each_role_may_not_do_is_said(self):
        self.typed("security", "new", "keys", "--cell", "els-03", "--domain", "58")
        self.assertIn("not empty", self.refused("refused", "security", "new", "keys", "--cell",
                                                "els-03"))
        self.assertIn("give --domain 58", self.refused(
            "invalid_value", "security", "check", "keys/observer", "--domain", "40"))
        shop = ["--domain", "58", "--tag", f"roles-{os.getpid()}"]
        up = Terminal([options.intaglio, "up", "--folder", "shop", "--warm-up", "0",
                       "--security", "keys", *shop], cwd=self.folder)
        self.addCleanup(up.close)
        eventually(lambda: "the shop is open" in up.text)
        observer = [*shop, "--security", "keys/observer"]
        self.assertEqual(self.answered("list", *observer)["jobs"], [])
        for words, exit_code, who in ((["submit", "sample"], 2, "operator or a submitter"),
                                      (["stop"], 4, "operator or a submitter"),
                                      (["teach", "jog", "x", "1"], 2, "operator")):
            sentence = self.refused("refused", *words, *observer, exit_code=exit_code)
            self.assertIn("the role observer may not", sentence)
            self.assertIn(who, sentence)
        submitter = [*shop, "--security", "keys/submitter"]
        self.assertTrue(self.answered("submit", "sample", *submitter)["taken"])
        self.assertIn("the role submitter may not command jobs", self.refused(
            "refused", "arm", "1", *submitter, exit_code=4))
        self.assertIn("--security", self.refused("timed_out", "list", *shop))
        up.interrupt()
        self.assertEqual(up.wait(), 0, up.text)


if __name__ == "__main__":
    main(__doc__)
