"""The engine in this process: the answers of a server, computed by the shared library libpendulum.so.

Leaves to others: what a request is (the server's /docs), servers (client.py). Invariant: an answer has the bytes that a server on this
processor sends, except compute_seconds. The interpreter's lock is free while the engine computes, so threads compute side by side.
"""
from __future__ import annotations

import ctypes
import email.parser
import json
import os
import pathlib
import threading
import warnings
from collections.abc import Generator, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Optional

from .arrays import JSON, NPZ, OCTETS, Result, bytes_of, from_octets, result_of, width_of
from .client import ROWS, Body, Path, Problem, _replacing, accept_of, body_of

_MORE, _BROKEN = 0, 2
STREAMED = ("text/csv", "application/x-ndjson", OCTETS)  # other forms are held until their end
_lock = threading.Lock()
_library: Any = None


def _load() -> Any:
    """Loads the library: PENDULUM_LIBRARY, or one beside this file, or the system's."""
    global _library
    with _lock:
        if _library is not None:
            return _library
        beside = pathlib.Path(__file__).with_name("libpendulum.so.0")
        name = os.environ.get("PENDULUM_LIBRARY") or (str(beside) if beside.exists() else "libpendulum.so.0")
        try:
            library = ctypes.CDLL(name)
        except OSError as error:
            raise ImportError(f"the engine cannot be loaded ({error}): install the package python3-pendulumd, or name libpendulum.so in PENDULUM_LIBRARY") from error
        for function, kind, arguments in (("door_room", ctypes.c_void_p, [ctypes.c_size_t]), ("door_open", ctypes.c_int, []), ("door_run", ctypes.c_int, []),
                                          ("door_data", ctypes.c_void_p, []), ("door_bytes", ctypes.c_size_t, []), ("door_taken", None, []), ("door_promise", None, []),
                                          ("door_status", ctypes.c_int, []), ("door_head", ctypes.c_char_p, []), ("door_close", None, []),
                                          ("api_held_new", ctypes.c_void_p, [ctypes.c_char_p, ctypes.c_size_t]), ("api_held_free", None, [ctypes.c_void_p]),
                                          ("api_held_step", ctypes.c_long, [ctypes.c_void_p, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p])):
            getattr(library, function).restype = kind
            getattr(library, function).argtypes = arguments
        _library = library
        return library


class Local:
    """Answers requests in this process, as Client does by a server. It has no jobs: use `call` in a thread or a process of your own."""

    def __init__(self) -> None:
        self._engine = _load()

    def __repr__(self) -> str:
        return "<Local>"

    def __reduce__(self) -> Any:
        return Local, ()

    def _answer(self, route: str, argument: str, body: bytes, accept: str, streamed: bool) -> Generator[tuple[Any, bytes], None, None]:
        """Yields (header fields, bytes) of an answer: all bytes at once, or pieces while they are computed.

        The engine holds one request in each thread: all steps run in the same thread, and none of another request between them.
        """
        engine = self._engine
        text = b"\0".join([route.encode(), argument.encode(), accept.encode(), body])
        place = engine.door_room(len(text))
        if not place:
            raise MemoryError(f"a request of {len(text)} bytes")
        ctypes.memmove(place, text, len(text))
        state = engine.door_open()
        if state < 0:
            raise Problem(404, {"detail": f"the engine has no operation {route}"})
        if streamed and state == _MORE:
            engine.door_promise()
        try:
            while state == _MORE:
                state = engine.door_run()
                if streamed and engine.door_bytes() and engine.door_status() < 400:
                    yield self._head(), self._take()
            head, data = self._head(), self._take()
            if engine.door_status() >= 400:
                raise Problem(engine.door_status(), json.loads(data))
            if state == _BROKEN:
                raise Problem(500, {"detail": "the computation failed before its end"})
            yield head, data
        finally:
            engine.door_room(0)  # closes the request and frees its text

    def _head(self) -> Any:
        return email.parser.HeaderParser().parsestr((self._engine.door_head() or b"").decode())

    def _take(self) -> bytes:
        data = ctypes.string_at(self._engine.door_data(), self._engine.door_bytes()) if self._engine.door_bytes() else b""
        self._engine.door_taken()
        return data

    def call(self, route: str, request: Body, accept: Optional[str] = None) -> Any:
        """The answer of an operation: a Result, or bytes if `accept` names a media type."""
        want = accept or (f"{NPZ}, {JSON};q=0.5" if route in ROWS else JSON)
        (head, data), = self._answer(route, "", body_of(request), want, False)
        return data if accept else result_of(head, data, bytes_of(request)).of(request)

    def stream(self, route: str, request: Body, rows: int = 4096) -> Iterator[Result]:
        """Yields Results of at most `rows` rows each, while they are computed."""
        each, data, size, columns = bytes_of(request), b"", 0, ""
        head: Any = {}
        # in its own thread, because the caller may send other requests between two blocks
        with ThreadPoolExecutor(1) as pool:
            pieces: Any = self._answer(route, "", body_of(request), OCTETS, True)
            try:
                while found := pool.submit(lambda: next(pieces, None)).result():
                    head, piece = found
                    columns = columns or head["X-Columns"]
                    size = size or each * width_of(columns) * rows
                    data += piece
                    while len(data) >= size:
                        yield from_octets(columns, data[:size], each)
                        data = data[size:]
            finally:
                pool.submit(pieces.close).result()
        if data:
            yield from_octets(columns, data, each)
        _warn(head)

    def save(self, route: str, request: Body, path: Path) -> Path:
        """Writes the answer of an operation to a file while it is computed, in the format of the file's suffix."""
        head: Any = {}
        accept = accept_of(path)
        with _replacing(path) as sink:
            for head, piece in self._answer(route, "", body_of(request), accept, accept in STREAMED):
                sink.write(piece)
        _warn(head)
        return path

    def submit(self, route: str, request: Body, key: Optional[str] = None, title: Optional[str] = None) -> Any:
        raise NotImplementedError("the engine in this process has no jobs: call it in a thread, or ask a server")

    def get(self, path: str) -> Any:
        """The JSON of /v1/presets or /v1/presets/NAME."""
        name = path.removeprefix("/v1/presets").strip("/")
        return json.loads(b"".join(piece for _, piece in self._answer("presets", name, b"", JSON, False)))


def _warn(head: Any) -> None:
    for text in head.get_all("X-Warning") or []:
        warnings.warn(text, stacklevel=3)


class Steps:
    """Steps of many pendulums with held torques and forces, without a request for each; used by environments (envs.py).

    size     coordinates: the arms of the pendulum, and a cart
    request  of an ensemble; `duration` is the time of a step. A constant `torque` or `force` other than 0 has to be there; the inputs
             replace all of them.
    threads  that compute side by side
    """

    def __init__(self, size: int, request: Body, threads: int = 1) -> None:
        self.size = size
        engine, body = _load(), body_of(request)
        self._step, self._free = engine.api_held_step, engine.api_held_free
        self._held = [engine.api_held_new(body, len(body)) for _ in range(threads)]
        if not all(self._held):
            Local().call("ensembles", request)  # raises the reasons
            raise ValueError("no arm of the pendulum has a constant `torque` other than 0, and no cart a `force`")
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None

    def __call__(self, state: Any, inputs: Any) -> int:
        """Steps the rows of `state` in place and returns the number of failures (rows of NaN).

        state   (count, 2 n + 1), C-contiguous float64: all theta, all rates, place and speed of a cart, and the time of the drives
        inputs  (count, n): a torque for every arm, N m, then the force on a cart, N
        """
        count = len(state)
        if state.shape != (count, 2 * self.size + 1) or inputs.shape != (count, self.size):
            raise ValueError(f"states of shape {state.shape} and inputs of shape {inputs.shape} for {self.size} coordinates")
        ends = [count * i // len(self._held) for i in range(len(self._held) + 1)]

        def part(i: int) -> int:
            rows = slice(ends[i], ends[i + 1])
            return int(self._step(self._held[i], ends[i + 1] - ends[i], state[rows].ctypes.data, inputs[rows].ctypes.data))
        failed = list(self._pool.map(part, range(len(ends) - 1))) if self._pool else [part(0)]
        if min(failed) < 0:
            raise MemoryError("no memory for a step")
        return sum(failed)

    def close(self) -> None:
        """Frees the memory."""
        held, self._held = self._held, []
        for one in held:
            self._free(one)

    def __del__(self) -> None:
        if hasattr(self, "_held"):
            self.close()
