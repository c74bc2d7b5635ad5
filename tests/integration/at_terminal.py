"""Tests that type commands at a terminal, or have scripts run them, in a folder and a shop
of their own."""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import unittest

from patience import eventually
from terminal import Terminal

SOURCE = pathlib.Path(__file__).resolve().parents[2]
options = argparse.Namespace()


def screens_fit(terminal):
    """What is drawn again and again fits: a line that is longer would stay on the screen."""
    return all(len(state) < terminal.columns for state in terminal.redrawn())


class AtATerminal(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = options.folder / cls.__name__
        shutil.rmtree(cls.folder, ignore_errors=True)
        cls.folder.mkdir(parents=True)
        os.environ["INTAGLIO_MATERIALS_DB"] = str(cls.folder / "materials.db")

    def open(self, *words, columns=80):
        terminal = Terminal([options.intaglio, *words], columns, cwd=self.folder)
        self.addCleanup(terminal.close)
        return terminal

    def typed(self, *words, exit_code=0, columns=80):
        """The command to its end; what stands on the screen then."""
        terminal = self.open(*words, columns=columns)
        ended = terminal.wait()
        self.assertEqual(ended, exit_code, terminal.text)
        self.assertTrue(screens_fit(terminal), terminal.redrawn())
        return "\n".join(terminal.lines)

    def scripted(self, *words, exit_code=0):
        """The command as a script runs it: its standard output, and what people read."""
        done = subprocess.run([options.intaglio, *map(str, words)], cwd=self.folder,
                              capture_output=True, text=True, timeout=240, check=False)
        self.assertEqual(done.returncode, exit_code, done.stdout + done.stderr)
        return done.stdout, done.stderr

    def answered(self, *words, exit_code=0):
        """The JSON that a command writes with --json, which has nothing beside it."""
        return json.loads(self.scripted(*words, "--json", exit_code=exit_code)[0])

    def refused(self, code, *words, exit_code=2):
        """The sentence of a refusal, which has this code."""
        answer = self.answered(*words, exit_code=exit_code)
        self.assertEqual((answer["taken"], answer["code"]), (False, code), answer)
        self.assertTrue(answer["message"])
        return answer["message"]


class InAShop(AtATerminal):
    """With a shop that all commands find by the environment, as docs/cli.md has it."""
    domain = "40"
    up_words = ()

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        environment = {"INTAGLIO_DOMAIN": cls.domain,
                       "INTAGLIO_TAG": f"{cls.__name__}-{os.getpid()}"}
        os.environ.update(environment)
        cls.addClassCleanup(lambda: [os.environ.pop(name) for name in environment])
        cls.prepare()
        cls.up = Terminal([options.intaglio, "up", "--folder", "shop", "--block", "50", "50",
                           "30", "--warm-up", "0", "--speed", "20", *cls.up_words],
                          cwd=cls.folder)
        cls.addClassCleanup(cls.up.close)
        eventually(lambda: "the shop is open" in cls.up.text)

    @classmethod
    def prepare(cls):
        """Files that the shop is opened with; a small job."""
        shutil.copy(SOURCE / "deploy/jobs/sample.obj", cls.folder)
        (cls.folder / "knot.textproto").write_text("""
name: "trefoil knot"
models { file: "sample.obj" placement { fit_height_mm: 4 up: UP_AXIS_Z } }
block { size_mm { x: 50 y: 50 z: 30 } }
glass: "N-BK7"
discretization { min_spacing_mm: 0.5 }
""")


def main(doc):
    parser = argparse.ArgumentParser(description=doc.splitlines()[0])
    parser.add_argument("--intaglio", required=True)
    parser.add_argument("--folder", type=pathlib.Path, required=True)
    given, rest = parser.parse_known_args()
    options.intaglio = os.path.abspath(given.intaglio)
    options.folder = given.folder.resolve()
    unittest.main(argv=[sys.argv[0], *rest])
