"""Everything mixed for a time: memory, descriptors, threads, processes and files stay as many as they were.

usage: soak.py BUILD [--seconds N] [--at-once N]
So many clients at once choose among all kinds of requests: computations in all forms, faults, jobs that are awaited, cited, read in
pieces, heard of and dismissed, scenes, classrooms with their streams, the page, metrics, connections that end in the middle or say
what is no HTTP; meanwhile the daemon reads its files again. Figures are told twenty times.

Leaves to others: kills and faults (drill.py), right answers (the rooms' tests). Invariant: what is compared is after all kinds of
requests have come, and everything that was asked is answered as it should be.
"""
import argparse
import collections
import http.client
import json
import pathlib
import random
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

PATIENCE, KEPT = 120, 60  # s; the row of a job that was dismissed stays so long
TREE = '"pendulum":{"length":[1,1],"mass":[1,1],"parent":[0,1]}'
MOTION = f'{{{TREE},"initial":{{"theta":[1,2]}},"times":{{"stop":%s,"count":200}}%s}}'
GRID = f'{{{TREE},"duration":%s,"observables":["first_flip"],"grid":[{{"vary":"theta","arm":1,"start":-3,"stop":3,"count":%d}}]}}'
AXES = '{"vary":"theta","arm":%d,"start":-3,"stop":3,"count":6}'
PICTURE = f'{{{TREE},"duration":2,"observables":["first_flip"],"grid":[{AXES % 1},{AXES % 2}]}}'
SCENE = f'{{"request":{MOTION % (5, "")}}}'
FIT = (f'{{{TREE},"data":{{"t":[0,0.1,0.2,0.3,0.4,0.5],"series":[{{"theta":1,"values":[1,0.95,0.8,0.58,0.3,0]}}]}},'
       '"unknowns":[{"vary":"length","arm":1},{"vary":"theta","arm":1}],"iterations":5}')
ONE = {  # one request: path, body, header fields, status
    "modes": ("/v1/modes", f"{{{TREE}}}", {}, 200),
    "table": ("/v1/trajectories", MOTION % (3, ""), {"Accept": "text/csv", "Accept-Encoding": "zstd"}, 200),
    "HDF5": ("/v1/trajectories", MOTION % (3, ""), {"Accept": "application/x-hdf5"}, 200),
    "derivatives": ("/v1/trajectories", MOTION % (2, ',"derivatives":[{"vary":"length","arm":1}]'), {"Accept": "application/x-npz"}, 200),
    "extended": ("/v1/trajectories", MOTION % (0.1, ',"precision":"extended"'), {}, 200),
    "ensemble": ("/v1/ensembles", GRID % (5, 50), {"Accept": "application/x-ndjson"}, 200),
    "picture": ("/v1/ensembles", PICTURE, {"Accept": "image/png"}, 200),
    "exponents": ("/v1/lyapunov", f'{{{TREE},"duration":2,"samples":4,"count":3}}', {}, 200),
    "section": ("/v1/sections", f'{{{TREE},"initial":{{"theta":[1,2]}},"duration":3,"section":{{"arm":1,"theta":0}}}}', {}, 200),
    "response": ("/v1/response", f'{{{TREE},"drive":{{"pivot":{{"y":1}}}},"omega":[0,1],"poles":true}}', {}, 200),
    "fit": ("/v1/fits", FIT, {}, 200),
    "orbits": ("/v1/orbits", f'{{{TREE},"mode":1,"amplitude":0.2,"branch":true,"points":4}}', {}, 200),
    "equations": ("/v1/equations", f"{{{TREE}}}", {}, 200),
    "fault": ("/v1/trees", '{"pendulum":{"length":[1,-1]}}', {}, 422),
    "no JSON": ("/v1/trees", '{"pendulum"', {}, 400),
    "too long": ("/v1/trajectories", MOTION % ('1e7,"step":1e-9', ""), {}, 422),
    "a forged key": ("/v1/modes", f"{{{TREE}}}", {"Authorization": "Bearer pdk_aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa000000"}, 401),
    "page": ("/", None, {"Accept-Encoding": "gzip"}, 200),
    "description": ("/openapi.json", None, {}, 200),
    "metrics": ("/metrics", None, {}, 401),  # they are an operator's
    "nowhere": ("/v1/nowhere", None, {}, 404),
}


class Client:
    """Somebody with a connection of its own, which ends now and then."""

    def __init__(self, port, number):
        self.port, self.dice, self.line, self.last = port, random.Random(number), None, ""
        self.code, self.token = "", f"{self.dice.getrandbits(128):032x}"

    def ask(self, method, path, body=None, headers=None):
        if self.line and self.dice.random() < 0.2:
            self.line.close()
            self.line = None
        self.line = self.line or http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        fields = {"Content-Type": "application/json"} if body else {}
        fields |= {"Class-Token": self.token, "Authorization": f"Bearer {self.token}"}
        self.line.request(method, path, body, fields | (headers or {}))
        reply = self.line.getresponse()
        data = reply.read()
        self.last = f"{method} {path}: {reply.status} {data[:200]}"
        if reply.will_close:
            self.line.close()
            self.line = None
        return reply.status, data

    def one(self, kind):
        path, body, headers, status = ONE[kind]
        return self.ask("POST" if body else "GET", path, body, headers)[0] == status

    def submitted(self, path, body):
        status, data = self.ask("POST", path, body, {"Prefer": "respond-async"})
        return f"/v1/jobs/{json.loads(data)['id']}" if status == 202 else ""

    def job(self):
        """It is awaited, looked at in every way, and removed."""
        place = self.submitted("/v1/trajectories", MOTION % (5, ""))
        told = json.loads(self.ask("GET", f"{place}?wait=60")[1])["status"] == "successful" if place else False
        looks = [("/results", {"Accept": "text/csv", "Range": "bytes=0-99"}, 206), ("/results", {"Accept": "application/x-npz"}, 200),
                 ("/request", {}, 200), ("/events", {}, 200)]
        good = told and all(self.ask("GET", place + what, None, fields)[0] == status for what, fields, status in looks)
        return good and self.ask("GET", "/v1/jobs")[0] == 200 and self.ask("DELETE", place)[0] in (200, 204)

    def dismissed(self):
        """One of minutes that nobody wants any more."""
        place = self.submitted("/v1/ensembles", GRID % (500, 20000))
        time.sleep(self.dice.random() / 4)
        first = self.ask("DELETE", place)[0]
        return first in (200, 204) and self.ask("DELETE", place)[0] in (200, 204, 404)

    def gone(self):
        """The connection ends while it is computed."""
        line = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        line.request("POST", "/v1/trajectories", MOTION % (3000, ""), {"Content-Type": "application/json"})
        time.sleep(0.005)
        line.close()
        return True

    def noise(self):
        """What is no request, or not a whole one."""
        with socket.create_connection(("127.0.0.1", self.port), PATIENCE) as line:
            line.sendall(self.dice.choice((b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n", b"GET / HTTP/1.1\r\nHost:",
                                           b"POST /v1/trees HTTP/1.1\r\nHost: a\r\nContent-Length: 9\r\n\r\n{", b"")))
            time.sleep(0.01)
        return True

    def scene(self):
        status, data = self.ask("POST", "/v1/scenes", SCENE)
        place = f"/v1/scenes/{json.loads(data)['id']}" if status in (200, 201) else ""
        return bool(place) and self.ask("GET", place)[0] == 200 and self.ask("DELETE", place)[0] in (204, 404)

    def room(self):
        """A lesson in short: a question, its answer, a stream that is left, the table; rarely the room ends, since few may be made."""
        if not self.code:
            status, data = self.ask("POST", "/v1/classes", "{}")
            if status != 201:
                return False
            self.code = json.loads(data)["code"]
        place = f"/v1/classes/{self.code}"
        acts = [("PUT", "/questions/swing", '{"text":"How long?","kind":"number"}', 200), ("PUT", "/stages/class", f'{{"scene":{SCENE}}}', 200), ("GET", "", None, 200),
                ("GET", "/table", None, 200), ("GET", "/histograms/swing", None, 200)]
        good = all(self.ask(method, place + path, body)[0] in (status, 201) for method, path, body, status in acts)
        pupil = {"Class-Token": self.token[::-1]}
        good = good and self.ask("POST", f"{place}/pupils", '{"nickname":"Ada"}', pupil)[0] in (200, 201)
        good = good and self.ask("PUT", f"{place}/answers/swing", '{"value":2}', pupil)[0] in (200, 201)
        stream = http.client.HTTPConnection("127.0.0.1", self.port, timeout=PATIENCE)
        stream.request("GET", place + "/events", headers={"Class-Token": self.token})
        good = good and stream.getresponse().status == 200
        if self.dice.random() < 0.003:  # the stream is told
            good = self.ask("DELETE", place)[0] == 204 and good
            self.code = ""
        stream.close()
        return good


KINDS = [*ONE, "job", "dismissed", "gone", "noise", "scene", "room"]


def status(pid, name):
    line = next(line for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines() if line.startswith(name))
    return int(line.split()[1])


def family(pid):
    """A process with those that it has begun, and they."""
    lists = pathlib.Path(f"/proc/{pid}/task").glob("*/children")
    return 1 + sum(family(int(child)) for text in lists for child in text.read_text().split())


def figures(pid, place):
    """What must not grow."""
    proc = pathlib.Path(f"/proc/{pid}")
    return {"processes": family(pid), "descriptors": len(list((proc / "fd").iterdir())), "threads": status(pid, "Threads:"),
            "files": len(list(place.iterdir())), "kilobytes": status(pid, "VmRSS:"),
            "kilobytes of the store": sum(path.stat().st_size for path in place.glob("store.db*")) // 1024}


class Soak:
    """The daemon, and what its clients were told."""

    def __init__(self, build, directory):
        self.place, self.over, self.quiet = pathlib.Path(directory), threading.Event(), threading.Lock()
        self.counts, self.wrong, self.said, self.hands = collections.Counter(), collections.Counter(), {}, []
        command = [build / "pendulumd", "--listen", "127.0.0.1:0", "--store", f"sqlite:{directory}/store.db", "--cache-bytes", "1M",
                   "--allow-root", "on", "--keep-seconds", str(KEPT), "--keys", f"{directory}/keys", "--log", f"{directory}/log",
                   "--audit-log", f"{directory}/audit"]
        pathlib.Path(directory, "keys").write_text("role anonymous requests=none jobs=1000 compute=none\n")
        pathlib.Path(directory, "keys").chmod(0o600)
        self.daemon = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.port = int(self.daemon.stderr.readline().rsplit(":", 1)[1])

    def sits(self, number):
        """Asks until the end; holds still while figures are taken."""
        client = Client(self.port, number)
        while not self.over.is_set():
            kind = client.dice.choice(KINDS)
            with self.hands[number]:
                try:
                    good = client.one(kind) if kind in ONE else getattr(client, kind)()
                except (OSError, http.client.HTTPException) as error:
                    good, client.last = False, repr(error)
                    client.line = None
            with self.quiet:
                self.counts[kind] += 1
                if not good:
                    self.wrong[kind] += 1
                    self.said[kind] = client.last

    def still(self):
        """Figures while nobody asks for anything."""
        for hand in self.hands:
            hand.acquire()
        time.sleep(1)
        found = figures(self.daemon.pid, self.place)
        for hand in self.hands:
            hand.release()
        return found

    def run(self, seconds, at_once):
        """The figures after each of twenty parts; what was said on standard error is read away."""
        self.hands = [threading.Lock() for _ in range(at_once)]
        threads = [threading.Thread(target=self.sits, args=(i,)) for i in range(at_once)]
        threads.append(threading.Thread(target=self.daemon.stderr.read, daemon=True))
        for one in threads:
            one.start()
        told = []
        for _ in range(20):
            time.sleep(seconds / 20)
            self.daemon.send_signal(signal.SIGHUP)
            told.append(self.still())
            print(f"{sum(self.counts.values())} requests: {told[-1]}", flush=True)
        self.over.set()
        for one in threads[:-1]:
            one.join()
        self.daemon.terminate()
        return told, self.daemon.wait(PATIENCE)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=300)
    parser.add_argument("--at-once", type=int, default=4, help="clients")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="pendulumd-soak-") as directory:
        soak = Soak(asked.build, directory)
        told, left = soak.run(asked.seconds, asked.at_once)
    before, after = told[6], told[-1]
    print(f"{dict(soak.counts)}; before {before}, after {after}")
    most = {"processes": before["processes"], "descriptors": before["descriptors"] + 2, "threads": before["threads"], "files": before["files"] + 1,
            "kilobytes": 1.1 * before["kilobytes"] + 2048, "kilobytes of the store": 1.2 * before["kilobytes of the store"] + 8192}
    bad = [name for name in most if after[name] > most[name]] + (["the end"] if left else [])
    bad += [f"{kind}, {soak.wrong[kind]} of {soak.counts[kind]}: {soak.said.get(kind)}" for kind in KINDS if soak.wrong[kind] or not soak.counts[kind]]
    print("".join(f"FAIL {name}\n" for name in bad) + f"{len(most) + len(KINDS) + 1 - len(bad)} passed, {len(bad)} failed")
    sys.exit(bool(bad))


main()
