"""Pictures of pendulums and answers: SVG for notebooks, plots and animations by matplotlib if that is installed.

Leaves to others: the numbers (arrays.py). Invariant: a picture never asks a server.
"""
from __future__ import annotations

import html
from typing import TYPE_CHECKING, Any

import numpy as np

from .arrays import Result, unit_of

if TYPE_CHECKING:
    from .pendulum import Pendulum


def _arms(pendulum: Any, phi: Any) -> tuple[Any, Any]:
    """Returns the start and end of every arm at angles phi, complex, of shape (..., n)."""
    length, _ = pendulum._lists()
    ends = pendulum.tree_positions(phi)
    return ends - length * np.exp(1j * np.asarray(phi)), ends


def _svg_tree(pendulum: Any, size: int = 120) -> str:
    """Draws the hanging tree, with its branches spread a little."""
    length, paths = pendulum._lists()
    depth = paths.sum(axis=1)
    theta = 0.5 * np.cos(2.4 * np.arange(len(length))) * (depth > 0)
    begin, end = _arms(pendulum, theta - np.pi / 2)
    points = np.concatenate([begin, end, [0]])
    span = max(np.ptp(points.real), np.ptp(points.imag), 1e-300)
    middle = (points.real.min() + points.real.max()) / 2 + 1j * (points.imag.min() + points.imag.max()) / 2
    masses = np.asarray(pendulum.fields.get("mass", pendulum.fields.get("m", [1] * len(length))), float)
    if masses.shape != length.shape:
        masses = np.ones(len(length))

    def place(z: complex) -> tuple[float, float]:
        scaled = (z - middle) / span * (size - 24)
        return round(size / 2 + scaled.real, 1), round(size / 2 - scaled.imag, 1)
    lines = "".join('<line x1="{}" y1="{}" x2="{}" y2="{}" stroke="#456" stroke-width="2"/>'.format(*place(a), *place(b)) for a, b in zip(begin, end))
    radius = 3 + 5 * np.cbrt(masses / max(masses.max(), 1e-300))
    bobs = "".join('<circle cx="{}" cy="{}" r="{:.1f}" fill="#c60"/>'.format(*place(z), r) for z, r in zip(end, radius))
    pivot = '<rect x="{:.1f}" y="{:.1f}" width="8" height="4" fill="#222"/>'.format(place(0)[0] - 4, place(0)[1] - 4)
    return f'<svg width="{size}" height="{size}" role="img" aria-label="pendulum of {len(length)} arms">{lines}{bobs}{pivot}</svg>'


def pendulum_html(pendulum: Pendulum) -> str:
    """A small picture of the tree, and its fields."""
    length, _ = pendulum._lists()
    picture = _svg_tree(pendulum) if len(length) <= 200 else ""
    return f"{picture}<div><code>{html.escape(repr(pendulum))}</code></div>"


def _svg_line(x: Any, y: Any, width: int = 150, height: int = 36) -> str:
    """A curve of at most 300 points; "" if there are not two finite ones."""
    pick = np.unique(np.linspace(0, len(y) - 1, min(len(y), 300)).astype(int))
    x, y = np.asarray(x, float)[pick], np.asarray(y, float)[pick]
    good = np.isfinite(x) & np.isfinite(y)
    if good.sum() < 2:
        return ""
    x, y = x[good], y[good]
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip((x - x.min()) / max(np.ptp(x), 1e-300) * (width - 2) + 1, height - 2 - (y - y.min()) / max(np.ptp(y), 1e-300) * (height - 4)))
    return f'<svg width="{width}" height="{height}"><polyline points="{points}" fill="none" stroke="#456"/></svg>'


def result_html(result: Result) -> str:
    """A table of the arrays: name, unit, shape, range, and a curve of the first column."""
    rows = []
    for name, value in result.items():
        if not isinstance(value, np.ndarray) or value.dtype.kind not in "fic" or not value.size:
            continue
        parts = value.real if value.dtype.kind == "c" else value
        finite = parts[np.isfinite(parts)] if parts.dtype.kind == "f" else parts
        extent = f"{finite.min():.6g} to {finite.max():.6g}" if finite.size else "none"
        first = parts.reshape(len(parts), -1)[:, 0] if parts.ndim else np.array([])
        curve = _svg_line(np.arange(len(first)), first) if name != "t" else ""
        rows.append(f"<tr><td><code>{html.escape(name)}</code></td><td>{unit_of(name)}</td><td>{' x '.join(map(str, value.shape))}</td><td>{extent}</td><td>{curve}</td></tr>")
    stats = ", ".join(f"{name} {value:.6g}" if isinstance(value, float) else f"{name} {value}" for name, value in result.get("stats", {}).items())
    warnings = "".join(f"<div>&#9888; {html.escape(text)}</div>" for text in result.get("warnings", ()))
    return f"<table><tr><th></th><th>unit</th><th>shape</th><th>range</th><th></th></tr>{''.join(rows)}</table><div>{html.escape(stats)}</div>{warnings}"


def job_html(state: dict[str, Any]) -> str:
    """A job's progress bar and description."""
    said = [state["operation"], state["title"] or "", state["status"], f"{state['progress']} %", state["message"]]
    return (f'<progress value="{state["progress"]}" max="100"></progress> {html.escape(", ".join(filter(None, said)))}'
            f'<div><code>client.job("{html.escape(state["id"])}")</code></div>')


def _axes(ax: Any) -> Any:
    try:
        import matplotlib.pyplot as pyplot  # type: ignore[import]
    except ImportError as error:
        raise ImportError("plots need matplotlib: pip install matplotlib, or apt install python3-matplotlib") from error
    return ax if ax is not None else pyplot.subplots()[1]


def plot(result: Result, names: tuple[str, ...], ax: Any = None) -> Any:
    """Columns over time, or a map over the two axes of a grid."""
    ax, columns, axes = _axes(ax), result.columns(), result.axes()
    key = next((name for name in ("t", "omega", "mode", "member") if name in columns), "")
    chosen = [column for name in names for column in columns if column == name or column.startswith(f"{name}_")]
    unknown = [name for name in names if not any(column == name or column.startswith(f"{name}_") for column in columns)]
    if unknown:
        raise ValueError(f"there is no column {', '.join(unknown)}: choose from {', '.join(columns)}")
    chosen = chosen or [column for column in columns if column not in (key, "member", "status")]
    if not names and chosen:
        first = chosen[0].rstrip("0123456789")
        chosen = [column for column in chosen if column.rstrip("0123456789") == first]
    if len(axes) == 2 and len(columns.get("member", ())) == np.prod([len(values) for values in axes.values()]):
        (x_name, x), (y_name, y) = axes.items()
        mesh = ax.pcolormesh(x, y, columns[chosen[0]].reshape(len(y), len(x)), shading="nearest")
        ax.figure.colorbar(mesh, label=_label(chosen[0]))
        ax.set(xlabel=_label(x_name), ylabel=_label(y_name))
        return ax
    x = columns.get(key, np.arange(len(columns[chosen[0]])))
    for column in chosen:
        ax.plot(x, columns[column], "." if key in ("mode", "member") else "-", label=column)
    ax.set(xlabel=_label(key), ylabel=_label(chosen[0].rstrip("0123456789").rstrip("_")) if len({unit_of(c.rstrip("_0123456789")) for c in chosen}) == 1 else "")
    ax.legend()
    return ax


def _label(name: str) -> str:
    unit = unit_of(name.rstrip("0123456789").rstrip("_"))
    return f"{name} ({unit})" if unit else name


def frame(pendulum: Any, phi: Any, cart: float = 0.0, size: int = 300) -> Any:
    """The pendulum at angles phi on a cart at `cart`, m, as (size, size, 3) bytes."""
    ax = _axes(None)
    import matplotlib.pyplot as pyplot
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # type: ignore[import]
    begin, end = _arms(pendulum, phi)
    reach = 1.1 * pendulum._lists()[0].sum()
    for a, b in zip(begin, end):
        ax.plot([a.real + cart, b.real + cart], [a.imag, b.imag], "-", color="#445566", linewidth=2)
    ax.plot(end.real + cart, end.imag, "o", color="#cc6600")
    ax.plot([cart], [0], "s", color="#222222")
    ax.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    figure = ax.figure
    figure.set_size_inches(size / 100, size / 100)
    figure.set_dpi(100)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())[..., :3].copy()
    pyplot.close(figure)
    return pixels


def animate(result: Result, speed: float = 1, ax: Any = None) -> Any:
    """Animates the result of a `run` with phi or theta, 25 frames per second."""
    from .pendulum import Pendulum
    if "pendulum" not in result.request or "t" not in result or not ("phi" in result or "theta" in result):
        raise ValueError("an animation needs the result of run(...) with phi or theta")
    ax = _axes(ax)
    from matplotlib.animation import FuncAnimation  # type: ignore[import]
    pendulum = Pendulum(client=object(), **result.request["pendulum"])  # type: ignore[arg-type]
    phi = result["phi"] if "phi" in result else result["theta"] - np.pi / 2
    t = result["t"]
    begin, end = _arms(pendulum, phi)
    if "cart_x" in result:
        begin, end = begin + result["cart_x"][:, None], end + result["cart_x"][:, None]
    count = max(2, min(5000, round(abs(t[-1] - t[0]) / speed * 25)))
    frames = np.searchsorted(t, np.linspace(t[0], t[-1], count)).clip(0, len(t) - 1) if t[-1] > t[0] else np.arange(len(t))
    reach = 1.1 * max(np.abs(end).max(), 1e-300)
    ax.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    lines = [ax.plot([], [], "-", color="#445566", linewidth=2)[0] for _ in range(phi.shape[1])]
    bobs, = ax.plot([], [], "o", color="#cc6600")
    clock = ax.text(0.02, 0.96, "", transform=ax.transAxes)

    def draw(row: int) -> list[Any]:
        for k, line in enumerate(lines):
            line.set_data([begin[row, k].real, end[row, k].real], [begin[row, k].imag, end[row, k].imag])
        bobs.set_data(end[row].real, end[row].imag)
        clock.set_text(f"{t[row]:.2f} s")
        return [*lines, bobs, clock]
    return FuncAnimation(ax.figure, draw, frames=frames, interval=40, blit=True)
