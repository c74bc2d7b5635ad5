#!/usr/bin/env python3
"""Fifty small jobs over two machines, one of them bad: 49 good blocks, one clear failure.

Opens a shop with two virtual machines, writes a batch, lets `intaglio batch` make it and
follows its events. It knows nothing of DDS: what it reads are lines of JSON (--events,
docs/cli.md) and the file of --results. Ends with 0 when everything came as it should.

    deploy/examples/two_cells.py --intaglio build/release/bin/intaglio --folder /tmp/cups
"""

import argparse
import collections
import json
import pathlib
import re
import signal
import subprocess
import sys
import time

DEPLOY = pathlib.Path(__file__).resolve().parent.parent


def write_profiles(folder):
    """Two machines as the supplied one, each with a name of its own."""
    text = (DEPLOY / "machines" / "els-03.textproto").read_text()
    text = re.sub(r"warm_up_s: \d+", "warm_up_s: 0.2", text)  # nobody waits for a lamp here
    profiles = []
    for name in ("left", "right"):
        profile = folder / f"{name}.textproto"
        profile.write_text(re.sub(r'^name: ".*"', f'name: "{name}"', text, flags=re.M))
        profiles.append(profile)
    return profiles


def write_batch(folder, count):
    """One job a line; the one in the middle has a model without a triangle."""
    (folder / "knot.textproto").write_text(
        'name: "knot"\n'
        f'models {{ file: "{DEPLOY / "jobs" / "sample.obj"}" placement {{ fit_height_mm: 5 }} }}\n'
        "block { size_mm { x: 30 y: 30 z: 15 } }\n"
        'glass: "N-BK7"\n'
        "discretization { min_spacing_mm: 0.5 }\n"
        "ordering { smooth { } }\n"
        'machine_file: "left.textproto"\n'
    )
    (folder / "empty.stl").write_text("solid nothing\nendsolid nothing\n")
    bad = f"knot-{count // 2}"
    batch = folder / "knots.jsonl"
    with batch.open("w") as lines:
        for i in range(1, count + 1):
            entry = {"id": f"knot-{i}", "job": "knot.textproto"}
            entry["overrides"] = {"models[0].placement.fit_height_mm": 4 + i % 5 * 0.5}
            if entry["id"] == bad:
                entry["overrides"]["models[0].file"] = "empty.stl"
            if i % 10 == 0:
                entry["priority"] = 5
            lines.write(json.dumps(entry) + "\n")
    return batch, bad


class Shop:
    """The services, and one machine for each profile: the first `up` has the queue."""

    def __init__(self, options, profiles):
        self.bus = ["--domain", str(options.domain), "--tag", options.tag]
        self.intaglio = [options.intaglio]
        self.ups = []
        for i, profile in enumerate(profiles):
            without = ["--without", "job-service"] if i > 0 else []
            log = (options.folder / f"up-{profile.stem}.txt").open("w")
            self.ups.append(
                subprocess.Popen(
                    self.intaglio
                    + ["up", "--machine", str(profile), "--folder", str(options.folder / profile.stem)]
                    + ["--materials", str(options.folder / "materials.db"), "--lockstep"]
                    + ["--block", "30", "30", "15"] + without + self.bus,
                    stdout=log, stderr=subprocess.STDOUT,
                )
            )
            self.wait_until_open(self.ups[-1], log.name)

    @staticmethod
    def wait_until_open(up, log, seconds=60):
        for _ in range(seconds * 10):
            if "the shop is open" in pathlib.Path(log).read_text():
                return
            if up.poll() is not None:
                break
            time.sleep(0.1)
        sys.exit(f"the shop does not open: see {log}")

    def close(self):
        for up in reversed(self.ups):
            up.send_signal(signal.SIGINT)
        for up in self.ups:
            up.wait(timeout=30)


# The job has its machine, and is not armed.
MACHINE_IS_FREE = ("discretizing", "ordering", "waiting_for_arm")


def load(shop, event):
    """What a loader does: a fresh block into the machine, then the arm with its identity."""
    block = f"{event['cell']}-block-{event['job']}"
    arm = shop.intaglio + ["arm", str(event["job"]), "--loaded", block] + shop.bus
    subprocess.Popen(arm, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def run_batch(options, shop, batch, profiles):
    """The batch's exit code; what happens is told as it happens. A loader at each machine
    puts the next block in and arms its job."""
    command = shop.intaglio + ["batch", str(batch), "--cells", *map(str, profiles)]
    command += ["--keep-going", "--events", "--pause-limit", "120"]
    command += ["--results", str(options.folder / "results.json")]
    command += ["--materials", str(options.folder / "materials.db")] + shop.bus
    with (options.folder / "batch.txt").open("w") as people:
        running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=people, text=True)
        loaded = set()
        for line in running.stdout:
            event = json.loads(line)
            if event["event"] == "state" and event["state"] in MACHINE_IS_FREE \
                    and not event["armed"] and (event["job"], event["attempt"]) not in loaded:
                loaded.add((event["job"], event["attempt"]))
                load(shop, event)
            if event["event"] in ("ended", "refused", "skipped"):
                print(f"{event['time']}  {event['id']:<8} {event['cell']:<6} {event['state']:<9} "
                      f"{event['verdict']:<8} {event['made']:>5} points  {event['message']}")
        return running.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--intaglio", default="intaglio", help="the program")
    parser.add_argument("--folder", type=pathlib.Path, required=True, help="for everything it makes")
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--domain", type=int, default=46)
    parser.add_argument("--tag", default="two-cells")
    options = parser.parse_args()
    options.folder = options.folder.resolve()
    options.folder.mkdir(parents=True, exist_ok=True)

    profiles = write_profiles(options.folder)
    batch, bad = write_batch(options.folder, options.count)
    shop = Shop(options, profiles)
    began = time.monotonic()
    try:
        exit_code = run_batch(options, shop, batch, profiles)
        seconds = time.monotonic() - began
        subprocess.run(shop.intaglio + ["history", "--folder", str(options.folder / "left"),
                                        "--verdict", "none"], check=False)
    finally:
        shop.close()

    print((options.folder / "batch.txt").read_text().split("\n\n")[-1])
    results = json.loads((options.folder / "results.json").read_text())
    machines = collections.Counter(job["cell"] for job in results["jobs"])
    wrong = [job["id"] for job in results["jobs"] if (job["verdict"] == "good") == (job["id"] == bad)]
    print(f"{results['good']} good, {results['failed']} failed, in {seconds:.1f} s, "
          + ", ".join(f"{count} on {name}" for name, count in sorted(machines.items())))
    as_it_should = exit_code == 4 and not wrong and results["failed"] == 1 and len(machines) == 2
    return 0 if as_it_should else 1


if __name__ == "__main__":
    sys.exit(main())
