#!/usr/bin/env python3
"""A hundred damaged variants of each example, given to preview, run and contour: each ends,
soon, in what it made or in a sentence with the file's name, and never in a signal, an
internal error or silence.

    damaged_files_test.py --intaglio build/release/bin/intaglio --folder /tmp/damaged

The variants are the same in every run; INTAGLIO_DAMAGED_PREVIEWS=100 gives all of them
to preview, too, which takes some minutes. `run` gets those that preview refuses, most of which
end before any process of a machine starts; of those that preview makes it would be the run of
a good file, which other tests make.
"""

import argparse
import concurrent.futures
import os
import pathlib
import random
import resource
import shutil
import subprocess
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]
VARIANTS = 100
# Preview and run take ten times as long as contour, and get the first of these.
PREVIEWS = int(os.environ.get("INTAGLIO_DAMAGED_PREVIEWS", "12"))
PROCESSOR_S = 20  # of one command; a hang ends by a signal
MAX_SENTENCE = 1500
options = argparse.Namespace()

# A spacing so coarse that a preview is a matter of a tenth of a second.
COARSE = ["--spacing", "2", "--size", "12"]
JOBS = ["sample", "two_knots", "four_blocks", "methods", "badge"]
MODELS = ["deploy/jobs/sample.obj", "deploy/jobs/badge.svg", "tests/data/kinds/item_path.3mf",
          "tests/data/kinds/skin.glb", "tests/data/kinds/line_feed.ply",
          "tests/data/kinds/unit.dae", "tests/data/kinds/cr.stl",
          "tests/data/kinds/turned.png", "tests/data/kinds/comma.xyz"]
PLATES = ["deploy/jobs/badge.svg", "tests/data/kinds/block_layer.dxf",
          "tests/data/kinds/arcs.plt", "tests/data/kinds/encoded.plt",
          "tests/data/drawings/plate.nci",
          "tests/data/boards/region_pinched.gbr",
          "tests/data/boards/macro_line_of_no_length.gbr",
          "tests/data/boards/pattern_repeat.drl", "tests/data/contours/project_two_pads.xml"]


def damaged(whole, chance):
    """The bytes with one to four damages of the kinds that disks, programs and people do."""
    data = bytearray(whole)
    for _ in range(chance.choice([1, 1, 2, 4])):
        if not data:
            break
        at = chance.randrange(len(data))
        end = min(len(data), at + chance.randrange(1, 80))
        kind = chance.randrange(9)
        if kind == 0:
            del data[at:]
        elif kind == 1:
            data[at] = chance.randrange(256)
        elif kind == 2:
            del data[at:end]
        elif kind == 3:
            data[at:at] = data[at:end] * chance.randrange(1, 30)
        elif kind == 4:
            data[at:end] = bytes(end - at)
        elif kind == 5:  # a number that is another one
            digits = [i for i in range(len(data)) if 48 <= data[i] <= 57]
            if digits:
                i = chance.choice(digits)
                data[i:i + 1] = chance.choice(
                    [b"9", b"0", b"-1", b"1e9", b"1e308", b"nan", b"99999999999", b"1,5", b""])
        elif kind == 6:  # lines that change places
            lines = bytes(data).split(b"\n")
            i, j = chance.randrange(len(lines)), chance.randrange(len(lines))
            lines[i], lines[j] = lines[j], lines[i]
            data = bytearray(b"\n".join(lines))
        elif kind == 7:
            lines = bytes(data).split(b"\n")
            lines[chance.randrange(len(lines))] *= chance.randrange(2, 50)
            data = bytearray(b"\n".join(lines))
        else:
            data[at:at] = bytes(chance.randrange(256) for _ in range(20))
    return bytes(data)


def limits():
    resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_S, PROCESSOR_S))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run(arguments, folder):
    done = subprocess.run([options.intaglio, *arguments], cwd=folder, preexec_fn=limits,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, timeout=600)
    return done.returncode, done.stdout.decode(errors="replace")


def fault(code, output, good_codes):
    """What is wrong with the end of a command; empty: nothing."""
    if code in good_codes:
        return "" if output.strip() else "made something in silence"
    if code not in (2, 4):  # 4: a run whose job failed, with the reason
        return f"ended with {code}"
    sentences = [line for line in output.splitlines() if line.startswith("intaglio: ")]
    if not sentences:
        return "was refused without a sentence"
    if len(sentences[0]) > MAX_SENTENCE:
        return f"was refused with {len(sentences[0])} bytes"
    return ""


class DamagedFiles(unittest.TestCase):
    maxDiff = None

    def folder_of(self, name):
        folder = pathlib.Path(options.folder) / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        return folder

    def check(self, example, beside, commands, count):
        """`commands(file)`: lists of arguments with their good exit codes, in order; a
        later one is given what the first one refused."""
        whole = example.read_bytes()
        base = self.folder_of(example.name.replace(".", "_") + "_" + commands.__name__)

        def one(number):
            chance = random.Random(f"{example.name} {number}")
            folder = base / str(number)
            folder.mkdir()
            for other in beside:
                shutil.copy(other, folder)
            file = folder / example.name
            file.write_bytes(damaged(whole, chance))
            for arguments, good_codes in commands(file):
                code, output = run(arguments, folder)
                wrong = fault(code, output, good_codes)
                if wrong:
                    return f"{file}: {arguments[0]} {wrong}: {output[-600:]}"
                if code in good_codes:
                    break
            shutil.rmtree(folder)
            return ""

        with concurrent.futures.ThreadPoolExecutor(2) as two:
            wrong = [text for text in two.map(one, range(count)) if text]
        self.assertEqual(wrong, [], f"{len(wrong)} of {count}")

    def test_jobs(self):
        def preview_and_run(file):
            out = ["--out", str(file.parent / "out"), "--spacing", "2"]
            return [(["preview", file.name, *out], (0, 3)),
                    (["run", file.name, "--lockstep", "--no-record", *out], (0,))]

        jobs = SOURCE / "deploy/jobs"
        beside = [jobs / "sample.obj", jobs / "badge.svg", jobs / "names.csv"]
        for name in JOBS:
            with self.subTest(job=name):
                self.check(jobs / f"{name}.textproto", beside, preview_and_run,
                           PREVIEWS)

    def test_models(self):
        def preview_and_run(file):
            out = ["--out", str(file.parent / "out"), *COARSE]
            return [(["preview", file.name, *out], (0, 3)),
                    (["run", file.name, "--lockstep", "--no-record", *out], (0,))]

        for model in MODELS:
            with self.subTest(model=model):
                self.check(SOURCE / model, [], preview_and_run, PREVIEWS)

    def test_plates(self):
        def contour(file):
            make = "isolation" if file.suffix in (".gbr", ".drl", ".xml") else "curves"
            return [(["contour", file.name, "--make", make, "--template", "linuxcnc",
                      "--out", "x.ngc"], (0,))]

        for plate in PLATES:
            with self.subTest(plate=plate):
                self.check(SOURCE / plate, [], contour, VARIANTS)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--intaglio", required=True)
    parser.add_argument("--folder", required=True)
    known, rest = parser.parse_known_args()
    options.intaglio = str(pathlib.Path(known.intaglio).resolve())
    options.folder = known.folder
    unittest.main(argv=["damaged_files_test.py", *rest], verbosity=2)
