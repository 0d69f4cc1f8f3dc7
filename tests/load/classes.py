"""Classes under load: rooms of pupils who each change their stage now and then, and hear what their teacher shows.

usage: classes.py BUILD [sqlite|postgres] [ROOMS [PUPILS [SECONDS]]]     (40 rooms of 30 for 15 s)
Prints how long a write took, how long a pupil's change took to the teacher's stream, and how long what the teacher showed
took to the pupils' streams: in ms, the median and what 99 of 100 were below; and fails where a change did not come.
Leaves to others: daemons and stores (tests/drill). Invariant: traffic stays on loopback; each room has an address of its
own there, as schools have.
"""
import asyncio
import contextlib
import json
import random
import resource
import sys
import tempfile
import time

from servers import TOP

sys.path.append(str(TOP / "tests/drill"))
from house import Daemon  # noqa: E402
from places import place  # noqa: E402

PAUSE = 6  # s between two changes of a pupil's, on average
SHOWN = 3  # s between two things that a teacher shows
OPTIONS = ("--max-connections", "8000", "--max-event-streams", "4000", "--access-log", "off")


def scene(angle):
    return {"request": {"pendulum": {"length": [1, 1], "mass": [1, 1], "parent": [0, 1]}, "initial": {"theta": [angle, 0]},
                        "times": {"start": 0, "stop": 10, "count": 101}}}


class Line:
    """A connection that is kept, from an address of a room's own."""

    def __init__(self, port, address):
        self.port, self.address, self.reader, self.writer = port, address, None, None

    async def open(self):
        self.reader, self.writer = await asyncio.open_connection("127.0.0.1", self.port, limit=1 << 22, local_addr=(self.address, 0))

    async def send(self, method, path, token, body=None, more=""):
        if not self.writer:
            await self.open()
        data = b"" if body is None else json.dumps(body).encode()
        head = f"{method} {path} HTTP/1.1\r\nHost: 127.0.0.1\r\n{more}"
        head += f"Authorization: Bearer {token}\r\n" if token else ""
        head += f"Content-Type: application/json\r\nContent-Length: {len(data)}\r\n" if data else ""
        self.writer.write(head.encode() + b"\r\n" + data)
        await self.writer.drain()
        return (await self.reader.readuntil(b"\r\n\r\n")).decode()

    async def ask(self, method, path, token=None, body=None):
        head = await self.send(method, path, token, body)
        fields = dict(line.lower().split(": ", 1) for line in head.splitlines()[1:] if ": " in line)
        data = await self.reader.readexactly(int(fields.get("content-length", 0)))
        status = int(head.split()[1])
        if status >= 300:
            raise RuntimeError(f"{method} {path}: {status} {data.decode()}")
        return json.loads(data) if data else None


class Room:
    """A teacher and pupils, and what became of their changes."""

    def __init__(self, number, ports):
        self.address, self.ports = f"127.0.{1 + number // 200}.{1 + number % 200}", ports
        self.number, self.sent, self.shown, self.tasks = number, {}, {}, []
        self.writes, self.board, self.pushes, self.expected = [], [], [], 0

    def port(self, i):
        return self.ports[(self.number + i) % len(self.ports)]

    async def hear(self, i, token, role):
        """Listens for as long as the room is there."""
        line = Line(self.port(i), self.address)
        head = await line.send("GET", f"{self.path}/events", token)
        if " 200 " not in head:
            raise RuntimeError(head)
        while text := await line.reader.readline():
            if text.startswith(b"data:{\""):
                self.heard(role, json.loads(text[5:]), time.perf_counter())

    def heard(self, role, item, now):
        kind, _, name = item["name"].partition("/")
        value = item["value"] or {}
        if role == "teacher" and kind == "stages" and name != "class" and "scene" in value:
            sent = self.sent.pop(value["scene"]["request"]["initial"]["theta"][0], None)
            if sent:
                self.board.append(now - sent)
        if role == "pupil" and name == "class" and value:
            self.pushes.append(now - self.shown[value["release"]["number"]])

    async def begin(self, pupils):
        self.line = Line(self.port(0), self.address)
        room = await self.line.ask("POST", "/v1/classes", None, {"hours": 1})
        self.path, self.token, self.pupils = f"/v1/classes/{room['code']}", room["token"], []
        self.tasks.append(asyncio.create_task(self.hear(0, self.token, "teacher")))
        for i in range(pupils):
            line = Line(self.port(i), self.address)
            while True:
                with contextlib.suppress(RuntimeError):  # 100 may join at once and then 10 a second
                    pupil = await line.ask("POST", f"{self.path}/pupils", None, {"nickname": f"pupil {i}"})
                    break
                await asyncio.sleep(0.5)
            self.pupils.append((line, pupil["token"]))
            self.tasks.append(asyncio.create_task(self.hear(i, pupil["token"], "pupil")))

    async def work(self, line, token, until):
        await asyncio.sleep(random.random() * PAUSE)
        while (now := time.perf_counter()) < until:
            angle = random.random()
            self.sent[angle] = now
            body = {"scene": scene(angle), "state": random.choice(("working", "stuck", "done"))}
            await line.ask("PUT", f"{self.path}/stages/own", token, body)
            self.writes.append(time.perf_counter() - now)
            await asyncio.sleep(PAUSE * (0.5 + random.random()))

    async def teach(self, until):
        for number in range(1, 1000):
            await asyncio.sleep(SHOWN)
            if time.perf_counter() > until:
                return
            self.shown[number] = time.perf_counter()
            self.expected += len(self.pupils)
            await self.line.ask("PUT", f"{self.path}/stages/class", self.token, {"frozen": bool(number % 2), "release": {"number": number}})

    async def lesson(self, seconds):
        until = time.perf_counter() + seconds
        await asyncio.gather(self.teach(until), *(self.work(line, token, until) for line, token in self.pupils))


def told(name, times):
    times = sorted(1e3 * t for t in times)
    print(f"{name:8} {len(times):6} times, median {times[len(times) // 2]:7.1f} ms, 99 of 100 {times[int(0.99 * len(times))]:7.1f} ms, most {times[-1]:7.1f} ms")


async def classes(ports, rooms, pupils, seconds):
    all_rooms = [Room(number, ports) for number in range(rooms)]
    begun = time.perf_counter()
    await asyncio.gather(*(room.begin(pupils) for room in all_rooms))
    print(f"{rooms} rooms of {pupils} were joined in {time.perf_counter() - begun:.1f} s")
    await asyncio.sleep(1)
    await asyncio.gather(*(room.lesson(seconds) for room in all_rooms))
    await asyncio.sleep(2)
    for name in ("writes", "board", "pushes"):
        told(name, [one for room in all_rooms for one in getattr(room, name)])
    lost = sum(len(room.sent) for room in all_rooms)
    late = sum(room.expected - len(room.pushes) for room in all_rooms)
    for room in all_rooms:
        await room.line.ask("DELETE", room.path, room.token)
    for task in (task for room in all_rooms for task in room.tasks):
        task.cancel()
    print(f"{lost} changes did not reach the board, {late} things that were shown did not reach a pupil")
    return lost + late


def main(build, kind="sqlite", rooms="40", pupils="30", seconds="15"):
    resource.setrlimit(resource.RLIMIT_NOFILE, (resource.getrlimit(resource.RLIMIT_NOFILE)[1],) * 2)
    with tempfile.TemporaryDirectory(prefix="pendulumd-load-") as logs, place(kind) as store, contextlib.ExitStack() as stack:
        daemons = [Daemon(TOP / build, store.url, "all", logs, ("--workers", "1", *OPTIONS)) for _ in range(1 if kind == "sqlite" else 2)]
        for daemon in daemons:
            stack.callback(daemon.kill, 15)
        return 1 if asyncio.run(classes([daemon.port for daemon in daemons], int(rooms), int(pupils), float(seconds))) else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
