"""A pendulum in a notebook that can be dragged: the page's stage in a frame, by anywidget's protocol.

    from pendulumd.widget import Stage
    stage = Stage(Pendulum([1, 1], [1, 1], [0, 1]), theta=[2, 1])     # the last line of a cell
    stage.request["initial"]                                          # after a drag, the new start

Leaves to others: the frame (widget.js), the page at `url` (a server, or the folder of `make site` on a web host). Invariant: `scene`, `time` and
`playing` are what the frame shows. Needs anywidget.
"""
from __future__ import annotations

import pathlib
from typing import Any, Optional

import anywidget  # type: ignore[import]
import traitlets  # type: ignore[import]

from .pendulum import Pendulum, times_of


class Stage(anywidget.AnyWidget):  # type: ignore[misc]
    """The page's stage with a pendulum; times and the start as of `Pendulum.run`. url: of the page, by default the pendulum's server."""

    _esm = pathlib.Path(__file__).with_name("widget.js")
    url = traitlets.Unicode().tag(sync=True)
    height = traitlets.Int(420).tag(sync=True)
    scene = traitlets.Dict().tag(sync=True)
    time = traitlets.Float(0.0).tag(sync=True)
    playing = traitlets.Bool(True).tag(sync=True)

    def __init__(self, pendulum: Pendulum, times: Any = "0:20:0.01", url: Optional[str] = None, **start: Any) -> None:
        request = pendulum.request(times=times_of(times), **start)
        super().__init__(url=url or pendulum.client.url.geturl(), scene={"request": request})

    @property
    def request(self) -> dict[str, Any]:
        """The request of the motion on the stage."""
        return dict(self.scene["request"])

    @property
    def pendulum(self) -> Pendulum:
        """The pendulum on the stage."""
        return Pendulum(client=self.url, **self.request["pendulum"])
