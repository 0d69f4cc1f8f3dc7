"""A pendulum whose methods send requests to a server, or to the engine in this process.

Leaves to others: the transport (client.py, local.py), which fields there are (operations.py and the server's /docs).
Invariant: a field that this module does not know goes to the server unchanged.
"""
from __future__ import annotations

import contextlib
import csv
import io
import os
import re
import urllib.parse
from collections.abc import Iterator, Mapping
from typing import Any, Optional, Union

import numpy as np

from .arrays import Result
from .client import Client
from .local import Local
from .measured import columns_of
from .operations import ROUTES, Operations

STATE = ("phi", "phid", "theta", "thetad", "unit", "mode", "amplitude")


def times_of(times: Any) -> Any:
    """"0:5:0.01" is start, stop, step, and "0:5/501" start, stop, count; arrays and dicts are left unchanged."""
    if not isinstance(times, str):
        return times
    found = re.fullmatch(r"([^:]+):([^:/]+)([:/])([^:/]+)", times)
    if not found:
        raise ValueError(f"times {times!r}: write start:stop:step or start:stop/count, as \"0:5:0.01\"")
    last = {"step": float(found[4])} if found[3] == ":" else {"count": int(found[4])}
    return {"start": float(found[1]), "stop": float(found[2])} | last


def _text(table: Any) -> str:
    """Returns a table as CSV: a file of text in UTF-8, UTF-16 or Latin 1, of Tracker, NPZ or MATLAB, a pandas.DataFrame, or a dict of columns."""
    if hasattr(table, "to_csv"):
        return str(table.to_csv(index=table.index.name is not None))
    if isinstance(table, Mapping):
        sink = io.StringIO()
        csv.writer(sink).writerows([list(table), *zip(*table.values())])
        return sink.getvalue()
    with open(table, "rb") as file:
        raw = file.read()
    columns = columns_of(raw)
    if columns:
        return _text(columns)
    for encoding in ("utf-16",) if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig", "latin-1"):
        with contextlib.suppress(UnicodeDecodeError):
            return raw.decode(encoding)
    raise ValueError(f"{os.fspath(table)!r} is not a text file")


def _measured(tables: Any, fields: dict[str, Any]) -> dict[str, Any]:
    """Returns the fields of a request with its tables, as `data.csv` or as one run per table."""
    if tables is None:
        return fields
    data = fields.get("data") or {}
    if isinstance(tables, (list, tuple)):
        runs = data.get("runs") or [{}] * len(tables)
        if len(runs) != len(tables):
            raise ValueError(f"{len(tables)} tables for {len(runs)} runs")
        data = data | {"runs": [run | {"csv": _text(table)} for run, table in zip(runs, tables)]}
    else:
        data = data | {"csv": _text(tables)}
    return fields | {"data": data}


class Pendulum(Operations):
    """A pendulum tree: `Pendulum([1, 1], [1, 1], [0, 1])` by lengths (m), masses (kg) and parents (0 = pivot), or by L, m, S or arms.

    client  a Client, the URL of a server, or "local": the engine in this process (local.py); by default `Client()`
    Every other field goes to the server unchanged: rod, body, damping, gravity, cart, ...
    """

    def __init__(self, *form: Any, client: Union[Client, Local, str, None] = None, **fields: Any) -> None:
        if form and isinstance(form[0], (Client, Local)):
            client, *form = form  # type: ignore[assignment]
        if len(form) > 3 or form and isinstance(form[0], str):
            raise TypeError(f"{form[0]!r} is not a list of lengths: write Pendulum([1, 1], [1, 1], [0, 1]), or Pendulum.preset(name) for a ready one")
        self.fields: dict[str, Any] = dict(zip(("length", "mass", "parent"), form)) | fields
        self.client: Any = Local() if client == "local" else Client(client) if isinstance(client, str) else client or Client()

    def __repr__(self) -> str:
        return f"Pendulum({', '.join(f'{name}={value!r}' for name, value in self.fields.items())})"

    def _repr_html_(self) -> str:
        from .pictures import pendulum_html
        return pendulum_html(self)

    @property
    def aio(self) -> Any:
        """This pendulum for asyncio: every method is a coroutine, `stream` an asynchronous iterator."""
        from .aio import Async
        return Async(self)

    @classmethod
    def preset(cls, name: str, client: Any = None) -> Pendulum:
        """Returns an example pendulum; its attributes `initial` and `times` describe a motion worth watching."""
        found = (client or Client()).get(f"/v1/presets/{urllib.parse.quote(name)}")
        made = cls(client=client, **found["pendulum"])
        made.initial, made.times = found["initial"], found["times"]
        return made

    initial: Any
    times: Any

    def request(self, **fields: Any) -> dict[str, Any]:
        """The body of a request: phi, phid, theta, thetad, unit, mode and amplitude become its `initial`."""
        initial = {name: fields.pop(name) for name in STATE if name in fields}
        if initial and "initial" in fields:
            raise TypeError(f"the start is given twice, by initial and by {', '.join(initial)}")
        return {"pendulum": self.fields} | ({"initial": initial} if initial else {}) | fields

    def ask(self, route: str, *, job: Union[bool, str] = False, title: Optional[str] = None, save: Any = None, **fields: Any) -> Any:
        """POST /v1/ROUTE with this pendulum: a Result; with job=True (or a key of your own) a Job; with save="a.npz" that path."""
        # mode and amplitude of an orbit are fields of the request, not its start
        body = {"pendulum": self.fields} | fields if route == "orbits" else self.request(**fields)
        if save is not None:
            return self.client.save(route, body, save)
        if job:
            return self.client.submit(route, body, None if job is True else job, title)
        return self.client.call(route, body)

    def _method(self, name: str, given: dict[str, Any]) -> Any:
        given = {key: value for key, value in given.items() if value is not None and key not in ("self", "fields")} | given["fields"]
        if "times" in given:
            given["times"] = times_of(given["times"])
        tables = given.pop("csv", None)
        return self.ask(ROUTES[name], **_measured(tables, given))

    def stream(self, times: Any, rows: int = 4096, **fields: Any) -> Iterator[Result]:
        """Yields the motion as Results of at most `rows` rows each while they are computed; needs little memory for any length."""
        stream: Iterator[Result] = self.client.stream("trajectories", self.request(times=times_of(times), **fields), rows)
        return stream

    def members(self, rows: int = 4096, **fields: Any) -> Iterator[Result]:
        """Yields the members of an ensemble while they are computed, each a Result; fields as for `ensemble`."""
        request = self.request(**{key: times_of(value) if key == "times" else value for key, value in fields.items()})
        kept: list[Result] = []
        for block in self.client.stream("ensembles", request, rows):
            *whole, last = block.of(request).members()
            for member in [*whole, last]:
                if kept and kept[0]["member"][0] != member["member"][0]:
                    yield _joined(kept)
                    kept = []
                kept.append(member)
        if kept:
            yield _joined(kept)

    def tree_positions(self, phi: Any) -> Any:
        """Returns the complex positions z = S [l e^(i phi)] of the tips at angles phi, of shape (..., n); 0 is the pivot."""
        length, paths = self._lists()
        return (length * np.exp(1j * np.asarray(phi, float))) @ paths.T

    def _lists(self) -> tuple[Any, Any]:
        """Returns lengths and the path matrix S of a pendulum in any form."""
        fields, arms = self.fields, self.fields.get("arms")
        if "S" in fields:
            return np.asarray(fields["L"], float), np.asarray(fields["S"], float)
        length = np.asarray([arm["length"] for arm in arms] if arms else fields["length"], float)
        names = {arm.get("name", k): k for k, arm in enumerate(arms, 1)} if arms else {}
        parents = [names.get(arm.get("parent"), arm.get("parent") or 0) for arm in arms] if arms else list(fields["parent"])
        paths = np.eye(len(length))
        done = [parent == 0 for parent in parents]
        while not all(done):
            for k, parent in enumerate(parents):
                if not done[k] and done[parent - 1]:
                    paths[k] += paths[parent - 1]
                    done[k] = True
        return length, paths


def _joined(parts: list[Result]) -> Result:
    return parts[0] if len(parts) == 1 else Result({name: np.concatenate([part[name] for part in parts]) for name in parts[0]}).of(parts[0].request)
