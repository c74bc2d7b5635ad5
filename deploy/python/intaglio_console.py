"""A shop by its web console, from a computer that has nothing of Intaglio but this file.

The package python3-intaglio has it; it needs the standard library alone. docs/console.md
explains the requests and docs/openapi.json has their form: a test compares each method, its
fields and the message that it returns with that file. A message is the object of the answer's
JSON, as dicts and lists.

    import intaglio_console

    shop = intaglio_console.Console("https://shop.example:8850", cafile="shop.pem")
    shop.log_in("anna", "correct horse")
    job = shop.submit("order-7", "knot.textproto", ["knot.stl"])["job"]
    for event in shop.follow(job):
        print(event["state"])
    print(shop.report(job))

With the address that a console of this computer printed no log-in is needed:
`Console("http://127.0.0.1:8850/?key=...")`.

Whoever calls `arm` or `resume` by a program is at the machine and has read the block.
"""

import array
import http.cookiejar
import json
import pathlib
import ssl
import sys
import time
import urllib.error
import urllib.parse
import urllib.request
from typing import (Any, Callable, Dict, Iterable, Iterator, List, Optional, Tuple,
                    Union)

Message = Dict[str, Any]
Path = Union[str, pathlib.Path]
Job = Union[int, str]
"""A job by its number or its uid."""
Points = Any
"""A numpy array with a row for each point where numpy is installed, else a list of tuples."""

_PIECE_BYTES = 4 << 20
_END_STATES = ("done", "failed", "cancelled")


class Refused(Exception):
    """The console does not do it. str() is its reason; `status` that of HTTP, `answer` all."""

    def __init__(self, status: int, answer: Message) -> None:
        super().__init__(answer.get("message") or f"HTTP {status}")
        self.status = status
        self.answer = answer
        self.code: str = answer.get("code", "")


class Console:
    """A console by its address, which may have the key. `cafile`: the certificate of one that
    is not of a known authority."""

    def __init__(self, address: str, cafile: Optional[str] = None,
                 timeout_s: float = 150) -> None:
        parts = urllib.parse.urlsplit(address)
        self._origin = f"{parts.scheme}://{parts.netloc}"
        self._key = urllib.parse.parse_qs(parts.query).get("key", [""])[0]
        self._timeout_s = timeout_s
        handlers: List[urllib.request.BaseHandler] = [
            urllib.request.HTTPCookieProcessor(http.cookiejar.CookieJar()),
            urllib.request.ProxyHandler({})]
        if parts.scheme == "https":
            context = ssl.create_default_context(cafile=cafile)
            handlers.append(urllib.request.HTTPSHandler(context=context))
        self._opener = urllib.request.build_opener(*handlers)

    def _open(self, method: str, path: str, body: Optional[bytes] = None, **query: Any) -> Any:
        query = {name: value for name, value in query.items() if value is not None}
        url = self._origin + urllib.parse.quote(path)
        if query:
            url += "?" + urllib.parse.urlencode(query)
        request = urllib.request.Request(url, data=body, method=method)
        request.add_header("Content-Type", "application/octet-stream")
        if self._key:
            request.add_header("Authorization", "Bearer " + self._key)
        try:
            return self._opener.open(request, timeout=self._timeout_s)
        except urllib.error.HTTPError as error:
            text = error.read().decode(errors="replace")
            try:
                answer = json.loads(text)
            except ValueError:
                answer = {"message": text.strip()}
            raise Refused(error.code, answer) from None

    def _bytes(self, path: str, **query: Any) -> bytes:
        with self._open("GET", "/api/v1/" + path, **query) as answer:
            packed: bytes = answer.read()
            return packed

    def _get(self, path: str, **query: Any) -> Any:
        return json.loads(self._bytes(path, **query))

    def _post(self, path: str, **members: Any) -> Any:
        with self._open("POST", "/api/v1/" + path, json.dumps(members).encode()) as answer:
            return json.load(answer)

    def log_in(self, name: str, password: str) -> Message:
        """A session of this person; ConsoleSession."""
        return self._post("login", name=name, password=password)

    def log_out(self) -> Message:
        """Ends the session; ConsoleSession, of nobody."""
        return self._post("logout")

    def session(self) -> Message:
        """Who is logged in, and who is in charge; ConsoleSession."""
        return self._get("session")

    def take_charge(self) -> Message:
        """The commands of everybody else are refused from now on; ConsoleSession."""
        return self._post("charge")

    def stop(self, reason: str = "") -> Message:
        """Stops every machine; StopAnswer, with what confirmed it."""
        return self._post("stop", reason=reason)

    def status(self) -> Message:
        """The shop; ShopStatus."""
        return self._get("status")

    def jobs(self) -> List[Message]:
        """Its jobs: those of JobList, each a JobRecord."""
        return self._get("jobs").get("jobs", [])

    def queues(self) -> List[Message]:
        """How long each machine takes for its open jobs: the QueueTime of JobList."""
        return self._get("jobs").get("queues", [])

    def job(self, job: Job) -> Message:
        """A job by its number or uid; JobRecord."""
        return self._get(f"jobs/{job}")

    def choices(self) -> Message:
        """The glasses and machines that a job may name; JobChoices."""
        return self._get("choices")

    def history(self, **filters: str) -> List[Message]:
        """The jobs that have ended: those of JobHistory, each a JobStatistics. since, until, name, glass, verdict,
        cell choose some."""
        return self._get("history", **filters).get("jobs", [])

    def history_table(self, **filters: str) -> str:
        """The same as CSV, for spreadsheets: a row for each job."""
        return self._bytes("history.csv", **filters).decode()

    def days_table(self, **filters: str) -> str:
        """What each machine has made on each day as CSV: pieces by verdict, and times."""
        return self._bytes("days.csv", **filters).decode()

    def metrics(self) -> str:
        """The figures of machines and jobs: the text for Prometheus."""
        with self._open("GET", "/metrics") as answer:
            return answer.read().decode()

    def reset(self, machine: str, presses: List[str]) -> Message:
        """Releases the emergency stops that a person has read in stops_held of the machine, and no
        other; CommandAnswer."""
        return self._post(f"machines/{machine}/reset", presses=presses)

    def teaching(self, machine: str) -> Message:
        """What there is to teach at a machine, and what was taught last; MachineTeaching."""
        return self._get(f"machines/{machine}/teaching")

    def _test_job(self, machine: str, kind: str, submission: str,
                  block_mm: Tuple[float, float, float], members: Message) -> Message:
        x, y, z = block_mm
        return self._post(f"machines/{machine}/{kind}", id=submission, block_x_mm=x,
                          block_y_mm=y, block_z_mm=z, **members)

    def submit_pulse(self, machine: str, submission: str, block_mm: Tuple[float, float, float],
                     glass: str = "", lens: str = "", channel: int = 0,
                     energy_mj: float = 0) -> Message:
        """A job of one weak pulse where the focus is; nothing fires before it is armed.
        SubmitAnswer."""
        return self._test_job(machine, "pulse", submission, block_mm, {
            "glass": glass, "lens": lens, "channel": channel, "energy_mj": energy_mj,
            "step_mm": 0, "count": 0, "pitch_mm": 0})

    def submit_focus_series(self, machine: str, submission: str,
                            block_mm: Tuple[float, float, float], glass: str = "",
                            lens: str = "", channel: int = 0, energy_mj: float = 0,
                            step_mm: float = 0, count: int = 0, pitch_mm: float = 0) -> Message:
        """A job of a row of points at growing depth; nothing fires before it is armed.
        SubmitAnswer."""
        return self._test_job(machine, "focus", submission, block_mm, {
            "glass": glass, "lens": lens, "channel": channel, "energy_mj": energy_mj,
            "step_mm": step_mm, "count": count, "pitch_mm": pitch_mm})

    def series_zero_move(self, machine: str, job: Job, first: int) -> Message:
        """How the zero has to move, when `first` is the number of the first visible crack of
        this focus series; nothing moves by it. SeriesZeroMove."""
        return self._get(f"machines/{machine}/zero_move", job=job, first=first)

    def upload(self, submission: str, file: Path,
               progress: Callable[[int, int], None] = lambda sent, size: None) -> Message:
        """Sends a file of a submission, in pieces; goes on where an earlier call ended.
        UploadAnswer. `progress` is called with the bytes sent and all."""
        file = pathlib.Path(file)
        path = f"submissions/{submission}/files/{file.name}"
        size = file.stat().st_size
        sent = 0
        try:
            before = self._get(path)
            if not before["complete"] and before["size_bytes"] == size:
                sent = before["received_bytes"]
        except Refused as refused:
            if refused.status != 404:
                raise
        with open(file, "rb") as source:
            source.seek(sent)
            while True:
                piece = source.read(_PIECE_BYTES if size > _PIECE_BYTES else -1)
                with self._open("POST", "/api/v1/" + path, piece, offset=sent,
                                size=size) as answer:
                    state = json.load(answer)
                sent += len(piece)
                progress(sent, size)
                if state["complete"] or not piece:
                    return state

    def submit(self, submission: str, job_file: Path, files: Iterable[Path] = ()) -> Message:
        """Sends the files, then the job file. SubmitAnswer, whose `job` is the number. The same
        submission again submits nothing twice."""
        for file in files:
            self.upload(submission, file)
        text = pathlib.Path(job_file).read_bytes()
        with self._open("POST", f"/api/v1/submissions/{submission}", text) as answer:
            return json.load(answer)

    def preview(self, submission: str, job_file: Path, files: Iterable[Path] = ()) -> Message:
        """What the job will look like and take, before it is submitted; JobPreview."""
        for file in files:
            self.upload(submission, file)
        text = pathlib.Path(job_file).read_bytes()
        with self._open("POST", f"/api/v1/submissions/{submission}/preview", text) as answer:
            return json.load(answer)

    def preview_picture(self, submission: str) -> bytes:
        """Of the last preview, a PNG."""
        return self._bytes(f"submissions/{submission}/preview")

    def _held(self, command: str, job: Job, block: str, members: Message) -> Message:
        hold = self._post(f"jobs/{job}/hold", block=block)
        time.sleep(hold["hold_s"] + 0.1)
        return self._post(f"jobs/{job}/{command}", token=hold["token"], **members)

    def arm(self, job: Job, block: str, accept_breakage: bool = False) -> Message:
        """Lets a machine fire for this job, with this block in it, as the status names it
        (`mounted`). CommandAnswer."""
        return self._held("arm", job, block, {"accept_breakage": accept_breakage})

    def resume(self, job: Job, block: str, accept_breakage: bool = False, from_point: int = 0,
               fire_uncertain: bool = False) -> Message:
        """Goes on with a job that is paused. CommandAnswer."""
        return self._held("resume", job, block,
                          {"accept_breakage": accept_breakage, "from_point": from_point,
                           "fire_uncertain": fire_uncertain})

    def pause(self, job: Job) -> Message:
        """CommandAnswer."""
        return self._post(f"jobs/{job}/pause")

    def cancel(self, job: Job) -> Message:
        """For good. CommandAnswer."""
        return self._post(f"jobs/{job}/cancel")

    def set_speed(self, job: Job, percent: int) -> Message:
        """1 to 140 percent of the job's limits. CommandAnswer."""
        return self._post(f"jobs/{job}/speed", percent=percent)

    def move(self, job: Job, before: str = "") -> Message:
        """Before the waiting job with this uid; empty: behind all that wait for its machine.
        CommandAnswer."""
        return self._post(f"jobs/{job}/move", before=before)

    def events(self) -> Iterator[Message]:
        """What happens to jobs from now on, JobEvent after JobEvent (docs/cli.md)."""
        with self._open("GET", "/api/v1/events") as lines:
            for line in lines:
                if line.startswith(b"data: "):
                    yield json.loads(line[6:])

    def follow(self, job: Job, period_s: float = 0.5) -> Iterator[Message]:
        """JobRecord after JobRecord of a job, at each change of its state, to its end."""
        state = None
        while state not in _END_STATES:
            record = self.job(job)
            if record["state"] != state:
                state = record["state"]
                yield record
            else:
                time.sleep(period_s)

    def _when_made(self, path: str, wait_s: float) -> bytes:
        end = time.monotonic() + wait_s
        while True:
            try:
                return self._bytes(path)
            except Refused as refused:
                if refused.status != 404 or time.monotonic() > end:
                    raise
            time.sleep(0.5)

    def report(self, job: Job, wait_s: float = 60) -> Message:
        """Its report, which is made some seconds after its end; JobReport."""
        return json.loads(self._when_made(f"jobs/{job}/report", wait_s))

    def picture(self, job: Job, wait_s: float = 60) -> bytes:
        """The customer's picture, a PNG."""
        return self._when_made(f"jobs/{job}/picture", wait_s)

    def views(self, job: Job, wait_s: float = 60) -> bytes:
        """Its views, a PNG."""
        return self._when_made(f"jobs/{job}/views", wait_s)

    def photo(self, job: Job) -> bytes:
        """The photograph of its block that somebody has added, a JPEG or a PNG."""
        return self._bytes(f"photos/{job}")

    def add_photo(self, job: Job, file: Path) -> Message:
        """Adds it, or another in its place: a JPEG or PNG file of 8 MB and 12 million pixels at
        most. CommandAnswer."""
        file = pathlib.Path(file)
        with self._open("POST", f"/api/v1/photos/{job}", file.read_bytes(),
                        name=file.name) as answer:
            return json.load(answer)

    def plan(self, job: Job) -> Points:
        """Its planned points, mm, glass frame, in the order in which they are made: an array of
        three columns where numpy is installed, else a list of tuples."""
        packed = self._bytes(f"jobs/{job}/plan")
        if packed[:8] != b"INTPLAN2":
            raise ValueError("the plan is of another version of the console")
        count = int.from_bytes(packed[8:12], "little")
        block_mm = _little_endian("f", packed[12:24])
        begin = 24 + 4 * 513  # behind the first points of the cells
        shares = _little_endian("H", packed[begin:begin + 8 * count])
        places = _little_endian("I", packed[begin + 8 * count:])
        points: List[Tuple[Any, ...]] = [()] * count
        for i, place in enumerate(places):
            points[place] = tuple(shares[4 * i + axis] / 65535 * block_mm[axis]
                                  for axis in range(3))
        return _as_array(points)

    def made(self, job: Job) -> Points:
        """What was made of them: pairs of the place in the order and the outcome
        (PointOutcome), as they were recorded."""
        pairs: List[Tuple[Any, ...]] = []
        start = 0
        while True:
            packed = self._bytes(f"jobs/{job}/made", **{"from": start})
            following = int.from_bytes(packed[:4], "little")
            for record in _little_endian("I", packed[4:]):
                pairs.append((record & (1 << 29) - 1, record >> 29))
            if following == start:
                return _as_array(pairs)
            start = following

    def ticks(self, job: Job) -> Points:
        """At which ticks they were fired: pairs of the place in the order and the lower 32 bits
        of the tick, as they were recorded. (2**32 - 1, 0) is where the ticks count from another
        power-up of the controller."""
        pairs: List[Tuple[Any, ...]] = []
        start = 0
        while True:
            packed = self._bytes(f"jobs/{job}/ticks", **{"from": start})
            following = int.from_bytes(packed[:4], "little")
            numbers = _little_endian("I", packed[4:])
            pairs.extend(zip(numbers[::2], numbers[1::2]))
            if following == start:
                return _as_array(pairs)
            start = following

    def channels(self, job: Job) -> bytes:
        """In which channels each point is made, by its place in the order: bit 0 to 3, channels
        1 to 4."""
        return self._bytes(f"jobs/{job}/channels")


def _little_endian(code: str, packed: bytes) -> Any:
    values: Any = array.array(code)
    values.frombytes(packed)
    if sys.byteorder == "big":
        values.byteswap()
    return values


def _as_array(rows: List[Tuple[Any, ...]]) -> Points:
    try:
        import numpy
    except ImportError:
        return rows
    return numpy.array(rows)
