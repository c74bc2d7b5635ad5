"""Intaglio from Python: engrave, submit, follow and look back.

Pure standard library; it runs the program `intaglio` and reads the JSON that it writes
(docs/cli.md, docs/schemas). Copy it beside a script, or put its folder into PYTHONPATH.

    import intaglio

    machine = intaglio.Intaglio()
    for event in machine.run("job.textproto", "--lockstep", out="knot"):
        print(event.stage, event.done, event.total)

    shop = intaglio.Intaglio(domain=3, tag="hall")
    accepted = shop.submit("job.textproto", arm=True)
    for event in shop.watch(accepted.job):
        print(event.state, event.message)
    for row in shop.history(folder="shop", verdict="not_good"):
        print(row.job, row.name, row.made, "of", row.planned)

A command that does not end with 0 raises an IntaglioError with its exit code, its message
and the last event: WrongInput, NotGood, MachineFault, Cancelled, StillRuns.
"""

import dataclasses
import json
import os
import pathlib
import signal
import subprocess
import threading


class IntaglioError(Exception):
    """A command did not end with 0. str() is what it printed for people; `code` says why
    for programs ("not_found", docs/cli.md, Codes), or is empty: not known."""

    def __init__(self, message, exit_code, command, event=None, code=""):
        super().__init__(message)
        self.message = message
        self.exit_code = exit_code
        self.command = command
        self.event = event  # the last one, or None
        self.code = code


class WrongInput(IntaglioError):
    """2: options, job file, model, glass, folder, or no shop there."""


class NotGood(IntaglioError):
    """3: engraved, and the verdict is not good; event.verdict and message give the reason."""


class MachineFault(IntaglioError):
    """4: the machine or the job failed, or a command was refused or not answered."""


class Cancelled(IntaglioError):
    """5: by a person."""


class StillRuns(IntaglioError):
    """6: no longer followed; the job itself goes on."""


_ERRORS = {2: WrongInput, 3: NotGood, 4: MachineFault, 5: Cancelled, 6: StillRuns}


def _from_json(kind, values):
    """A dataclass from an object; members that this module does not know yet are left out."""
    known = {}
    for field in dataclasses.fields(kind):
        if field.name not in values:
            continue
        value = values[field.name]
        if "of" in field.metadata:
            value = tuple(_from_json(field.metadata["of"], one) for one in value)
        known[field.name] = value
    return kind(**known)


def _several(kind):
    """A member that is a list of `kind`."""
    return dataclasses.field(default=(), metadata={"of": kind})


@dataclasses.dataclass(frozen=True)
class PieceWarning:
    """What a person should know of a piece: message WarningRecord of proto/warning.proto."""

    code: str = ""
    weight: str = ""
    text: str = ""


@dataclasses.dataclass(frozen=True)
class Stage:
    """How far a stage of a job is: message StageRecord of proto/listing.proto."""

    stage: str = ""
    done: int = 0
    total: int = 0
    elapsed_s: float = 0
    rate: float = 0


@dataclasses.dataclass(frozen=True)
class Event:
    """A line of --events: message JobEvent of proto/shop.proto, docs/schemas/event.schema.json."""

    time: str = ""
    event: str = ""
    id: str = ""
    job: int = 0
    uid: str = ""
    name: str = ""
    cell: str = ""
    state: str = ""
    stage: str = ""
    done: int = 0
    total: int = 0
    rate: float = 0
    elapsed_s: float = 0
    attempt: int = 0
    verdict: str = ""
    planned: int = 0
    made: int = 0
    missed: int = 0
    skipped: int = 0
    uncertain: int = 0
    message: str = ""
    armed: bool = False
    pause_reason: str = ""
    warnings: tuple = _several(PieceWarning)
    result_directory: str = ""
    alarm: str = ""
    makes: str = ""
    awaits_block: bool = False
    block_id: str = ""
    code: str = ""

    @property
    def ended(self):
        return self.event == "ended"


@dataclasses.dataclass(frozen=True)
class Job:
    """A job of a shop: message JobRecord of proto/listing.proto."""

    job: int = 0
    uid: str = ""
    name: str = ""
    cell: str = ""
    state: str = ""
    pause_reason: str = ""
    armed: bool = False
    disarm_reason: str = ""
    attempt: int = 0
    stages: tuple = _several(Stage)
    estimated_s: float = 0
    rate_hz: float = 0
    speed_percent: int = 100
    message: str = ""
    result_directory: str = ""
    warnings: tuple = _several(PieceWarning)
    breakage_accepted_by: str = ""
    verdict: str = ""
    planned: int = 0
    made: int = 0
    missed: int = 0
    skipped: int = 0
    uncertain: int = 0
    to_come: int = 0
    armed_count: int = 0
    queue_place: int = 0
    makes: str = ""
    alarm: str = ""


@dataclasses.dataclass(frozen=True)
class Statistics:
    """What became of a job: message JobStatistics of proto/shop.proto."""

    job: int = 0
    uid: str = ""
    name: str = ""
    cell: str = ""
    material: str = ""
    state: str = ""
    verdict: str = ""
    planned: int = 0
    made: int = 0
    missed: int = 0
    skipped: int = 0
    uncertain: int = 0
    progress_ratio: float = 0
    submitted_utc: str = ""
    started_utc: str = ""
    engraving_utc: str = ""
    expected_end_utc: str = ""
    ended_utc: str = ""
    duration_s: float = 0
    estimated_s: float = 0
    machining_s: float = 0
    attempt: int = 0
    priority: int = 0
    message: str = ""
    result_directory: str = ""
    report: str = ""
    recording: str = ""
    warnings: tuple = _several(PieceWarning)
    breakage_accepted_by: str = ""
    first_estimated_s: float = 0
    undisturbed_s: float = 0
    first_estimate_ratio: float = 0
    estimate_ratio: float = 0


class Events:
    """The events of a command, as they happen: iterate over them.

    At the end of the command the iteration ends, or raises the error of its exit code.
    Leaving early interrupts the command, as Ctrl-C: `run` cancels its job, the job of a
    shop goes on. As a context manager it is left by the end of the block; close() does
    the same.
    """

    def __init__(self, command):
        self.command = command
        self.last = None
        self._text = []
        self._process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            text=True, encoding="utf-8", errors="replace",
        )
        self._reader = threading.Thread(target=self._read_text, daemon=True)
        self._reader.start()

    def __iter__(self):
        return self

    def __next__(self):
        line = "" if self._process.stdout.closed else self._process.stdout.readline()
        if not line:
            if not self._process.stdout.closed:
                self._finish()
            raise StopIteration
        self.last = _from_json(Event, json.loads(line))
        return self.last

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def interrupt(self):
        """As Ctrl-C; the iteration goes on to the command's own end."""
        if self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)

    def close(self, timeout_s=30):
        """Interrupts the command and waits for its end; raises nothing."""
        if self._process.stdout.closed:
            return
        self.interrupt()
        # What it still writes is read: a command that cannot write would end at once.
        rest = threading.Thread(target=self._process.stdout.read, daemon=True)
        rest.start()
        try:
            self._process.wait(timeout=timeout_s)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        rest.join()
        self._reader.join()
        self._process.stdout.close()
        self._process.stderr.close()

    @property
    def text(self):
        """What the command printed for people so far."""
        return "".join(self._text)

    def _read_text(self):
        for line in self._process.stderr:
            self._text.append(line)

    def _finish(self):
        exit_code = self._process.wait()
        self._reader.join()
        self._process.stdout.close()
        self._process.stderr.close()
        _raise_unless_good(exit_code, self.text, self.command, self.last)


def _raise_unless_good(exit_code, text, command, event=None):
    if exit_code == 0:
        return
    # Progress bars are redrawn; the last lines are the reason.
    lines = [line.strip() for line in text.replace("\r", "\n").splitlines() if line.strip()]
    reasons = [line for line in lines if line.startswith("intaglio")] or lines[-1:]
    message = "\n".join(reasons) or (event.message if event else "")
    kind = _ERRORS.get(exit_code, IntaglioError)
    raise kind(message or f"ended with {exit_code}", exit_code, command, event,
               event.code if event else "")


class Intaglio:
    """The command intaglio, and the shop that it talks to.

    program: its path. domain, interface, tag, security: where the shop is, as the options
    of these names. job: path of a job file, or None when options alone make the job; further
    options are given as texts, "--height", "40".
    """

    def __init__(self, program="intaglio", domain=None, interface=None, tag=None, security=None):
        self.program = str(program)
        self._bus = []
        for option, value in (("--domain", domain), ("--interface", interface),
                              ("--tag", tag), ("--security", security)):
            if value is not None:
                self._bus += [option, str(value)]

    def run(self, job=None, *options, out=None):
        """Engraves one job in the virtual engraver: its Events. `out`: folder of the proof."""
        folder = [] if out is None else ["--out", os.fspath(out)]
        return Events(self._command("run", job, *options, *folder, "--events"))

    @staticmethod
    def report(out):
        """report.json in the folder of a run, as a dict (docs/schemas/report.schema.json)."""
        return json.loads((pathlib.Path(out) / "report.json").read_text(encoding="utf-8"))

    def submit(self, job=None, *options, arm=False):
        """Gives a job to the shop; the event of its acceptance, with its number. `arm`: you
        are at the machine."""
        armed = ["--arm"] if arm else []
        with Events(self._command("submit", job, *options, *armed, "--events")) as events:
            accepted = [event for event in events if event.event == "submitted"]
        return accepted[0]

    def watch(self, job):
        """Follows a job of the shop, by number or uid: its Events, to its end."""
        return Events(self._command("watch", job, "--events"))

    def jobs(self):
        """The jobs that the shop lists: a list of Job."""
        return [_from_json(Job, job) for job in self._json("list", "--json")["jobs"]]

    def job(self, job):
        """One job of the shop, by number or uid: a Job."""
        return _from_json(Job, self._json("show", job, "--json"))

    def history(self, folder=None, **filters):
        """Jobs that have ended, the oldest first: a list of Statistics. The filters are the
        options of `intaglio history`: since, until, name, glass, verdict, cell, job."""
        words = [] if folder is None else ["--folder", os.fspath(folder)]
        for name, value in filters.items():
            words += ["--" + name, str(value)]
        rows = self._json("history", *words, "--json", on_bus=False)["jobs"]
        return [_from_json(Statistics, row) for row in rows]

    def _command(self, name, job, *options, on_bus=True):
        words = [self.program, name] + ([] if job is None else [str(job)])
        return words + [str(option) for option in options] + (self._bus if on_bus else [])

    def _json(self, name, *options, on_bus=True):
        command = self._command(name, None, *options, on_bus=on_bus)
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              encoding="utf-8", errors="replace", check=False)
        answer = json.loads(done.stdout) if done.stdout else {}
        if done.returncode != 0 and "taken" in answer:
            kind = _ERRORS.get(done.returncode, IntaglioError)
            raise kind(answer["message"], done.returncode, command, code=answer["code"])
        _raise_unless_good(done.returncode, done.stderr, command)
        return answer
