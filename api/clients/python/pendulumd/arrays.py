"""Answers of a pendulumd server as NumPy arrays, and as tables of pandas and xarray if these are installed.

Leaves to others: the transport (client.py), pictures (pictures.py). Invariant: every number is the server's to the last bit;
numbers that count or name something are integers.
"""
from __future__ import annotations

import io
import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

NPZ, JSON, OCTETS = "application/x-npz", "application/json", "application/octet-stream"
_COLUMN = re.compile(r"(\w+)(?:\[(\d+)\])?")
# columns of whole numbers, which binary answers contain as doubles
INTEGERS = {"member", "status", "mode", "event", "direction", "stable", "kind", "after", "first_flip_arm", "flips", "lambda_max_arm", "lambda_min_arm",
            "events_count", "events_direction"}
UNITS = {"t": "s", "time": "s", "period": "s", "phi": "rad", "theta": "rad", "amplitude": "rad", "phase": "rad", "phid": "rad/s", "thetad": "rad/s", "omega": "rad/s",
         "phidd": "rad/s2", "z": "m", "zd": "m/s", "zdd": "m/s2", "cart_x": "m", "cart_v": "m/s", "cart_reaction": "N", "lambda": "N", "joint_force": "N", "tip_force": "N",
         "energy": "J", "kinetic": "J", "potential": "J", "total": "J", "work": "J", "heat": "J", "drift": "J", "frequency": "Hz", "growth": "1/s", "lyapunov": "1/s", "exponents": "1/s",
         "horizon": "s"}


def unit_of(name: str) -> str:
    """Returns the unit of a column, "" if it has none: first_flip_time has that of time, final_phi that of phi."""
    for known in (name, name.rpartition("_")[2], name.rpartition("_")[0]):
        if known in UNITS and name not in INTEGERS:
            return UNITS[known]
    return ""


class Result(dict[str, Any]):
    """Arrays by name, also as attributes: `r.phi`, and `r.lambda_`, because lambda is a keyword of Python.

    Rows are instants (or members), columns are arms. `stats` is a dict, `warnings` a list of texts, `request` what was asked.
    A time that never comes is NaN.
    """

    request: Mapping[str, Any]

    def of(self, request: Mapping[str, Any]) -> Result:
        """Stores the request of this answer."""
        object.__setattr__(self, "request", request)
        return self

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name[:-1] if name.endswith("_") else name]
        except KeyError:
            if name == "request":
                return {}
            raise AttributeError(f"there is no {name}, only {', '.join(self)}") from None

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *("lambda_" if name == "lambda" else name for name in self)})

    def __repr__(self) -> str:
        parts = [f"{name}{list(value.shape)}" if isinstance(value, np.ndarray) else name for name, value in self.items()]
        return f"<Result {', '.join(parts)}>"

    def _repr_html_(self) -> str:
        from .pictures import result_html
        return result_html(self)

    def plot(self, *names: str, ax: Any = None) -> Any:
        """Plots columns against time (or a map of two axes) with matplotlib; returns its axes. names: "phi", "energy_total", ...; by default the first."""
        from .pictures import plot
        return plot(self, names, ax)

    def animate(self, speed: float = 1, ax: Any = None) -> Any:
        """The motion as a matplotlib animation, which a notebook shows by `.to_jshtml()`. speed: 2 = twice as fast as real time."""
        from .pictures import animate
        return animate(self, speed, ax)

    def _tables(self) -> dict[str, Any]:
        arrays = {name: value for name, value in self.items() if isinstance(value, np.ndarray) and value.ndim in (1, 2)}
        rows = len(next(iter(arrays.values()), ()))
        return {name: value for name, value in arrays.items() if len(value) == rows}

    def columns(self) -> dict[str, Any]:
        """Returns one-dimensional arrays by the names of the CSV's columns: phi_1, z_re_2, energy_total."""
        columns: dict[str, Any] = {}
        for name, value in self._tables().items():
            parts = {name + "_re": value.real, name + "_im": value.imag} if np.iscomplexobj(value) else {name: value}
            for part, array in parts.items():
                columns |= {part: array} if array.ndim == 1 else {f"{part}_{k}": column for k, column in enumerate(array.T, 1)}
        return columns

    def axes(self) -> dict[str, Any]:
        """Returns the values on the axes of a grid by their names, the fastest first: {"theta_1": [...], "theta_2": [...]}; {} without a grid."""
        found = {}
        for axis in self.request.get("grid", ()):
            values = axis.get("values")
            if values is None:
                space: Any = np.geomspace if axis.get("scale") == "log" else np.linspace
                values = space(axis["start"], axis["stop"], axis["count"]) if {"start", "stop", "count"} <= axis.keys() else None
            if values is None or not isinstance(axis.get("vary"), str):
                return {}
            found["_".join(str(part) for part in (axis["vary"], axis.get("arm")) if part is not None)] = np.asarray(values)
        return found

    def members(self) -> Iterator[Result]:
        """Yields the rows of each member of an ensemble as a Result."""
        tables = self._tables()
        cuts = np.flatnonzero(np.diff(tables["member"])) + 1
        for begin, end in zip([0, *cuts], [*cuts, len(tables["member"])]):
            yield Result({name: value[begin:end] for name, value in tables.items()}).of(self.request)

    def to_pandas(self) -> Any:
        """Returns a pandas.DataFrame of `columns`; a grid's axes are columns too; `attrs` are the statistics and units."""
        import pandas  # type: ignore[import]
        columns = self.columns()
        axes = self.axes()
        if axes and len(columns.get("member", ())):
            places = np.unravel_index(columns["member"], [len(values) for values in axes.values()], order="F")
            columns |= {name: values[place] for (name, values), place in zip(axes.items(), places)}
        frame = pandas.DataFrame(columns)
        frame.attrs = {**self.get("stats", {}), "units": {name: unit_of(re.sub(r"_\d+$", "", name)) for name in columns}}
        return frame.set_index("t") if "t" in frame and "member" not in frame else frame

    def to_xarray(self) -> Any:
        """Returns an xarray.Dataset over t, member or the axes of a grid, and over arm; arrays have their units in `attrs`."""
        import xarray
        tables, axes = self._tables(), self.axes()
        arms = max((v.shape[1] for v in tables.values() if v.ndim == 2), default=0)
        coords = {"arm": np.arange(1, arms + 1)} if arms else {}
        rows, shape = self._rows(tables, axes)
        for name in rows:
            if name in axes:
                coords[name] = axes[name]
            elif len(rows) > 1 and name in tables:
                coords[name] = tables[name][:shape[rows.index(name)]] if name == "t" else np.unique(tables[name])
        fields: dict[str, Any] = {}
        for name, value in tables.items():
            if name in coords or (name == "member" and axes and len(rows) >= len(axes)):
                continue
            kinds = () if value.ndim == 1 else ("arm" if value.shape[1] == arms else f"{name}_column",)
            fields[name] = ((*rows, *kinds), value.reshape(*shape, *value.shape[1:]), {"units": unit_of(name)} if unit_of(name) else {})
        return xarray.Dataset(fields, coords, dict(self.get("stats", {})))

    def _rows(self, tables: Mapping[str, Any], axes: Mapping[str, Any]) -> tuple[list[str], list[int]]:
        """Returns the dimensions of the rows, the slowest first, and their sizes."""
        count = len(next(iter(tables.values()), ()))
        members = int(np.prod([len(values) for values in axes.values()])) if axes else len(np.unique(tables["member"])) if "member" in tables else 0
        names, sizes = (list(axes)[::-1], [len(values) for values in axes.values()][::-1]) if axes else (["member"], [members])
        if members and count == members:
            return names, sizes
        if members and "t" in tables and count % members == 0 and np.array_equal(tables["member"], np.repeat(np.arange(members), count // members)):
            return [*names, "t"], [*sizes, count // members]
        keys = [key for key in ("t", "member", "mode") if key in tables]
        return [keys[0] if len(keys) == 1 else "row"], [count]


def _whole(name: str, value: Any) -> Any:
    """Converts counts and numbers of arms to integers, unless some are missing."""
    if name in INTEGERS and isinstance(value, np.ndarray) and value.dtype.kind == "f" and np.isfinite(value).all():
        return value.astype(np.int64)
    return value


def _from_npz(data: bytes) -> Result:
    with np.load(io.BytesIO(data), allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    words = arrays.pop("warnings", np.array([])).tolist()
    stats = {name[6:]: arrays.pop(name).item() for name in list(arrays) if name.startswith("stats_")}
    return Result({name: _whole(name, value) for name, value in arrays.items()}, stats=stats, warnings=words)


def _from_json(value: Any, name: str = "") -> Any:
    """Converts lists of numbers to arrays, {re, im} to complex arrays, and objects to Results."""
    if isinstance(value, dict):
        if set(value) == {"re", "im"}:
            return np.array(value["re"], float) + 1j * np.array(value["im"], float)
        return Result({key: _from_json(part, key) for key, part in value.items()})
    flat = value if isinstance(value, list) else []
    while flat and isinstance(flat[0], list):
        flat = [item for row in flat for item in row]
    if flat and all(isinstance(item, dict) for item in flat):
        return [_from_json(item) for item in value]
    return _whole(name, np.array(value, float)) if flat and all(type(item) in (int, float, type(None)) for item in flat) else value


def width_of(columns: str) -> int:
    return sum(int(count or 1) for _, count in _COLUMN.findall(columns))


def bytes_of(request: Mapping[str, Any]) -> int:
    """Returns the bytes per number in the rows of a request's answer."""
    return 4 if request.get("number") == "float32" else 8


def from_octets(columns: str, data: bytes, each: int = 8) -> Result:
    """Returns the arrays in rows of numbers of `each` bytes; columns is "t,phi[4],z_re[4],z_im[4]"."""
    rows, result, at = np.frombuffer(data, f"<f{each}").reshape(-1, width_of(columns)), Result(), 0
    for name, count in _COLUMN.findall(columns):
        result[name] = rows[:, at:at + int(count)] if count else _whole(name, rows[:, at])
        at += int(count or 1)
    for name in [n[:-3] for n in result if n.endswith("_re") and n[:-3] + "_im" in result]:
        result[name] = result.pop(name + "_re") + 1j * result.pop(name + "_im")
    return result


def result_of(headers: Any, data: bytes, each: int = 8) -> Result:
    kind = headers["Content-Type"].partition(";")[0]
    if kind == NPZ:
        return _from_npz(data)
    if kind == OCTETS:
        return from_octets(headers["X-Columns"], data, each)
    found: Result = _from_json(json.loads(data))
    for name in [name for name, value in found.items() if isinstance(value, Result) and name != "stats"]:
        # as in binary answers: energy_total
        found |= {f"{name}_{part}": np.asarray(value) for part, value in found[name].items() if isinstance(value, (int, float, np.ndarray))}
    return Result(found | {"stats": dict(found.get("stats", {})), "warnings": found.get("warnings", [])})
