"""Clients, pendulums and jobs for asyncio: the same methods as coroutines.

Leaves to others: the methods. Invariant: a coroutine that is cancelled closes its connection, which ends the computation.
"""
from __future__ import annotations

import asyncio
import contextvars
import functools
import threading
from collections.abc import AsyncIterator
from typing import Any

from .client import Job, _task


class Async:
    """A client, a pendulum or a job whose methods are coroutines."""

    def __init__(self, target: Any) -> None:
        self._target = target

    def __repr__(self) -> str:
        return f"{self._target!r}.aio"

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._target, name)
        if not callable(value) or (name == "request" and not isinstance(self._target, Job)):
            return value
        run: Any = _steps if name in ("stream", "jobs", "members") else _thread
        return functools.partial(run, value)


async def _thread(function: Any, *arguments: Any, **fields: Any) -> Any:
    task: Any = threading.Event()
    task.connection = None
    context = contextvars.copy_context()
    context.run(_task.set, task)
    call: Any = functools.partial(context.run, function, *arguments, **fields)
    work: Any = asyncio.get_running_loop().run_in_executor(None, call)
    try:
        found = await asyncio.shield(work)
    except asyncio.CancelledError:
        task.set()
        socket = task.connection and task.connection.sock
        if socket:
            socket.shutdown(2)
        work.add_done_callback(lambda done: done.cancelled() or done.exception())
        raise
    return Async(found) if hasattr(found, "aio") else found


async def _steps(function: Any, *arguments: Any, **fields: Any) -> AsyncIterator[Any]:
    end: Any = object()
    iterator = await _thread(function, *arguments, **fields)
    while (item := await _thread(next, iterator, end)) is not end:
        yield item
