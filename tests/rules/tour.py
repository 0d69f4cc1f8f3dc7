"""Shows the way of one request through the rooms: the files that it visits and the public functions that it enters, in order.

usage: tour.py BUILD [--all] [--check]     (build/release, for pendulumd with the names of its functions)

Files stand in the order of their first visit, each with the first sentence of its header and what is entered in it; --all
shows every visit.

The request is the example of README.md, sent to a live server. Every public function of the program gets a breakpoint that
goes off once; what goes off before the request, on threads that wait, is not shown. --check holds the tour against the
rooms and counts.
Leaves to others: what the files are for in full (their READMEs and headers), order among includes (layers.sh).
Invariant: nothing here lists functions or files of the way; a program that goes another way has another tour.
"""
import contextlib
import ctypes
import os
import pathlib
import platform
import re
import signal
import struct
import subprocess
import sys
import textwrap
import threading
import time
import urllib.request

TOP = pathlib.Path(__file__).resolve().parents[2]
ROOMS = ("server", "api", "core")
SEIZE, CONT, GETREGS, SETREGS = 0x4206, 7, 12, 13  # of ptrace(2)
TRACECLONE, EVENT_STOP, WALL = 8, 128, 0x40000000
REGISTERS, RIP = 27 * 8, 16 * 8  # struct user_regs_struct of x86-64
QUIET = 1.0  # s in which threads that wait show what they do by themselves
libc = ctypes.CDLL(None, use_errno=True)
libc.ptrace.restype = ctypes.c_long
libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]


class Refused(Exception):
    """This machine does not let a process look at its child."""


def ptrace(request, task, data=None):
    if libc.ptrace(request, task, None, data) < 0:
        raise Refused(os.strerror(ctypes.get_errno()))


def public_functions(program):
    """Name and file by address of every public function of the rooms."""
    names = {}
    for line in subprocess.run(["nm", program], capture_output=True, text=True, check=True).stdout.splitlines():
        address, kind, name = line.rpartition(" ")[0].partition(" ")[0], line.split()[-2], line.split()[-1]
        if kind == "T" and re.match(r"(?:pend|api|srv)_|recv$", name):
            names[int(address, 16)] = name
    asked = "".join(f"{address:x}\n" for address in names)
    told = subprocess.run(["addr2line", "-e", program], input=asked, capture_output=True, text=True, check=True).stdout.splitlines()
    files = [os.path.normpath(line.rpartition(":")[0]) for line in told]
    return {address: (name, file) for (address, name), file in zip(names.items(), files) if file.startswith(ROOMS)}


class Traced:
    """A running process whose public functions are noticed when they are entered for the first time."""

    def __init__(self, process, functions):
        for task in os.listdir(f"/proc/{process}/task"):
            ptrace(SEIZE, int(task), TRACECLONE)
        maps = pathlib.Path(f"/proc/{process}/maps").read_text(encoding="ascii")
        base = int(maps.partition("-")[0], 16)
        if pathlib.Path(f"/proc/{process}/exe").read_bytes()[16] == 2:  # ET_EXEC: it lies where its file says
            base = 0
        self.process, self.functions = process, {base + address: function for address, function in functions.items()}
        self.memory = open(f"/proc/{process}/mem", "r+b", buffering=0)
        self.was = {address: self.byte(address) for address in self.functions}
        self.armed = set(self.functions)
        for address in self.functions:
            self.byte(address, b"\xcc")

    def byte(self, address, new=None):
        self.memory.seek(address)
        return self.memory.write(new) if new else self.memory.read(1)

    def entered(self, task):
        """The function at whose breakpoint a task stopped, which goes on from there; None if it was another's already."""
        registers = ctypes.create_string_buffer(REGISTERS)
        ptrace(GETREGS, task, registers)
        address = struct.unpack_from("Q", registers, RIP)[0] - 1
        if address not in self.functions:
            return None
        struct.pack_into("Q", registers, RIP, address)
        ptrace(SETREGS, task, registers)
        if address not in self.armed:
            return None
        self.armed.discard(address)
        self.byte(address, self.was[address])
        return self.functions[address]

    def watch(self, until):
        """(task, name, file) of the functions that are entered, in order, until a condition holds."""
        way = []
        while not until():
            task, status = os.waitpid(-1, os.WNOHANG | WALL)
            if not task:
                time.sleep(0.001)
            elif not os.WIFSTOPPED(status):
                if task == self.process:
                    raise SystemExit("FAIL the server ended\n0 passed, 1 failed")
            else:
                number = os.WSTOPSIG(status)
                function = self.entered(task) if number == signal.SIGTRAP and status >> 16 == 0 else None
                if function:
                    way.append((task, *function))
                ptrace(CONT, task, None if number == signal.SIGTRAP or status >> 16 == EVENT_STOP else number)
        return way

    def end(self):
        for address in self.armed:
            self.byte(address, self.was[address])
        self.memory.close()


def example():
    """Path and body of README.md's example."""
    text = (TOP / "README.md").read_text(encoding="utf-8")
    return re.search(r"curl -s http://[\d.:]+(/v1/trajectories)[^{]*'(\{.*?\})'\n```", text, re.S).groups()


def purpose(file):
    """The first sentence of the header that a file includes first, which is its own if it has one, or of the file's comment."""
    text = (TOP / file).read_text(encoding="utf-8")
    header = re.match(r'\s*#include "([^"]+)"', text)
    if header:
        text = (TOP / header[1]).read_text(encoding="utf-8")
    comment = re.match(r"/\* (.*?)\*/", text, re.S)
    return re.split(r"(?<=\.) |(?<=\.)$", " ".join(comment[1].replace("\n *", " ").split()))[0] if comment else ""


def tour(program):
    """The way of the example, and status and body of its answer."""
    functions = public_functions(program)
    server = subprocess.Popen([program, "--listen", "127.0.0.1:0", "--store", "none", "--workers", "1", "--access-log", "off"],
                              stderr=subprocess.PIPE, text=True)
    port, answer = None, []
    try:
        for line in server.stderr:  # ends with the server
            listening = re.search(r"127\.0\.0\.1:(\d+)", line)
            if listening:
                port = listening[1]
                break
        path, body = example()

        def ask():
            request = urllib.request.Request(f"http://127.0.0.1:{port}{path}", body.encode(), {"Content-Type": "application/json"})
            with urllib.request.urlopen(request, timeout=100) as response:
                answer.append((response.status, response.read()))

        traced = Traced(server.pid, functions)
        quiet = time.monotonic() + QUIET
        traced.watch(lambda: time.monotonic() > quiet)
        client = threading.Thread(target=ask, daemon=True)
        client.start()
        way = traced.watch(lambda: not client.is_alive())
        traced.end()
        tasks = list(dict.fromkeys(task for task, _, _ in way))
        return [(1 + tasks.index(task), name, file) for task, name, file in way], *(answer or [(0, b"")])[0]
    finally:
        server.kill()
        with contextlib.suppress(ChildProcessError):  # each thread that is looked at ends by itself
            while True:
                os.waitpid(-1, WALL)


def show(way, every):
    """A paragraph a file, or a visit of one: the thread, the file, what it is for, the functions that are entered."""
    visits = []
    for thread, name, file in way:
        seen = [visit for visit in (visits[-1:] if every else visits) if visit[:2] == (thread, file)]
        if not seen:
            seen = [(thread, file, [])]
            visits += seen
        seen[0][2].append(name)
    place = None
    for thread, file, names in visits:
        if (thread, file.partition("/")[0]) != place:
            place = (thread, file.partition("/")[0])
            print(f"\n{place[1]}, thread {thread}")
        print(f"  {file}" if every else f"  {file}: {purpose(file)}")
        print(textwrap.fill(", ".join(names), 116, initial_indent="      ", subsequent_indent="      "))


def check(way, status, body):
    """Complaints about a tour: where it went and in which order the rooms were met, and what was answered."""
    rooms = [file.partition("/")[0] for _, _, file in way]
    order = list(dict.fromkeys(rooms))
    files = {room: len({file for _, _, file in way if file.startswith(room)}) for room in ROOMS}
    yield "the answer is 200 and has the motion", status == 200 and body.startswith(b'{"t":[0,0.01,'), f"{status} {body[:80]}"
    yield "the rooms are met from the server down to the core", order == list(ROOMS), order
    sockets = [file for thread, _, file in way if thread == 1]
    yield "the sockets' thread computes nothing", not any(file.startswith("core/") for file in sockets), sockets
    yield "each room shows three files or more", min(files.values()) >= 3, files
    yield "it passes over the sockets' thread and a worker", max((thread for thread, _, _ in way), default=0) >= 2, len(way)
    yield "each of its files says what it is for", all(purpose(file) for _, _, file in way), [f for _, _, f in way if not purpose(f)]


def main():
    program = str(TOP / sys.argv[1] / "pendulumd")
    if platform.machine() != "x86_64":
        print("skip tour: its breakpoints are those of x86-64\n0 passed, 0 failed, 1 skipped")
        return 0
    try:
        way, status, body = tour(program)
    except (Refused, PermissionError) as error:
        print(f"skip tour: this machine lets no process look at its child: {error}\n0 passed, 0 failed, 1 skipped")
        return 0
    show(way, "--all" in sys.argv)
    if "--check" not in sys.argv:
        return 0
    results = list(check(way, status, body))
    for what, good, detail in results:
        if not good:
            print(f"FAIL {what}: {detail}")
    failed = sum(not good for _, good, _ in results)
    print(f"{len(results) - failed} passed, {failed} failed")
    return failed > 0


if __name__ == "__main__":
    sys.exit(main())
