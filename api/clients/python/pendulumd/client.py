"""Connections to a pendulumd server: requests, repeated if refused temporarily, streams, jobs and files.

Leaves to others: the fields of a request (pendulum.py), arrays (arrays.py). Invariant: an answer that was cut off is never
returned as if it were whole.
"""
from __future__ import annotations

import asyncio
import contextlib
import contextvars
import email.utils
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
import time
import urllib.parse
import uuid
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, BinaryIO, Optional, Union

try:
    import fcntl
except ImportError:  # Windows has no flock
    fcntl = None  # type: ignore[assignment]

from .arrays import JSON, NPZ, OCTETS, Result, bytes_of, from_octets, result_of, width_of

SUFFIXES = {".npz": NPZ, ".parquet": "application/vnd.apache.parquet", ".h5": "application/x-hdf5", ".mat": "application/x-matlab-data", ".csv": "text/csv", ".json": JSON, ".png": "image/png",
            ".ndjson": "application/x-ndjson", ".bin": OCTETS}
ENDED = ("successful", "failed", "dismissed")
BROKEN = (OSError, http.client.HTTPException)
WHERE = "set its address by PENDULUM_URL or Client(url)"
Body = Mapping[str, Any]
Path = Union[str, "os.PathLike[str]"]
Progress = Union[bool, Callable[["Job"], Any], None]
_task: contextvars.ContextVar[Any] = contextvars.ContextVar("task", default=None)  # set in a thread that runs for a coroutine
_met: set[str] = set()  # servers that have answered this process: only these are waited for when they do not answer
# Answers with arrays of many rows, which NPZ contains completely. Other answers are small, and have parts that only JSON has.
ROWS = ("trajectories", "ensembles", "lyapunov", "sections")


class NoServer(ConnectionError):
    """No server answers at the address, and none has answered there before."""


class Problem(Exception):
    """The server refused a request: `status`, `detail`, and `errors`, a list of {"pointer", "detail"}."""

    def __init__(self, status: int, problem: Mapping[str, Any]) -> None:
        self.status, self.problem = status, problem
        self.detail, self.errors = problem.get("detail", ""), problem.get("errors", [])
        super().__init__("\n".join([f"{status} {self.detail}", *(f"  {e.get('pointer')} {e.get('detail')}" for e in self.errors)]))


def _plain(value: Any) -> Any:
    """Replaces arrays, their numbers, ranges and pendulums for json. A set has no order, so it is refused."""
    if isinstance(value, (set, frozenset, complex)):
        raise TypeError(f"a {type(value).__name__} cannot be sent: {value!r}")
    if hasattr(value, "tolist"):
        return value.tolist()
    return value.fields if hasattr(value, "fields") else list(value)


def body_of(request: Body) -> bytes:
    try:
        return json.dumps(request, default=_plain, allow_nan=False).encode()
    except ValueError as error:
        raise ValueError("numbers of a request have to be finite") from error


def accept_of(path: Path) -> str:
    """Returns the media type for the suffix of a file's name."""
    suffix = os.path.splitext(path)[1].lower()
    if suffix not in SUFFIXES:
        raise ValueError(f"{os.fspath(path)!r} must end with one of {' '.join(SUFFIXES)}")
    return SUFFIXES[suffix]


def _seconds(text: Optional[str]) -> float:
    """Returns the seconds of a Retry-After field, which may be a date; 0 if it is invalid."""
    try:
        return float(text or "")
    except (TypeError, ValueError):
        date = email.utils.parsedate_tz(text or "")
        return email.utils.mktime_tz(date) - time.time() if date else 0


def _sleep(seconds: float) -> None:
    task = _task.get()
    if task is None:
        time.sleep(seconds)
    elif task.wait(seconds):
        raise asyncio.CancelledError


class Client:
    """A server. Any number of threads may use one client.

    url       address of the server; by default PENDULUM_URL, or http://127.0.0.1:8080
    token     the client's own secret, which lists and cancels jobs; by default PENDULUM_TOKEN, or none
    patience  how long temporary errors (429, 503) and broken connections are retried without progress, s
    timeout   how long a connection may be silent before it counts as broken, s; None: for ever
    """

    def __init__(self, url: Optional[str] = None, token: Optional[str] = None, patience: float = 60, timeout: Optional[float] = None) -> None:
        self.url = urllib.parse.urlsplit(url or os.environ.get("PENDULUM_URL") or "http://127.0.0.1:8080")
        if self.url.scheme not in ("http", "https") or not self.url.hostname:
            raise ValueError(f"{self.url.geturl()!r} is not the URL of a server such as http://127.0.0.1:8080: {WHERE}")
        token = token or os.environ.get("PENDULUM_TOKEN")
        self.headers = {"Content-Type": JSON} | ({"Authorization": f"Bearer {token}"} if token else {})
        self.patience, self.timeout = patience, timeout
        self._idle: list[http.client.HTTPConnection] = []

    def __repr__(self) -> str:
        return f"<Client {self.url.geturl()}{' with a token' if 'Authorization' in self.headers else ''}>"

    @property
    def aio(self) -> Any:
        """This client for asyncio: every method is a coroutine; `stream` and `jobs` are asynchronous iterators."""
        from .aio import Async
        return Async(self)

    def _once(self, method: str, path: str, body: Optional[bytes], headers: Mapping[str, str]) -> tuple[Any, Any]:
        """Sends a request over an idle or a new connection; (connection, response)."""
        connection: Any = self._idle.pop() if self._idle else None
        task = _task.get()
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

    def _connect(self, connection: Any) -> None:
        """Connects within 10 s; raises NoServer at once if no server ever answered there."""
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

    def _open(self, method: str, path: str, body: Optional[bytes] = None, headers: Any = (), good: Iterable[int] = ()) -> tuple[Any, Any]:
        """As _once, with a status below 400 or in `good`; temporary errors are retried."""
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
                refusal: Exception = error
            else:
                try:
                    refusal = Problem(response.status, json.loads(data))
                except (ValueError, AttributeError):
                    said = f"{response.reason}: {self.url.geturl()} answers with a web page, so it is not pendulumd: {WHERE}"
                    refusal = Problem(response.status, {"detail": said if page else data.decode(errors="replace")[:500] or response.reason})
                if response.status == 401 and "Authorization" not in self.headers and "token" in str(refusal):
                    refusal.add_note("set PENDULUM_TOKEN (openssl rand -hex 16) before the job is submitted") if hasattr(refusal, "add_note") else None
                if response.status not in (429, 502, 503, 504):
                    raise refusal
                wait = max(wait, _seconds(response.headers["Retry-After"]))
            if time.monotonic() + wait > end:
                raise refusal
            _sleep(wait)

    def _ask(self, method: str, path: str, body: Optional[bytes] = None, **headers: str) -> tuple[Any, bytes]:
        """Header fields and bytes of an answer. A request whose answer breaks off is repeated once."""
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
        raise AssertionError

    def call(self, route: str, request: Body, accept: Optional[str] = None) -> Any:
        """The answer of `POST /v1/ROUTE`: a Result, or bytes if `accept` names a media type."""
        want = accept or (f"{NPZ}, {JSON};q=0.5" if route in ROWS else JSON)
        try:
            headers, data = self._ask("POST", f"/v1/{route}", body_of(request), Accept=want)
        except Problem as problem:  # more than the server keeps in memory: plain doubles have no limit
            if accept or "max-answer-bytes" not in str(problem):
                raise
            headers, data = self._ask("POST", f"/v1/{route}", body_of(request), Accept=OCTETS)
        return data if accept else result_of(headers, data, bytes_of(request)).of(request)

    def stream(self, route: str, request: Body, rows: int = 4096) -> Iterator[Result]:
        """Yields Results of at most `rows` rows each, while they are computed."""
        return self._blocks("POST", f"/v1/{route}", body_of(request), rows, bytes_of(request))

    def save(self, route: str, request: Body, path: Path) -> Path:
        """Writes the answer of `POST /v1/ROUTE` to a file while it is computed, in the format of the file's suffix."""
        connection, response = self._open("POST", f"/v1/{route}", body_of(request), {"Accept": accept_of(path)})
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

    def _blocks(self, method: str, path: str, body: Optional[bytes], rows: int, each: int = 8) -> Iterator[Result]:
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

    def submit(self, route: str, request: Body, key: Optional[str] = None, title: Optional[str] = None) -> Job:
        """Submits a request as a job. The same `key` (a word without blanks) returns the same job; `title` names it in lists."""
        named = {"Job-Title": urllib.parse.quote(title)} if title else {}
        headers, data = self._ask("POST", f"/v1/{route}", body_of(request),
                                  **{"Prefer": "respond-async", "Idempotency-Key": key or uuid.uuid4().hex, **named})
        if "Location" not in headers:
            raise Problem(501, {"detail": "this server stores no jobs"})
        return Job(self, json.loads(data))

    def get(self, path: str) -> Any:
        """Returns the JSON at a path: client.get("/v1/presets")."""
        return json.loads(self._ask("GET", path)[1])

    def job(self, id: str) -> Job:
        """Returns the job with this id."""
        return Job(self, self.get(f"/v1/jobs/{urllib.parse.quote(id)}"))

    def jobs(self, **which: Any) -> Iterator[Job]:
        """Returns your jobs, the newest first; needs a token. Filters: status="running", operation="ensembles", title="flips",
        since="2026-01-31T09:30:00Z"."""
        path: Optional[str] = "/v1/jobs?" + urllib.parse.urlencode({"limit": 100, **which})
        while path:
            page = self.get(path)
            yield from (Job(self, state) for state in page["jobs"])
            path = next((link["href"] for link in page["links"] if link["rel"] == "next"), None)


class Job:
    """A request that the server computes in the background. `client.job(job.id)` returns it again, also in another process."""

    def __init__(self, client: Client, state: dict[str, Any]) -> None:
        self.client, self.state = client, state
        self.id: str = state["id"]

    @property
    def status(self) -> str:
        """accepted, running, successful, failed or dismissed, at the last `refresh`."""
        return str(self.state["status"])

    @property
    def progress(self) -> int:
        """Percent, at the last `refresh`."""
        return int(self.state["progress"])

    @property
    def aio(self) -> Any:
        from .aio import Async
        return Async(self)

    def __repr__(self) -> str:
        return f"<Job {self.id} {self.status} {self.progress} %>"

    def _repr_html_(self) -> str:
        from .pictures import job_html
        return job_html(self.state)

    def refresh(self) -> Job:
        """Asks the server for the job's state."""
        self.state = self.client.get(f"/v1/jobs/{self.id}")
        return self

    def request(self) -> dict[str, Any]:
        """The request. A job that failed or was cancelled no longer has it."""
        return dict(self.client.get(f"/v1/jobs/{self.id}/request"))

    def manifest(self) -> dict[str, Any]:
        """The Parquet files of the results, where the server stores results in files; `pendulumd.dataset.parts(job)` reads them."""
        return dict(self.wait().client.get(f"/v1/jobs/{self.id}/results?manifest=true"))

    def cancel(self) -> Job:
        self.state = json.loads(self.client._ask("DELETE", f"/v1/jobs/{self.id}")[1])
        return self

    def wait(self, progress: Progress = None) -> Job:
        """Waits for the end. progress: True for a progress bar, or a function that is called with the job at each check."""
        tell, pause = (_bar() if progress is True else progress or (lambda job: None)), 0.01
        while True:
            tell(self.refresh())
            if self.status in ENDED:
                break
            _sleep(pause)
            pause = min(1.5 * pause, 1)
        if self.status != "successful":
            raise Problem(409, {"detail": f"the job {self.id} is {self.status}: {self.state.get('message') or 'no reason was given'}"})
        return self

    def result(self, progress: Progress = None) -> Result:
        """Waits for the end and downloads the Result; a download that breaks off is resumed."""
        self.wait(progress)
        want = f"{NPZ}, {JSON};q=0.5" if self.state.get("operation", "") in ROWS else JSON
        for accept in (want, OCTETS):
            sink = io.BytesIO()
            try:
                headers, request = self._fetch(accept, sink, ""), self.request()
                return result_of(headers, sink.getvalue(), bytes_of(request) if accept == OCTETS else 8).of(request)
            except Problem as problem:
                if accept == OCTETS or "max-answer-bytes" not in str(problem):
                    raise
        raise AssertionError

    def save(self, path: Path, accept: Optional[str] = None, progress: Progress = None) -> Path:
        """Waits for the end and writes the results to a file, in the format of its suffix.

        The bytes that have arrived are in PATH.part-ETAG: another `save`, also in a later process, resumes there.
        """
        accept = accept or accept_of(path)
        connection, response = self.wait(progress).client._open("HEAD", f"/v1/jobs/{self.id}/results", None, {"Accept": accept})
        connection.close()
        etag = response.headers["ETag"] or ""
        with _replacing(path, re.sub("[^0-9a-zA-Z]", "", etag)[:32]) as sink:
            self._fetch(accept, sink, etag)
        return path

    def stream(self, rows: int = 4096) -> Iterator[Result]:
        """Waits for the end and yields Results of at most `rows` rows each."""
        self.wait()
        yield from self.client._blocks("GET", f"/v1/jobs/{self.id}/results", None, rows, bytes_of(self.request()))

    def _fetch(self, accept: str, sink: BinaryIO, etag: str) -> Any:
        """Appends the missing bytes of the results with this ETag ("" = unknown) to sink; returns the header fields."""
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
    """Keeps the trailer fields of a stream, which http.client drops."""

    trailers: Any = {}

    def _read_and_discard_trailer(self) -> None:
        self.trailers = http.client.parse_headers(self.fp)


def _warn(response: Any) -> None:
    """Issues the warnings of an answer whose format cannot contain them."""
    for text in (response.headers.get_all("X-Warning") or []) + (response.trailers and response.trailers.get_all("X-Warning") or []):
        warnings.warn(text, stacklevel=3)


@contextlib.contextmanager
def _replacing(path: Path, kept: str = "") -> Iterator[Any]:
    """A temporary file that replaces the file at `path` when the block ends without an exception. A device or a pipe is written directly.
    kept: a suffix for the file of an interrupted download, which a later run continues."""
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


def _kept(part: str) -> Any:
    """Opens the partial download exclusively; BlockingIOError if another process has it."""
    while True:
        sink = open(part, "ab+")
        if not fcntl:
            return sink
        fcntl.flock(sink, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # another process may have renamed the file between open and flock
        if os.path.exists(part) and os.path.samestat(os.fstat(sink.fileno()), os.stat(part)):
            return sink
        sink.close()


def _bar() -> Callable[[Job], Any]:
    """A progress bar: tqdm's if it is installed, which notebooks draw, otherwise a line on standard error."""
    try:
        from tqdm.auto import tqdm  # type: ignore[import]
        bar = tqdm(total=100, unit="%")
    except ImportError:
        bar = None

    def show(job: Job) -> None:
        left = f", {job.state['remaining_seconds']:.0f} s left" if "remaining_seconds" in job.state else ""
        if bar is not None:
            bar.set_postfix_str(job.status + left)
            bar.update(job.progress - bar.n)
            if job.status in ENDED:
                bar.close()
            return
        line = f"[{'#' * (job.progress // 4):25}] {job.progress:3} % {job.status}{left}"
        print(f"\r{line:70}", file=sys.stderr, end="\n" if job.status in ENDED else "", flush=True)
    return show
