"""Tests docker/nginx.conf in front of a live daemon: which requests pass, which nginx refuses, the address of the client, and
streams; docker/nginx.signin.conf: accounts of a sign-in service; and the systemd unit, by systemd-analyze.

usage: nginx.py BUILD
Leaves to others: the daemon's answers without a proxy (tests/wire). Invariant: the shipped configuration is used, except
for its port, its upstream and the paths of its files.
"""
import concurrent.futures
import contextlib
import hashlib
import http.client
import http.server
import io
import json
import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time

from names import Names
from rule import TOP, check, shipped_nginx, skip, summary
from servers import daemon, free_port, nginx, running, tool

DOUBLE = '"pendulum":{"length":[1,1],"mass":[1,1],"parent":[0,1]}'
LITTLE = f"{{{DOUBLE}}}"
ENSEMBLE = f'{{{DOUBLE},"duration":1,"grid":[{{"vary":"theta","arm":1,"start":0,"stop":1,"count":2}}],"observables":["final"]}}'
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
    check(f"{what}: web pages may read it", headers.get("Access-Control-Allow-Origin") == "*", list(headers.items()))
    try:
        document = json.loads(data)
    except ValueError:
        document = {}
    check(what, got == status and headers.get("Content-Type") == "application/problem+json" and document.get("status") == status
          and document.get("title") and document.get("detail"), f"{got} {headers.get('Content-Type')} {data[:200]}")


def frames(front):
    """The embed view may be framed by whom pendulumd says, the rest by nobody."""
    for path, own, policy in (("/?embed=1", None, "frame-ancestors *"), ("/?room=PK7TRA&embed=1", None, "frame-ancestors *"),
                              ("/", "DENY", "frame-ancestors 'none'"), ("/docs?embed=1", "DENY", "frame-ancestors 'none'")):
        _, headers, _ = ask(front, "GET", path)
        check(f"{path}: X-Frame-Options is {own}", headers.get("X-Frame-Options") == own, headers.get("X-Frame-Options"))
        check(f"{path}: {policy}", (headers.get("Content-Security-Policy") or "").endswith(policy), headers.get("Content-Security-Policy"))


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
        status, _, data = ask(front, "QUERY", "/v1/trees", LITTLE, JSON | {"If-None-Match": headers["ETag"]})
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
    status, _, data = say(front, b"GET /healthz HTTP/1.0\r\n\r\n")
    check("HTTP/1.0 may leave Host away", status == 200, f"{status} {data[:200]}")
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


def at_once(front, count, path="/healthz", token=None, method="GET"):
    """Answers to so many requests of one client that are sent in one piece."""
    fields = f"Authorization: Bearer {token}\r\n" if token else ""
    one = f"{method} {path} HTTP/1.1\r\nHost: localhost\r\n{fields}\r\n".encode()
    with socket.create_connection(("127.0.0.1", front.port), PATIENCE) as connection:
        sender = threading.Thread(target=connection.sendall, daemon=True,
                                  args=(one * (count - 1) + one.replace(b"localhost\r\n", b"localhost\r\nConnection: close\r\n", 1),))
        sender.start()
        came = Bytes(b"".join(iter(lambda: connection.recv(1 << 16), b"")))
        sender.join()
    replies = []
    for _ in range(count):
        reply = http.client.HTTPResponse(came, method=method)
        reply.begin()
        replies.append((reply.status, reply.headers, reply.read()))
    return replies


def refusals(answers):
    return [answer for answer in answers if answer[0] == 429]


def token(number):
    return hashlib.sha256(str(number).encode()).hexdigest()


def page_files(front):
    """The page's documents and the files that it names."""
    html = ask(front, "GET", "/")[2].decode()
    return ["/", "/docs", "/openapi.json", *sorted({f"/{file}" for file in re.findall(r'(?:href|src)="(page/[^"]+)"', html)})[:3]]


def a_class(front):
    """Thirty browsers behind one address, as the configuration is shipped: they come at once, and all of them drag an arm."""
    for path in page_files(front):
        answers = at_once(front, 600, path, method="HEAD")
        check(f"{path} is never limited", {answer[0] for answer in answers} == {200}, {answer[0] for answer in answers})
    with concurrent.futures.ThreadPoolExecutor(30) as pool:
        answers = [answer for some in pool.map(lambda pupil: at_once(front, 60, "/v1/presets", token(pupil)), range(30)) for answer in some]
    check("thirty clients of one address with sixty requests each pass", {answer[0] for answer in answers} == {200},
          f"{len(refusals(answers))} of {len(answers)} are refused")


def crowd(port):
    """What is refused and how, with limits that even a slow machine reaches."""
    slow = [("rate=100r/s", "rate=1r/s"), ("rate=3000r/s", "rate=2r/s"), ("burst=200 ", "burst=20 "), ("burst=3000 ", "burst=100 ")]
    with nginx(shipped_nginx([port], changes=slow)) as front:
        check("no client has asked too much", not refusals(at_once(front, 20, token=token(1))))
        late = refusals(at_once(front, 40, token=token(1)))
        check("one client asks too much", len(late) >= 20, len(late))
        for answer in late[:2]:
            problem("one too many", answer, 429)
            check("it says when to come again", answer[1].get("Retry-After") == "1", answer[1].get("Retry-After"))
            check("the page may read that", "Retry-After" in (answer[1].get("Access-Control-Expose-Headers") or ""), list(answer[1].items()))
        check("another client of that address is not touched", not refusals(at_once(front, 10, token=token(2))))
        check("what browsers ask before a request counts for nobody", not refusals(at_once(front, 60, token=token(1), method="OPTIONS")))
        check("without a token the address is the client", refusals(at_once(front, 60)))
        check("a token that is too short is none", refusals(at_once(front, 5, token="short")))
        many = [answer for pupil in range(3, 13) for answer in at_once(front, 20, token=token(pupil))]
        check("an address has a limit too", refusals(many))


def networks(port):
    """Two addresses of one IPv6 network are one client, those of another network and of IPv4 are not."""
    changes = [("rate=100r/s", "rate=1r/s"), ("burst=200 ", "burst=20 "),
               ("    server {", "    set_real_ip_from 127.0.0.1;\n    real_ip_header X-Test-Address;\n\n    server {")]
    with nginx(shipped_nginx([port], changes=changes)) as front:
        def asks(address):
            return [ask(front, "GET", "/healthz", headers={"X-Test-Address": address})[0] for _ in range(16)]
        check("an IPv6 address asks", 429 not in asks("2001:db8:1:2::1"))
        check("its network is the client", 429 in asks("2001:db8:1:2:ffff::a"))
        check("another network is another one", 429 not in asks("2001:db8:1:3::1"))
        check("an IPv4 address is itself", 429 not in asks("192.0.2.1") and 429 not in asks("192.0.2.2"))


@contextlib.contextmanager
def daemon_at(build, address, log):
    """pendulumd behind a proxy on this machine, its log in a file."""
    command = [TOP / build / "pendulumd", "--listen", address, "--store", "none", "--trusted-proxy", "127.0.0.1/32"]
    with log.open("w") as out:
        process = subprocess.Popen(command, stdout=out, stderr=subprocess.PIPE, text=True)
    with running(process, int(process.stderr.readline().rsplit(":", 1)[1])) as back:
        yield back


def addresses(build, directory):
    """Processes that come, go and have other addresses are found by their name; nobody notices."""
    port, names = free_port(), Names("127.0.0.2")

    def asks():
        return [ask(front, "POST", "/v1/trees", LITTLE)[0] for _ in range(20)]

    def all_pass(what):
        answers = asks()
        check(what, set(answers) == {200}, answers)

    def until(name):
        """Asks until the process of this log has answered; every answer has to be good."""
        end, log, answers = time.monotonic() + PATIENCE, pathlib.Path(directory, name), []
        while '"target":"/v1/trees"' not in log.read_text() and time.monotonic() < end:
            answers += asks()
        check(f"the process of {name} is found", '"target":"/v1/trees"' in log.read_text())
        check("nobody notices meanwhile", set(answers) <= {200}, set(answers))

    first, second = (daemon_at(build, f"127.0.0.{number}:{port}", pathlib.Path(directory, f"{number}.log")) for number in (2, 3))
    with nginx(shipped_nginx([port], names, [("rate=100r/s", "rate=9000r/s"), ("rate=3000r/s", "rate=9000r/s")])) as front:
        with first:
            all_pass("one address")
            with second:
                names.addresses = ["127.0.0.2", "127.0.0.3"]
                until("3.log")
            all_pass("one of two is gone, its name is not yet")
            names.addresses = ["127.0.0.2"]
        with daemon_at(build, f"127.0.0.4:{port}", pathlib.Path(directory, "4.log")):
            names.addresses = ["127.0.0.4"]
            end = time.monotonic() + PATIENCE
            while (status := ask(front, "GET", "/healthz")[0]) == 503 and time.monotonic() < end:
                pass  # its address is not known yet
            check("the only one has another address", status == 200, status)
            until("4.log")
    names.close()


class Outdated(Names):
    """Knows of nobody alive while it is asked for the first two times."""

    def __init__(self, gone, there):
        self.gone, self.there = [gone], [there]
        super().__init__()

    @property
    def addresses(self):
        return self.gone if self.asked <= 2 else self.there

    @addresses.setter
    def addresses(self, _):
        """The two lists say it."""


def third_round(build, directory):
    """The memories of two rounds may both be older than the last restart: the third asks anew."""
    port, names = free_port(), Outdated("127.0.0.2", "127.0.0.3")
    with daemon_at(build, f"127.0.0.3:{port}", pathlib.Path(directory, "third.log")), nginx(shipped_nginx([port], names)) as front:
        status = ask(front, "POST", "/v1/trees", LITTLE)[0]
        check("two rounds know nobody alive, the third does", (status, names.asked) == (200, 3), (status, names.asked))
    names.close()


def never_twice():
    """A POST that was sent to a process that then dies is sent to nobody else; a GET is."""
    with socket.create_server(("127.0.0.1", 0)) as one, socket.create_server(("127.0.0.1", 0)) as other:
        seen = []

        def die(listener):
            with contextlib.suppress(OSError):
                while True:
                    connection, _ = listener.accept()
                    seen.append(connection.recv(1 << 16).split(b" ", 1)[0])
                    connection.close()

        for listener in (one, other):
            threading.Thread(target=die, args=(listener,), daemon=True).start()
        with nginx(shipped_nginx([listener.getsockname()[1] for listener in (one, other)])) as front:
            problem("a process dies after a POST", ask(front, "POST", "/v1/trees", LITTLE), 503)
            check("the POST was sent once", seen == [b"POST"], seen)
            problem("a process dies after a GET", ask(front, "GET", "/v1/presets"), 503)
            check("the GET was sent to both", seen == [b"POST", b"GET", b"GET"], seen)


def behind_nginx(build):
    if not tool("nginx"):
        skip("nginx", "nginx-light is not installed")
        return
    with tempfile.TemporaryDirectory() as directory:
        log = pathlib.Path(directory, "log")
        with daemon_at(build, "127.0.0.1:0", log) as back:
            with nginx(shipped_nginx([back.port])) as front:
                frames(front)
                passes(front, back)
                refused(front)
                clients(front, log)
                streams(front, back)
                a_class(front)
                crowd(back.port)
                networks(back.port)
                back.stop()
                answer = ask(front, "GET", "/healthz")
                problem("nobody behind", answer, 503)
                check("it says when to come again", answer[1].get("Retry-After") == "5", answer[1].get("Retry-After"))
        addresses(build, directory)
        third_round(build, directory)
        never_twice()


class SignIn(http.server.BaseHTTPRequestHandler):
    """A sign-in service as oauth2-proxy is one, for whoever has a cookie of NAME:ROLES."""

    def do_GET(self):
        name, _, roles = self.headers.get("Cookie", "").removeprefix("session=").partition(":")
        self.send_response(202 if name else 401)
        if name:
            self.send_header("X-Auth-Request-User", name)
            self.send_header("X-Auth-Request-Groups", roles)
        self.send_header("Content-Length", "0")
        self.end_headers()

    def log_message(self, *_):
        pass


def signed_in(build):
    """docker/nginx.signin.conf: accounts and roles are those that the sign-in service tells, whatever the client says."""
    if not tool("nginx"):
        return
    service = http.server.ThreadingHTTPServer(("127.0.0.1", 0), SignIn)
    threading.Thread(target=service.serve_forever, daemon=True).start()
    with tempfile.TemporaryDirectory() as directory:
        keys, later = f"{directory}/keys", JSON | {"Prefer": "respond-async"}
        subprocess.run([TOP / build / "pendulumd", "keys", "add", "--keys", keys, "--name", "any", "--role", "batch"],
                       check=True, capture_output=True)
        with daemon(build, "--store", f"sqlite:{directory}/store.db", "--trusted-proxy", "127.0.0.1/32", "--client-header", "X-Account",
                    "--keys", keys, "--role-header", "X-Roles") as back, \
                nginx(shipped_nginx([back.port], file="nginx.signin.conf", changes=[
                    ("signin:4180", f"127.0.0.1:{service.server_port}")])) as front:

            def asks(session, method="POST", path="/v1/ensembles", headers=later):
                said = {"Cookie": f"session={session}"} if session else {}
                status, _, data = ask(front, method, path, ENSEMBLE if method == "POST" else None, headers | said)
                return status, json.loads(data) if status in (200, 202) else {}

            def jobs(session, **headers):
                return len(asks(session, "GET", "/v1/jobs", headers)[1].get("jobs", ()))

            forged = {"X-Account": "ada", "X-Roles": "batch", "Authorization": "Bearer 0123456789abcdef0123456789abcdef"}
            check("nobody is served who has not signed in", asks("")[0] == 401)
            check("nor who says an account and roles", asks("", headers=later | forged)[0] == 401)
            check("an account with a role may keep jobs", asks("ada:batch")[0] == 202)
            check("a pupil may not", asks("bob:pupil")[0] == 403)
            check("nor one who says another role", asks("bob:pupil", headers=later | forged)[0] == 403)
            check("an account sees its jobs", jobs("ada:batch") == 1)
            check("and no other's", jobs("eve:batch") == 0)
            check("nor by saying its name", jobs("eve:batch", **forged) == 0)
    service.shutdown()


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
signed_in(sys.argv[1])
unit(sys.argv[1])
sys.exit(summary())
