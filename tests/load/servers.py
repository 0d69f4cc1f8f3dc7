"""Servers under load: started on a core of their own and a free port of loopback, looked at, and ended.

Leaves to others: what they are asked (load.py, drills). Invariant: a server that was started here is gone when its block is.
"""
import contextlib
import json
import os
import pathlib
import random
import shutil
import signal
import socket
import subprocess
import tempfile
import time
import urllib.error
import urllib.request

TOP = pathlib.Path(__file__).resolve().parents[2]
os.environ.setdefault("PENDULUMD_ALLOW_ROOT", "on")  # tests may be root in a container
PATH = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"
CORES = sorted(os.sched_getaffinity(0))
SERVER_CORE, CLIENT_CORE = CORES[0], CORES[-1]


def tool(name):
    """The path of a program, or None."""
    return shutil.which(name, path=PATH)


def pinned(core, command):
    return ["taskset", "-c", str(core)] + [str(word) for word in command]


class Server:
    """A process that listens on 127.0.0.1:port."""

    def __init__(self, process, port, path="/", files=None):
        self.process, self.port, self.path, self.files = process, port, path, files

    @property
    def url(self):
        return f"http://127.0.0.1:{self.port}{self.path}"

    def processes(self):
        """The process and its children."""
        pids = [str(self.process.pid)]
        for pid in pids:
            with contextlib.suppress(OSError):
                for task in os.listdir(f"/proc/{pid}/task"):
                    pids += pathlib.Path(f"/proc/{pid}/task/{task}/children").read_text().split()
        return pids

    def memory(self):
        """Resident bytes."""
        total = 0
        for pid in self.processes():
            with contextlib.suppress(OSError):
                for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
                    total += 1024 * int(line.split()[1]) if line.startswith("VmRSS:") else 0
        return total

    def cpu(self):
        """Seconds of processor used so far, of all threads, those that have ended as well; /proc has them in ticks only."""
        total = 0
        for pid in self.processes():
            with contextlib.suppress(OSError):
                total += time.clock_gettime((~int(pid) << 3) | 2)  # clock_getcpuclockid(3)
        return total

    def ask(self, body=None, accept=None, path=None, seconds=60):
        """Status, header fields and bytes of one answer."""
        headers = {"Content-Type": "application/json"} | ({"Accept": accept} if accept else {})
        url = f"http://127.0.0.1:{self.port}{path or self.path}"
        request = urllib.request.Request(url, body.encode() if isinstance(body, str) else body, headers)
        try:
            with urllib.request.urlopen(request, timeout=seconds) as reply:
                return reply.status, reply.headers, reply.read()
        except urllib.error.HTTPError as error:
            return error.code, error.headers, error.read()

    def stop(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        try:
            return self.process.wait(30)
        except subprocess.TimeoutExpired:
            self.process.kill()
            return self.process.wait()


@contextlib.contextmanager
def running(process, port, path="/", files=None):
    server = Server(process, port, path, files)
    try:
        yield server
    finally:
        server.stop()


def daemon(build, *options, path="/v1/trajectories", core=SERVER_CORE):
    """pendulumd with its request lines thrown away."""
    store = () if "--store" in options else ("--store", "none")
    command = pinned(core, [TOP / build / "pendulumd", "--listen", "127.0.0.1:0", *store, *options])
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    said = [process.stderr.readline()]
    while said[-1] and "listening on" not in said[-1]:  # on PostgreSQL it says first how many workers that carries
        said.append(process.stderr.readline())
    if not said[-1]:
        raise RuntimeError(f"pendulumd {' '.join(map(str, options))}: {''.join(said)}")
    return running(process, int(said[-1].rsplit(":", 1)[1]), path)


def saying_port(command, core=SERVER_CORE):
    """A peer that says its port on standard output."""
    process = subprocess.Popen(pinned(core, command), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    return running(process, int(process.stdout.readline()))


def free_port():
    """A port below those that the system gives to whoever asks for any: nobody gets it meanwhile."""
    while True:
        port = random.randrange(10000, 32000)
        with socket.socket() as probe, contextlib.suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port


@contextlib.contextmanager
def nginx(config, core=SERVER_CORE, path="/", ready="/"):
    """nginx with a configuration in which @PORT@ and @DIR@ stand for its port and a directory of its own."""
    with tempfile.TemporaryDirectory(prefix="pendulumd-nginx-") as directory:
        port = free_port()
        file = pathlib.Path(directory, "nginx.conf")
        file.write_text(config.replace("@PORT@", str(port)).replace("@DIR@", directory))
        os.chmod(directory, 0o755)
        # a pipe that nobody empties would stop nginx at its next message
        said = pathlib.Path(directory, "said")
        with said.open("w") as out:
            process = subprocess.Popen(pinned(core, [tool("nginx"), "-p", directory, "-c", file, "-g", "daemon off;"]), stderr=out)
        with running(process, port, path, pathlib.Path(directory)) as server:
            end = time.monotonic() + 120
            while True:
                try:
                    with socket.create_connection(("127.0.0.1", port), 1):
                        break
                except OSError:
                    if process.poll() is not None or time.monotonic() > end:
                        raise RuntimeError(f"nginx: {said.read_text()}") from None
                    time.sleep(0.01)
            yield server


def wrk(server, body="-", accept=None, seconds=2, connections=8, path=None):
    """Figures of one run of wrk on its own core; body is a file, or - for GET."""
    url = f"http://127.0.0.1:{server.port}{path or server.path}"
    command = pinned(CLIENT_CORE, ["wrk", "-t1", f"-c{connections}", f"-d{seconds}s", "-s", TOP / "tests/load/post.lua", url, "--", body])
    out = subprocess.run(command + ([accept] if accept else []), capture_output=True, text=True, timeout=60 + seconds)
    for line in out.stdout.splitlines():
        if line.startswith("figures "):
            figures = json.loads(line[8:])
            return figures | {"rate": figures["requests"] / figures["seconds"]}
    raise RuntimeError(f"wrk: {out.stdout}{out.stderr}")


def client(build, server, messages, *options, seconds=2.0, core=CLIENT_CORE, wait=True):
    """Figures of one run of tests/load/client; messages are files with raw requests."""
    command = pinned(core, [TOP / build / "tests/load/client", "--port", server.port, "--seconds", seconds, *options, *messages])
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    return finish(process) if wait else process


def finish(process):
    out, _ = process.communicate(timeout=3600)
    return json.loads(out)


def message(path, body=None, headers="", method=None):
    """A raw request."""
    head = f"{method or ('POST' if body is not None else 'GET')} {path} HTTP/1.1\r\nHost: localhost\r\n{headers}"
    if body is None:
        return f"{head}\r\n".encode()
    data = body.encode() if isinstance(body, str) else body
    return f"{head}Content-Type: application/json\r\nContent-Length: {len(data)}\r\n\r\n".encode() + data
