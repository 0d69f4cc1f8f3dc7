"""Files of measurements that are not text, as columns of a table: Tracker projects (.trk), NPZ archives and MAT-files.

Leaves to others: text (pendulum.py), what a column means (the server).
Invariant: a file of another kind is None.
"""
from __future__ import annotations

import io
import xml.etree.ElementTree as ElementTree
import zipfile
from collections.abc import Mapping
from typing import Any, Optional

import numpy as np

NAMES = {"theta": "theta_{} (rad)", "phi": "phi_{} (rad)", "joint": "joint_{} (rad)", "thetad": "thetad_{} (rad/s)", "phid": "thetad_{} (rad/s)", "x": "x_{}", "y": "y_{}"}
ALIKE = {"phi": "theta", "phid": "thetad"}  # left out where the other is there


def _of_arrays(arrays: Mapping[str, Any]) -> dict[str, Any]:
    """Columns from arrays with one row per instant `t`, as results of this service have them: an arm per column."""
    if "t" not in arrays:
        raise ValueError(f"the file has no array \"t\", the instants in s, but {', '.join(arrays) or 'nothing'}")
    t = np.ravel(arrays["t"])
    table = {"t": t}
    if "z" in arrays:
        arrays = {**arrays, "x": np.real(arrays["z"]), "y": np.imag(arrays["z"])}
    for name, column in NAMES.items():
        if name not in arrays or ALIKE.get(name) in arrays or np.size(arrays[name]) % t.size:
            continue
        rows = np.reshape(arrays[name], (t.size, -1))
        table |= {column.format(arm + 1): rows[:, arm] for arm in range(rows.shape[1])}
    return table


def _of_tracker(raw: bytes) -> dict[str, Any]:
    """Columns of a Tracker project: the instants, and the positions of its point masses, an arm each, in its unit of length."""
    def objects(node: Any, kind: str) -> list[Any]:
        return [one for one in node.iter("object") if one.get("class", "").endswith(kind)]

    def number(node: Any, name: str, usual: Optional[float] = None) -> Any:
        return next((float(one.text) for one in node.iter("property") if one.get("name") == name), usual)

    panel = ElementTree.fromstring(raw)
    frames = objects(panel, "ImageCoordSystem$FrameData")
    masses = objects(panel, ".PointMass")
    if len(frames) != 1 or not masses:
        raise ValueError("a Tracker project needs one coordinate system that stays, and point masses: save its table by File > Export > Data File")
    origin = complex(number(frames[0], "xorigin"), -number(frames[0], "yorigin"))
    scale = complex(number(frames[0], "xscale", 1)) * np.exp(1j * np.radians(number(frames[0], "angle", 0)))
    step, first, start = (number(panel, name, usual) for name, usual in (("delta_t", None), ("startframe", 0), ("starttime", 0)))
    places: dict[int, dict[str, float]] = {}
    for arm, mass in enumerate(masses, 1):
        for frame in mass.findall("property[@name='framedata']/property"):
            z = (complex(number(frame, "x"), -number(frame, "y")) - origin) / scale  # y counts downwards
            places.setdefault(int(frame.get("name", "[0]")[1:-1]), {}).update({f"x_{arm}": z.real, f"y_{arm}": z.imag})
    rows = sorted(places.items())
    columns = [f"{axis}_{arm + 1}" for arm in range(len(masses)) for axis in "xy"]
    table = {"t": np.array([((frame - first) * step + start) / 1000 for frame, _ in rows])}
    return table | {name: np.array([row.get(name, np.nan) for _, row in rows]) for name in columns}


def columns_of(raw: bytes) -> Optional[dict[str, Any]]:
    """Returns the columns of a file of one of these kinds; None for another file."""
    if zipfile.is_zipfile(io.BytesIO(raw)) and all(name.endswith(".npy") for name in zipfile.ZipFile(io.BytesIO(raw)).namelist()):
        return _of_arrays(np.load(io.BytesIO(raw)))
    if raw[:10] == b"MATLAB 5.0":
        from scipy.io import loadmat  # type: ignore[import]
        return _of_arrays(loadmat(io.BytesIO(raw)))
    if raw.lstrip()[:5] == b"<?xml" and b"cabrillo.tracker.TrackerPanel" in raw[:1000]:
        return _of_tracker(raw)
    return None
