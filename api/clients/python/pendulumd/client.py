"""Planar pendulum trees, computed by a pendulumd server, as NumPy arrays.

    from pendulumd import Pendulum
    pendulum = Pendulum(length=[1, 1], mass=[1, 1], parent=[0, 1])
    motion = pendulum.run("0:5:0.01", theta=[2, 2.5])
    print(motion.phi[-1], motion.stats["horizon"])

Leaves to others: which fields there are and what they mean (the server's /docs): a field that this module does not know goes
to the server as it is. Invariant: an answer that was cut off is never returned as if it were whole.
"""
import asyncio
import contextlib
import contextvars
import email.utils
import functools
import http.client
import io
import json
import os
import random
import re
import shutil
import stat
import sys
import tempfile
import threading
import time
import urllib.parse
import uuid
import warnings

try:
    import fcntl
except ImportError:  # Windows has no flock
    fcntl = None

from .arrays import JSON, NPZ, OCTETS, Result, bytes_of, from_octets, result_of, width_of

__all__ = ["Client", "Job", "NoServer", "Pendulum", "Problem", "Result"]
SUFFIXES = {".npz": NPZ, ".parquet": "application/vnd.apache.parquet", ".h5": "application/x-hdf5", ".mat": "application/x-matlab-data", ".csv": "text/csv", ".json": JSON, ".png": "image/png",
            ".ndjson": "application/x-ndjson", ".bin": OCTETS}
ENDED = ("successful", "failed", "dismissed")
STATE = ("phi", "phid", "theta", "thetad", "unit", "mode", "amplitude")
BROKEN = (OSError, http.client.HTTPException)
WHERE = "set its address by PENDULUM_URL or Client(url)"
_task = contextvars.ContextVar("task", default=None)  # of the thread that works for a coroutine
_met = set()  # servers that have answered this process: one that has gone may come again, one that was never there is a wrong address


class NoServer(ConnectionError):
    """Nobody answers at the address, nor has in this process."""


class Problem(Exception):
    """A refusal of the server: `status`, `detail`, and `errors`, a list of {"pointer", "detail"}."""

    def __init__(self, status, problem):
        self.status, self.problem = status, problem
        self.detail, self.errors = problem.get("detail", ""), problem.get("errors", [])
        super().__init__("\n".join([f"{status} {self.detail}", *(f"  {e.get('pointer')} {e.get('detail')}" for e in self.errors)]))


def _times(times):
    """"0:5:0.01" is start, stop, step, and "0:5/501" start, stop, count; arrays and dicts are themselves."""
    if not isinstance(times, str):
        return times
    found = re.fullmatch(r"([^:]+):([^:/]+)([:/])([^:/]+)", times)
    if not found:
        raise ValueError(f"{times!r} is neither start:stop:step nor start:stop/count")
    last = {"step": float(found[4])} if found[3] == ":" else {"count": int(found[4])}
    return {"start": float(found[1]), "stop": float(found[2])} | last


def _measured(csv, fields):
    """The fields of a request with tables from files, in UTF-8, UTF-16 or Latin 1, as `data.csv` or a run each."""
    def text(path):
        with open(path, "rb") as file:
            raw = file.read()
        for encoding in ("utf-16",) if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig", "latin-1"):
            with contextlib.suppress(UnicodeDecodeError):
                return raw.decode(encoding)
    if csv is None:
        return fields
    data = fields.get("data") or {}
    if isinstance(csv, (list, tuple)):
        runs = data.get("runs") or [{}] * len(csv)
        if len(runs) != len(csv):
            raise ValueError(f"{len(csv)} files for {len(runs)} runs")
        data = data | {"runs": [run | {"csv": text(path)} for run, path in zip(runs, csv)]}
    else:
        data = data | {"csv": text(csv)}
    return fields | {"data": data}


def _plain(value):
    """What json cannot write: arrays and their numbers, ranges, pendulums. A set has no order: it is no list of numbers."""
    if isinstance(value, (set, frozenset, complex)):
        raise TypeError(f"a {type(value).__name__} cannot be sent: {value!r}")
    return value.tolist() if hasattr(value, "tolist") else value.fields if isinstance(value, Pendulum) else list(value)


def _body(request):
    try:
        return json.dumps(request, default=_plain, allow_nan=False).encode()
    except ValueError as error:
        raise ValueError("numbers of a request have to be finite") from error


def _accept(path):
    """The form that a file's name ends with."""
    ending = os.path.splitext(path)[1]
    if ending not in SUFFIXES:
        raise ValueError(f"{os.fspath(path)!r} must end with one of {' '.join(SUFFIXES)}")
    return SUFFIXES[ending]


def _seconds(text):
    """Those of a Retry-After, which may be a date; 0 where it cannot be read."""
    try:
        return float(text)
    except (TypeError, ValueError):
        date = email.utils.parsedate_tz(text or "")
        return email.utils.mktime_tz(date) - time.time() if date else 0


def _sleep(seconds):
    task = _task.get()
    if task is None:
        time.sleep(seconds)
    elif task.wait(seconds):
        raise asyncio.CancelledError


class Client:
    """A server. Any number of threads may use it.

    url       of the server; PENDULUM_URL, or http://127.0.0.1:8080
    token     the client's own secret, which lists and ends jobs; PENDULUM_TOKEN, or none
    patience  s that refusals for the moment (429, 503) or lines that break may last without anything being received
    timeout   s without a byte after which a line counts as broken; None: any time
    """

    def __init__(self, url=None, token=None, patience=60, timeout=None):
        self.url = urllib.parse.urlsplit(url or os.environ.get("PENDULUM_URL") or "http://127.0.0.1:8080")
        if self.url.scheme not in ("http", "https") or not self.url.hostname:
            raise ValueError(f"{self.url.geturl()!r} is not the URL of a server such as http://127.0.0.1:8080: {WHERE}")
        token = token or os.environ.get("PENDULUM_TOKEN")
        self.headers = {"Content-Type": JSON} | ({"Authorization": f"Bearer {token}"} if token else {})
        self.patience, self.timeout, self._idle = patience, timeout, []

    # the same for asyncio: every method is a coroutine, `stream` and `jobs` are asynchronous iterators
    aio = property(lambda self: _Async(self))

    def _once(self, method, path, body, headers):
        """(connection, response) of an exchange, over a connection that is kept or a new one."""
        connection, task = self._idle.pop() if self._idle else None, _task.get()
        used = connection is not None
        if not used:
            kind = http.client.HTTPSConnection if self.url.scheme == "https" else http.client.HTTPConnection
            connection = kind(self.url.hostname, self.url.port, timeout=self.timeout)
            connection.response_class = _Response
        if task:
            task.connection = connection
            _sleep(0)
        if not used:
            self._connect(connection)
        try:
            connection.request(method, self.url.path.rstrip("/") + path, body, headers)
            return connection, connection.getresponse()
        except BROKEN as error:
            connection.close()
            if used and isinstance(error, (http.client.RemoteDisconnected, ConnectionError)):
                _sleep(0)
                return self._once(method, path, body, headers)  # the server had ended an idle connection
            raise

    def _connect(self, connection):
        """Opens a connection, within 10 s; a server that was never there is told at once."""
        connection.timeout = min(10, self.timeout or 10)
        try:
            connection.connect()
            connection.sock.settimeout(self.timeout)
            connection.timeout = self.timeout
        except BROKEN as error:
            connection.close()
            if self.url.netloc in _met:
                raise
            raise NoServer(f"no server at {self.url.geturl()} ({error}): {WHERE}") from error

    def _open(self, method, path, body=None, headers=(), good=()):
        """As _once, its status below 400 or in `good`; it is repeated while the server refuses for the moment."""
        end, pause = time.monotonic() + self.patience, 0.1
        while True:
            wait, pause = pause * random.uniform(0.5, 1), min(2 * pause, 5)
            try:
                connection, response = self._once(method, path, body, self.headers | dict(headers))
                _met.add(self.url.netloc)
                page = response.headers.get_content_type() == "text/html"
                if (response.status < 400 or response.status in good) and not page:
                    return connection, response
                data = response.read()
                self._idle.append(connection)
            except NoServer:
                raise
            except BROKEN as error:
                refusal = error
            else:
                try:
                    refusal = Problem(response.status, json.loads(data))
                except (ValueError, AttributeError):
                    said = f"{response.reason}: {self.url.geturl()} answers with a web page, so it is not pendulumd: {WHERE}"
                    refusal = Problem(response.status, {"detail": said if page else data.decode(errors="replace")[:500] or response.reason})
                if response.status not in (429, 502, 503, 504):
                    raise refusal
                wait = max(wait, _seconds(response.headers["Retry-After"]))
            if time.monotonic() + wait > end:
                raise refusal
            _sleep(wait)

    def _ask(self, method, path, body=None, **headers):
        """Header fields and bytes of an answer; one that breaks off is asked for once more."""
        for last in (False, True):
            connection, response = self._open(method, path, body, headers)
            try:
                data = response.read()
                self._idle.append(connection)
                return response.headers, data
            except BROKEN:
                connection.close()
                if last:
                    raise

    def call(self, route, request, accept=None):
        """What `POST /v1/ROUTE` answers: a Result, or bytes where `accept` names a media type."""
        want = accept or (JSON if "include" in request else f"{NPZ}, {JSON};q=0.5")
        try:
            headers, data = self._ask("POST", f"/v1/{route}", _body(request), Accept=want)
        except Problem as problem:  # more than the server keeps in memory: plain doubles have no limit
            if accept or "max-answer-bytes" not in str(problem):
                raise
            headers, data = self._ask("POST", f"/v1/{route}", _body(request), Accept=OCTETS)
        return data if accept else result_of(headers, data, bytes_of(request))

    def stream(self, route, request, rows=4096):
        """Yields Results of at most `rows` rows each, while they are computed."""
        return self._blocks("POST", f"/v1/{route}", _body(request), rows, bytes_of(request))

    def save(self, route, request, path):
        """Writes what `POST /v1/ROUTE` answers to a file while it is computed, in the form that its ending names."""
        connection, response = self._open("POST", f"/v1/{route}", _body(request), {"Accept": _accept(path)})
        try:
            with _replacing(path) as sink:
                while piece := response.read(1 << 18):
                    sink.write(piece)
                if response.length:
                    raise http.client.IncompleteRead(b"", response.length)
            _warn(response)
        finally:
            connection.close()
        return path

    def _blocks(self, method, path, body, rows, each=8):
        connection, response = self._open(method, path, body, {"Accept": OCTETS})
        try:
            columns, data = response.headers["X-Columns"], b""
            size = each * width_of(columns) * rows
            while piece := response.read(size - len(data)):
                data += piece
                if len(data) == size:
                    yield from_octets(columns, data, each)
                    data = b""
            if response.length:
                raise http.client.IncompleteRead(data, response.length)
            if data:
                yield from_octets(columns, data, each)
            _warn(response)
        finally:
            connection.close()

    def submit(self, route, request, key=None, title=None):
        """Makes a job of a request. `key`: your own word for it, without blanks; the same again leads to the same job. `title`: what to call it."""
        named = {"Job-Title": urllib.parse.quote(title)} if title else {}
        headers, data = self._ask("POST", f"/v1/{route}", _body(request),
                                  **{"Prefer": "respond-async", "Idempotency-Key": key or uuid.uuid4().hex, **named})
        if "Location" not in headers:
            raise Problem(501, {"detail": "this server stores no jobs"})
        return Job(self, json.loads(data))

    def get(self, path):
        """The JSON at a path: client.get("/v1/presets")."""
        return json.loads(self._ask("GET", path)[1])

    def job(self, id):
        return Job(self, self.get(f"/v1/jobs/{urllib.parse.quote(id)}"))

    def jobs(self, **which):
        """Your jobs, the newest first; takes a token. Those that suit: status="running", operation="ensembles", title="flips",
        since="2026-01-31T09:30:00Z"."""
        path = "/v1/jobs?" + urllib.parse.urlencode({"limit": 100, **which})
        while path:
            page = self.get(path)
            yield from (Job(self, state) for state in page["jobs"])
            path = next((link["href"] for link in page["links"] if link["rel"] == "next"), None)


class Job:
    """A request that is computed while nobody waits. `client.job(job.id)` finds it again."""

    status = property(lambda self: self.state["status"])  # accepted, running, successful, failed or dismissed
    progress = property(lambda self: self.state["progress"])  # percent
    aio = property(lambda self: _Async(self))

    def __init__(self, client, state):
        self.client, self.state, self.id = client, state, state["id"]

    def __repr__(self):
        return f"<job {self.id} {self.status} {self.progress} %>"

    def refresh(self):
        self.state = self.client.get(f"/v1/jobs/{self.id}")
        return self

    def request(self):
        """What was asked of it; a job that failed or was dismissed has it no more."""
        return self.client.get(f"/v1/jobs/{self.id}/request")

    def cancel(self):
        self.state = json.loads(self.client._ask("DELETE", f"/v1/jobs/{self.id}")[1])
        return self

    def wait(self, progress=None):
        """Waits for the end. progress: True for a bar on standard error, or what is called with the job after each look."""
        tell, pause = (_bar if progress is True else progress or (lambda job: None)), 0.01
        while tell(self.refresh()) or self.status not in ENDED:
            _sleep(pause)
            pause = min(1.5 * pause, 1)
        if self.status != "successful":
            raise Problem(409, {"detail": f"the job {self.id} is {self.status}: {self.state.get('message') or 'no reason was given'}"})
        return self

    def result(self, progress=None):
        """Waits, and brings the Result; a download that breaks off goes on where it was."""
        self.wait(progress)
        for accept in (f"{NPZ}, {JSON};q=0.5", OCTETS):
            sink = io.BytesIO()
            try:
                headers = self._fetch(accept, sink, "")
                return result_of(headers, sink.getvalue(), bytes_of(self.request()) if accept == OCTETS else 8)
            except Problem as problem:
                if accept == OCTETS or "max-answer-bytes" not in str(problem):
                    raise

    def save(self, path, accept=None, progress=None):
        """Waits, and writes the results to a file, in the form that its ending names.

        What has arrived lies in PATH.part-ETAG: another `save`, of a later process too, goes on from there.
        """
        accept = accept or _accept(path)
        connection, response = self.wait(progress).client._open("HEAD", f"/v1/jobs/{self.id}/results", None, {"Accept": accept})
        connection.close()
        etag = response.headers["ETag"] or ""
        with _replacing(path, re.sub("[^0-9a-zA-Z]", "", etag)[:32]) as sink:
            self._fetch(accept, sink, etag)
        return path

    def stream(self, rows=4096):
        """Waits, and yields Results of at most `rows` rows each."""
        self.wait()
        yield from self.client._blocks("GET", f"/v1/jobs/{self.id}/results", None, rows, bytes_of(self.request()))

    def _fetch(self, accept, sink, etag):
        """Appends to sink what it lacks of the results of this ETag, "" for none yet; the header fields."""
        end = time.monotonic() + self.client.patience
        while True:
            have = sink.seek(0, os.SEEK_END)
            headers = {"Accept": accept} | ({"Range": f"bytes={have}-", "If-Range": etag} if have and etag else {})
            connection, response = self.client._open("GET", f"/v1/jobs/{self.id}/results", None, headers, (416,))
            try:
                if response.status == 416 and response.headers["Content-Range"] == f"bytes */{have}":
                    return response.headers  # nothing is missing
                if response.status != 206:  # the whole: what is there is nothing, or of another answer
                    sink.truncate(0)
                    sink.seek(0)
                etag = response.headers["ETag"] or ""
                while response.status != 416 and (piece := response.read(1 << 18)):
                    sink.write(piece)
                    end = time.monotonic() + self.client.patience
                if not response.length and response.status != 416:
                    return response.headers
            except BROKEN:
                pass
            finally:
                connection.close()
            if time.monotonic() > end:
                raise ConnectionError(f"the results of job {self.id} do not arrive")
            _sleep(0.1)


class _Response(http.client.HTTPResponse):
    """Keeps the fields behind a stream's last chunk, which http.client drops."""

    trailers = {}

    def _read_and_discard_trailer(self):
        self.trailers = http.client.parse_headers(self.fp)


def _warn(response):
    """Warnings of an answer that has no place for them."""
    for text in (response.headers.get_all("X-Warning") or []) + (response.trailers and response.trailers.get_all("X-Warning") or []):
        warnings.warn(text, stacklevel=3)


@contextlib.contextmanager
def _replacing(path, kept=""):
    """A file that replaces the one at `path` when the block ends without an exception. What is no regular file is written directly.
    kept: a name under which a later run finds what this one has written."""
    path = os.path.realpath(path)
    old = os.stat(path) if os.path.exists(path) else None
    if old and not stat.S_ISREG(old.st_mode):
        with tempfile.TemporaryFile() as sink:
            yield sink
            sink.seek(0)
            with open(path, "wb") as target:
                shutil.copyfileobj(sink, target)
        return
    if old and not (os.access(path, os.W_OK) and old.st_mode & 0o222):
        raise PermissionError(f"{path} is read-only")
    sink = _kept(f"{path}.part-{kept}") if kept else open(f"{path}.part-{uuid.uuid4().hex}", "xb")
    try:
        with sink:
            yield sink
            sink.flush()
            if old:
                os.chmod(sink.name, stat.S_IMODE(old.st_mode))
            os.replace(sink.name, path)
    except BaseException:
        if not kept:
            os.unlink(sink.name)
        raise


def _kept(part):
    """The beginning of a download, for this process alone; BlockingIOError where another one has it."""
    while True:
        sink = open(part, "ab+")
        if not fcntl:
            return sink
        fcntl.flock(sink, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # another process may have renamed the file between open and flock
        if os.path.exists(part) and os.path.samestat(os.fstat(sink.fileno()), os.stat(part)):
            return sink
        sink.close()


def _bar(job):
    """A line on standard error that is written over and over."""
    left = f", {job.state['remaining_seconds']:.0f} s left" if "remaining_seconds" in job.state else ""
    line = f"[{'#' * (job.progress // 4):25}] {job.progress:3} % {job.status}{left}"
    print(f"\r{line:70}", file=sys.stderr, end="\n" if job.status in ENDED else "", flush=True)


class Pendulum:
    """A pendulum tree by any of its forms: (length, mass, parent), (L, m, S) or (arms); more fields go to the server as they are."""

    aio = property(lambda self: _Async(self))

    def __init__(self, client=None, **fields):
        if not isinstance(client, (Client, type(None))):
            raise TypeError(f"{client!r} is not a Client: give fields of a pendulum by name, such as length=[1, 1], or use Pendulum.preset(name)")
        self.client, self.fields = client or Client(), fields

    @classmethod
    def preset(cls, name, client=None):
        """A ready one; its attributes `initial` and `times` are worth watching."""
        found = (client or Client()).get(f"/v1/presets/{urllib.parse.quote(name)}")
        made = cls(client, **found["pendulum"])
        made.initial, made.times = found["initial"], found["times"]
        return made

    def request(self, **fields):
        """The body of a request: phi, phid, theta, thetad, unit, mode and amplitude are its `initial`."""
        initial = {name: fields.pop(name) for name in STATE if name in fields}
        if initial and "initial" in fields:
            raise TypeError(f"a start by initial and by {', '.join(initial)}: give one of the two")
        return {"pendulum": self.fields} | ({"initial": initial} if initial else {}) | fields

    def ask(self, route, *, job=False, save=None, **fields):
        """POST /v1/ROUTE with this pendulum: a Result, with job=True (or a key of your own) a Job, with save="a.npz" that file."""
        # mode and amplitude of an orbit are not its start
        body = {"pendulum": self.fields} | fields if route == "orbits" else self.request(**fields)
        if save:
            return self.client.save(route, body, save)
        if job:
            return self.client.submit(route, body, None if job is True else job)
        return self.client.call(route, body)

    def fits(self, csv=None, **fields):
        """A fit; csv="track.csv" is a table as it was saved, a list of files a run each: `tables` of the answer shows what was read."""
        return self.ask("fits", **_measured(csv, fields))

    def tables(self, csv=None, **fields):
        """What the columns of tables are taken for, before a fit; `data={"columns": [...]}` corrects it, here and there."""
        return self.ask("tables", **_measured(csv, fields))

    def run(self, times, **fields):
        """The motion at `times`: "start:stop:step", "start:stop/count", an array, or a dict of the interface."""
        return self.ask("trajectories", times=_times(times), **fields)

    def stream(self, times, rows=4096, **fields):
        """The same as Results of at most `rows` rows each while they are computed, however many there are."""
        return self.client.stream("trajectories", self.request(times=_times(times), **fields), rows)

    def forces(self, **fields):
        request = self.request(**fields)
        return self.client.call("forces", {"state" if name == "initial" else name: value for name, value in request.items()})

    tree, modes = functools.partialmethod(ask, "trees"), functools.partialmethod(ask, "modes")
    ensemble, lyapunov = functools.partialmethod(ask, "ensembles"), functools.partialmethod(ask, "lyapunov")
    response, controller = functools.partialmethod(ask, "response"), functools.partialmethod(ask, "controllers")
    orbits = functools.partialmethod(ask, "orbits")
    section, equations = functools.partialmethod(ask, "sections"), functools.partialmethod(ask, "equations")


class _Async:
    """A client, a pendulum or a job whose methods are coroutines. One that is cancelled ends its computation."""

    def __init__(self, target):
        self._target = target

    def __getattr__(self, name):
        value = getattr(self._target, name)
        if not callable(value) or (name == "request" and isinstance(self._target, Pendulum)):
            return value
        run = _thread if name not in ("stream", "jobs") else _steps
        return lambda *arguments, **fields: run(value, *arguments, **fields)


async def _thread(function, *arguments, **fields):
    task, context = threading.Event(), contextvars.copy_context()
    task.connection = None
    context.run(_task.set, task)
    work = asyncio.get_running_loop().run_in_executor(None, lambda: context.run(function, *arguments, **fields))
    try:
        found = await asyncio.shield(work)
    except asyncio.CancelledError:
        task.set()
        socket = task.connection and task.connection.sock
        if socket:
            socket.shutdown(2)
        work.add_done_callback(lambda done: done.cancelled() or done.exception())
        raise
    return _Async(found) if isinstance(found, (Job, Pendulum)) else found


async def _steps(function, *arguments, **fields):
    iterator, end = await _thread(function, *arguments, **fields), object()
    while (item := await _thread(next, iterator, end)) is not end:
        yield item
