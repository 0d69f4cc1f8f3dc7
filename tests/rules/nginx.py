"""docker/nginx.conf before a live daemon: what passes, what nginx refuses, who the client is, that streams stream; and
the systemd unit, read by systemd-analyze.

usage: nginx.py BUILD
Leaves to others: what the daemon says without a proxy (tests/wire). Invariant: the configuration is the one that is
shipped, but for its port, its upstream and the places of its files.
"""
import http.client
import io
import json
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import time

from rule import TOP, check, shipped_nginx, skip, summary
from servers import nginx, running, tool

DOUBLE = '"pendulum":{"length":[1,1],"mass":[1,1],"parent":[0,1]}'
LITTLE = f"{{{DOUBLE}}}"
PATIENCE = 120  # s for what comes by itself
JSON = {"Content-Type": "application/json"}


def ask(server, method, path, body=None, headers=JSON, source="127.0.0.1"):
    """Status, header fields and body."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE, source_address=(source, 0))
    connection.request(method, path, body, headers)
    reply = connection.getresponse()
    data = reply.read()
    connection.close()
    return reply.status, reply.headers, data


def say(server, text):
    """The same of raw bytes."""
    with socket.create_connection(("127.0.0.1", server.port), PATIENCE) as connection:
        connection.sendall(text)
        reply = http.client.HTTPResponse(connection)
        reply.begin()
        return reply.status, reply.headers, reply.read()


def once(what, headers):
    names = [name.lower() for name in headers.keys()]
    twice = sorted({name for name in names if names.count(name) > 1 and name not in ("set-cookie", "vary")})
    check(f"{what}: each header field once", not twice, twice)
    check(f"{what}: nosniff", headers.get("X-Content-Type-Options") == "nosniff", list(headers.items()))
    check(f"{what}: an id", re.fullmatch(r"[\w.-]{8,64}", headers.get("X-Request-Id") or ""), headers.get("X-Request-Id"))


def problem(what, answer, status):
    got, headers, data = answer
    once(what, headers)
    try:
        document = json.loads(data)
    except ValueError:
        document = {}
    check(what, got == status and headers.get("Content-Type") == "application/problem+json" and document.get("status") == status
          and document.get("title") and document.get("detail"), f"{got} {headers.get('Content-Type')} {data[:200]}")


def passes(front, back):
    for what, method, path, body, headers in (
            ("a POST", "POST", "/v1/trees", LITTLE, JSON), ("a GET", "GET", "/v1/presets", None, {}),
            ("a HEAD", "HEAD", "/v1/presets", None, {}), ("OPTIONS", "OPTIONS", "/v1/trees", None, {}),
            ("a query", "GET", "/v1/presets?a=b", None, {})):
        through, direct = ask(front, method, path, body, headers), ask(back, method, path, body, headers)
        check(f"{what} passes", through[0] == direct[0] and through[2] == direct[2], f"{through} is not {direct}")
        once(what, through[1])
    _, headers, _ = ask(front, "POST", "/v1/trees", LITTLE)
    if headers.get("ETag"):
        status, _, data = ask(front, "POST", "/v1/trees", LITTLE, JSON | {"If-None-Match": headers["ETag"]})
        check("304 passes", status == 304 and not data, status)
    for what, body, status in (("no JSON", "{", 400), ("an unknown field", f'{{{DOUBLE},"x":1}}', 422)):
        problem(f"{what}, refused by pendulumd", ask(front, "POST", "/v1/trees", body), status)
    problem("another type, refused by pendulumd", ask(front, "POST", "/v1/trees", LITTLE, {"Content-Type": "text/plain"}), 415)
    problem("a representation that nobody serves", ask(front, "POST", "/v1/trajectories", f'{{{DOUBLE},"times":[0,1]}}',
                                                       JSON | {"Accept": "image/png"}), 406)


def refused(front):
    problem("/metrics is for those inside", ask(front, "GET", "/metrics"), 404)
    problem("/readyz is for those inside", ask(front, "GET", "/readyz"), 404)
    problem("a body beyond the limit", ask(front, "POST", "/v1/trees", b" " * (9 << 20)), 413)
    problem("a target beyond the limit", ask(front, "GET", "/" + "a" * 9000), 414)
    problem("a field beyond the limit", ask(front, "GET", "/healthz", headers={"X": "a" * 9000}), 431)
    problem("no request line", say(front, b"GE(T / HTTP/1.1\r\nHost: x\r\n\r\n"), 400)
    problem("a target without a slash", say(front, b"GET healthz HTTP/1.1\r\nHost: x\r\n\r\n"), 400)
    problem("the page of a problem", ask(front, "GET", "/problem/404"), 404)
    problem("no Host", say(front, b"GET /healthz HTTP/1.1\r\n\r\n"), 400)
    problem("a length that is none", say(front, b"POST /v1/trees HTTP/1.1\r\nHost: x\r\nContent-Length: x\r\n\r\n"), 400)


def clients(front, log):
    """Who the client is, and the request's id, as the daemon's log has them."""
    lie = {"X-Forwarded-For": "203.0.113.7", "X-Real-IP": "203.0.113.8", "Forwarded": "for=203.0.113.9", "X-Request-Id": "drill-0001"}
    _, headers, _ = ask(front, "GET", "/healthz", headers=lie, source="127.0.0.77")
    check("the id comes back", headers.get("X-Request-Id") == "drill-0001", headers.get("X-Request-Id"))
    line, end = None, time.monotonic() + PATIENCE
    while not line and time.monotonic() < end:
        line = next((json.loads(text) for text in log.read_text().splitlines() if '"drill-0001"' in text), None)
        time.sleep(0.02)
    check("the client is nginx's, not the one that it says it is", line and line["client"] == "127.0.0.77", line)


def streams(front, back):
    """The first samples are there before the last are computed: who reads no further stops the computation."""
    body = f'{{{DOUBLE},"times":{{"start":0,"stop":300,"count":500001}}}}'
    connection = http.client.HTTPConnection("127.0.0.1", front.port, timeout=PATIENCE)
    connection.request("POST", "/v1/trajectories", body, JSON | {"Accept": "application/x-ndjson"})
    reply = connection.getresponse()
    reply.readline()
    time.sleep(2)
    computing = b"\npendulumd_computations 1\n" in ask(back, "GET", "/metrics")[2]
    lines = 1 + sum(1 for _ in iter(reply.readline, b""))
    connection.close()
    check("a stream passes whole", reply.status == 200 and lines in (500001, 500002), f"{reply.status}, {lines} lines")
    check("a stream passes at once", computing, "all of it was computed before it was read")


class Bytes(io.BytesIO):
    """What a connection brought, for one reply after the other to be read of."""

    def makefile(self, mode):
        return self

    def close(self):
        pass


def at_once(front, count):
    """Answers to so many requests that are sent in one piece."""
    one = b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n"
    with socket.create_connection(("127.0.0.1", front.port), PATIENCE) as connection:
        connection.sendall(one * (count - 1) + one.replace(b"x\r\n", b"x\r\nConnection: close\r\n"))
        came = Bytes(b"".join(iter(lambda: connection.recv(1 << 16), b"")))
    for _ in range(count):
        reply = http.client.HTTPResponse(came)
        reply.begin()
        yield reply.status, reply.headers, reply.read()


def crowd(front):
    """Four hundred requests at once: what the limit does not let through is told so."""
    time.sleep(4)  # the limit has forgotten what was asked before
    answers = list(at_once(front, 400))
    late = [answer for answer in answers if answer[0] != 200]
    check("some of 400 requests pass", len(answers) - len(late) >= 60, len(answers) - len(late))
    check("not all of them pass", len(late) >= 40, len(late))
    for answer in late[:3]:
        problem("one too many", answer, 429)
        check("it says when to come again", answer[1].get("Retry-After") == "1", answer[1].get("Retry-After"))


def behind_nginx(build):
    if not tool("nginx"):
        skip("nginx", "nginx-light is not installed")
        return
    with tempfile.TemporaryDirectory() as directory:
        log = pathlib.Path(directory, "log")
        command = [TOP / build / "pendulumd", "--listen", "127.0.0.1:0", "--store", "none", "--trusted-proxy", "127.0.0.1/32"]
        with log.open("w") as out:
            process = subprocess.Popen(command, stdout=out, stderr=subprocess.PIPE, text=True)
        port = int(process.stderr.readline().rsplit(":", 1)[1])
        with running(process, port) as back, nginx(shipped_nginx([port])) as front:
            passes(front, back)
            refused(front)
            clients(front, log)
            streams(front, back)
            crowd(front)
            back.stop()
            while (answer := ask(front, "GET", "/healthz"))[0] == 429:
                time.sleep(0.2)  # the limit lets some in again
            problem("nobody behind", answer, 503)
            check("it says when to come again", answer[1].get("Retry-After") == "5", answer[1].get("Retry-After"))


def unit(build):
    if not tool("systemd-analyze"):
        skip("the systemd unit", "systemd-analyze is not installed")
        return
    with tempfile.TemporaryDirectory() as prefix:
        pathlib.Path(prefix, "bin").mkdir()
        pathlib.Path(prefix, "bin/pendulumd").symlink_to(TOP / build / "pendulumd")
        file = pathlib.Path(prefix, "pendulumd.service")
        file.write_text((TOP / "docker/pendulumd.service").read_text().replace("@PREFIX@", prefix))
        run = subprocess.run(["systemd-analyze", "verify", "--man=no", file], capture_output=True, text=True)
        said = [line for line in (run.stdout + run.stderr).splitlines() if "pendulumd.service" in line]
        check("systemd-analyze verify", not run.returncode and not said, f"{run.returncode}: {run.stdout}{run.stderr}")


behind_nginx(sys.argv[1])
unit(sys.argv[1])
sys.exit(summary())
