"""Answers of a pendulumd server as NumPy arrays, and as tables of pandas and xarray where these are installed.

Leaves to others: bringing them (the package's other file). Invariant: every number is the server's to the last bit.
"""
import io
import json
import re

import numpy as np

NPZ, JSON, OCTETS = "application/x-npz", "application/json", "application/octet-stream"
_COLUMN = re.compile(r"(\w+)(?:\[(\d+)\])?")


class Result(dict):
    """Arrays by name, as attributes too: `r.phi`, and `r.lambda_` since lambda is a word of Python.

    Rows are instants (or members), columns are arms. `stats` is a dict, `warnings` a list of texts.
    """

    def __getattr__(self, name):
        try:
            return self[name[:-1] if name.endswith("_") else name]
        except KeyError:
            raise AttributeError(f"there is no {name}, only {', '.join(self)}") from None

    def _tables(self):
        arrays = {name: value for name, value in self.items() if isinstance(value, np.ndarray) and value.ndim in (1, 2)}
        rows = len(next(iter(arrays.values()), ()))
        return {name: value for name, value in arrays.items() if len(value) == rows}

    def columns(self):
        """Arrays of one dimension by the names that columns have in the CSV: phi_1, z_re_2, energy_total."""
        columns = {}
        for name, value in self._tables().items():
            parts = {name + "_re": value.real, name + "_im": value.imag} if np.iscomplexobj(value) else {name: value}
            for part, array in parts.items():
                columns |= {part: array} if array.ndim == 1 else {f"{part}_{k}": column for k, column in enumerate(array.T, 1)}
        return columns

    def to_pandas(self):
        """A pandas.DataFrame of `columns`; `attrs` are the statistics."""
        import pandas
        frame = pandas.DataFrame(self.columns())
        frame.attrs = dict(self.get("stats", {}))
        return frame.set_index("t") if "t" in frame and "member" not in frame else frame

    def to_xarray(self):
        """An xarray.Dataset over t, member or row, and over arm."""
        import xarray
        tables = self._tables()
        keys = [key for key in ("t", "member") if key in tables]
        row, arms = keys[0] if len(keys) == 1 else "row", max((v.shape[1] for v in tables.values() if v.ndim == 2), default=0)
        fields = {name: ((row, "arm" if v.shape[-1] == arms else f"{name}_column")[:v.ndim], v) for name, v in tables.items()}
        return xarray.Dataset(fields, {"arm": np.arange(1, arms + 1)} if arms else {}, dict(self.get("stats", {})))


def _from_npz(data):
    with np.load(io.BytesIO(data), allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    words = arrays.pop("warnings", np.array([])).tolist()
    stats = {name[6:]: arrays.pop(name).item() for name in list(arrays) if name.startswith("stats_")}
    return Result(arrays, stats=stats, warnings=words)


def _from_json(value):
    """Lists of numbers become arrays, {re, im} complex ones, objects Results."""
    if isinstance(value, dict):
        if set(value) == {"re", "im"}:
            return np.array(value["re"], float) + 1j * np.array(value["im"], float)
        return Result({name: _from_json(part) for name, part in value.items()})
    flat = value if isinstance(value, list) else []
    while flat and isinstance(flat[0], list):
        flat = [item for row in flat for item in row]
    return np.array(value, float) if flat and all(type(item) in (int, float, type(None)) for item in flat) else value


def width_of(columns):
    return sum(int(count or 1) for _, count in _COLUMN.findall(columns))


def bytes_of(request):
    """Of a number in rows that a request asks for."""
    return 4 if request.get("number") == "float32" else 8


def from_octets(columns, data, each=8):
    """The arrays of rows of numbers of `each` bytes; columns is "t,phi[4],z_re[4],z_im[4]"."""
    rows, result, at = np.frombuffer(data, f"<f{each}").reshape(-1, width_of(columns)), Result(), 0
    for name, count in _COLUMN.findall(columns):
        result[name] = rows[:, at:at + int(count)] if count else rows[:, at]
        at += int(count or 1)
    for name in [n[:-3] for n in result if n.endswith("_re") and n[:-3] + "_im" in result]:
        result[name] = result.pop(name + "_re") + 1j * result.pop(name + "_im")
    return result


def result_of(headers, data, each=8):
    kind = headers["Content-Type"].partition(";")[0]
    if kind == NPZ:
        return _from_npz(data)
    return from_octets(headers["X-Columns"], data, each) if kind == OCTETS else _from_json(json.loads(data))
