"""Load over loopback: the daemon beside its peers, one core for the server and one for the client.

usage: load.py BUILD [PART-OF-A-NAME...]     (make load, make load T=csv)
Every line is one measurement: name, ours, the peer's, their ratio, what is asked of it, unit. Contenders take turns,
the best of their turns counts, so that a slow spell of the machine hits none alone; p50, p99, errors and memory stand
below. A line fails when answers are wrong, when requests get no answer, or when memory does not stay put; of a ratio
that is short of what is asked it only says so, as clocks of a shared machine prove nothing.

Leaves to others: servers and clients (servers.py, client.c, post.lua), the pieces without a socket (make bench).
Invariant: traffic stays on loopback; what was started ends.
"""
import contextlib
import http.client
import json
import pathlib
import random
import sys
import tempfile
import threading
import time

import jobs
import kept
from servers import CLIENT_CORE, SERVER_CORE, TOP, client, daemon, finish, message, nginx, saying_port, tool, wrk

BUILD = sys.argv[1] if len(sys.argv) > 1 else "build/release"
PEER = TOP / BUILD / "tests/bench/service/service"
TURNS, SECONDS = 5, 2
NO_CACHE = ("--cache-bytes", "0")
QUIET = ("--access-log", "off")

TREE = '"pendulum":{"L":[2,1.5,0.75,1.25],"m":[1,1,1,0.1],"S":[[1,0,0,0],[1,1,0,0],[1,1,1,0],[1,1,0,1]]}'
PAPER = f'{{{TREE},"times":{{"start":0,"stop":5,"step":0.01}},"rtol":1e-11,"output":["phi","phid"]}}'
PAPER_6 = PAPER[:-1] + ',"digits":6}'
DOUBLE = '"pendulum":{"length":[1,1],"mass":[1,1],"parent":[0,1]}'
LITTLE = f"{{{DOUBLE}}}"
TYPES = {"json": None, "csv": "text/csv", "ndjson": "application/x-ndjson", "octets": "application/octet-stream",
         "npz": "application/x-npz", "mat": "application/x-matlab-data"}

failures = 0
rows = []


def chain(arms, stop, count=5):
    """A long computation with a short answer."""
    parents = ",".join(str(i) for i in range(arms))
    ones = ",".join("1" for _ in range(arms))
    return (f'{{"pendulum":{{"length":[{ones}],"mass":[{ones}],"parent":[{parents}]}},'
            f'"times":{{"start":0,"stop":{stop},"count":{count}}},"rtol":1e-12}}')


# --- the table ---

def row(name, ours, peer, ratio, asked, unit, more=""):
    line = f"{name:<34} {ours:>12} {peer:>12} {ratio:>9} {asked:>8}  {unit}"
    print(line + (f"\n    {more}" if more else ""), flush=True)
    rows.append(line)


def fail(text):
    global failures
    failures += 1
    print(f"FAIL {text}", flush=True)


def skip(name, why):
    print(f"skip {name}: {why}", flush=True)


def ratio_row(name, ours, peer, asked, unit, more=""):
    ratio = ours / peer if peer else float("inf")
    short = "" if ratio >= asked else "   (short)"
    row(name, f"{ours:.1f}", f"{peer:.1f}", f"{ratio:.2f}x", f"{asked:g}x" if asked else "-", unit + short, more)


def told(best, errors):
    """Below a ratio: latencies, errors, memory, and the processor time of a request, which a busy machine disturbs least."""
    text = "\n    ".join(f"{name}: {f['us']:.1f} us of processor a request, p50 {f['p50']:.2f} p99 {f['p99']:.2f} "
                        f"longest {f['longest']:.1f} ms, {errors[name]} errors, {f['memory'] / 1e6:.0f} MB"
                        for name, f in best.items())
    ours, peer = best.values()
    return f"{text}\n    by processor time {peer['us'] / ours['us']:.2f}x"


# --- accuracy ---

def reference():
    lines = (TOP / "tests/golden/paper_example.txt").read_text().splitlines()
    return [[float(word) for word in line.split()] for line in lines if not line.startswith("#")]


def error_of(body):
    """The largest difference of phi and phid from the reference, at all its instants."""
    answer, golden = json.loads(body), reference()
    if len(answer["t"]) != 501 or len(golden) != 51:
        raise ValueError("rows are missing")
    return max(abs(answer[name][10 * i][k] - golden[i][1 + 4 * column + k])
               for i in range(51) for column, name in enumerate(("phi", "phid")) for k in range(4))


# --- contenders ---

def compare(contenders, seconds=SECONDS, turns=TURNS):
    """name -> (server, body file, accept, path); returns name -> figures of its best turn, and errors of all."""
    best, errors = {}, dict.fromkeys(contenders, 0)
    for server, body, accept, path in contenders.values():
        wrk(server, body, accept, 1, path=path)
    for _ in range(turns):
        for name, (server, body, accept, path) in contenders.items():
            before = server.cpu()
            figures = wrk(server, body, accept, seconds, path=path) | {"memory": server.memory()}
            figures["us"] = 1e6 * (server.cpu() - before) / max(figures["requests"], 1)
            errors[name] += figures["errors"] + figures["late"]
            least = min(figures["us"], best.get(name, figures)["us"])
            if name not in best or figures["rate"] > best[name]["rate"]:
                best[name] = figures
            best[name]["us"] = least
    for name, count in errors.items():
        if count:
            fail(f"{name}: {count} errors or late answers")
    return best, errors


def file_of(directory, name, text):
    path = pathlib.Path(directory, name)
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def peers(directory):
    """The paper's example as JSON against the plain C service and Node.js."""
    body = file_of(directory, "paper.json", PAPER)
    with contextlib.ExitStack() as stack:
        ours = stack.enter_context(daemon(BUILD, *NO_CACHE))
        contenders = {"ours": (ours, body, None, None)}
        contenders["C"] = (stack.enter_context(saying_port([PEER])), body, None, None)
        if tool("node"):
            script = TOP / "tests/bench/service/service.js"
            contenders["node"] = (stack.enter_context(saying_port([tool("node"), script])), body, None, None)
        else:
            skip("json against Node.js", "nodejs is not installed")
        errors = {}
        for name, (server, *_) in contenders.items():
            status, _, answer = server.ask(PAPER)
            errors[name] = error_of(answer)
            if status != 200 or (name != "node" and errors[name] > 1e-9):
                fail(f"{name}: status {status}, off by {errors[name]:.2e}")
            print(f"    {name}: {len(answer)} bytes, off the reference by {errors[name]:.2e}")
        best, wrong = compare(contenders)
    for name, asked in (("C", 15), ("node", 24)):
        if name in best:
            ratio_row(f"paper's example, JSON, against {name}", best["ours"]["rate"], best[name]["rate"], asked, "requests/s",
                      told({"ours": best["ours"], name: best[name]}, wrong))


def representations(directory):
    """The same in other representations, against JSON."""
    full, short = file_of(directory, "paper.json", PAPER), file_of(directory, "paper6.json", PAPER_6)
    asked = {"digits 6": 1.3, "octets": 2, "npz": 2, "mat": 0, "csv": 0, "ndjson": 0}
    with daemon(BUILD, *NO_CACHE) as ours:
        contenders = {"json": (ours, full, None, None), "digits 6": (ours, short, None, None)}
        contenders |= {name: (ours, full, accept, None) for name, accept in TYPES.items() if accept}
        for name, (server, body, accept, _) in list(contenders.items()):
            status, headers, answer = server.ask(body.read_bytes(), accept)
            print(f"    {name}: status {status}, {len(answer)} bytes, {headers.get('Content-Type')}")
            if status != 200:
                skip(f"{name} against JSON", f"it is answered {status}")
                del contenders[name]
        best, wrong = compare(contenders, turns=4)
    for name, figures in best.items():
        if name != "json":
            ratio_row(f"{name} against JSON", figures["rate"], best["json"]["rate"], asked[name], "requests/s",
                      told({name: figures, "json": best["json"]}, wrong))


NGINX_FILE = """worker_processes 1;
pid @DIR@/pid;
error_log /dev/null;
events { worker_connections 1024; }
http {
    access_log off;
    sendfile on;
    @PUSH@
    keepalive_requests 100000000;
    open_file_cache max=10 inactive=600s;
    default_type application/json;
    client_body_temp_path @DIR@/a;
    proxy_temp_path @DIR@/b;
    fastcgi_temp_path @DIR@/c;
    uwsgi_temp_path @DIR@/d;
    scgi_temp_path @DIR@/e;
    server { listen 127.0.0.1:@PORT@; root @DIR@; }
}
"""


def cache(directory):
    """The same from the cache, against nginx that serves the same bytes from a file, in the faster of two ways."""
    body = file_of(directory, "paper.json", PAPER)
    if not tool("nginx"):
        skip("cached against nginx", "nginx is not installed")
        return
    with contextlib.ExitStack() as stack:
        try:
            ours = stack.enter_context(daemon(BUILD, "--cache-bytes", "64M", *QUIET))
        except RuntimeError as error:
            skip("cached against nginx", f"there is no cache: {error}")
            return
        _, headers, first = ours.ask(PAPER)
        _, _, second = ours.ask(PAPER)
        if first != second:
            fail("a cached answer is not the first one")
        contenders = {"ours": (ours, body, None, None)}
        for name, push in (("nginx", ""), ("nginx, tcp_nopush", "tcp_nopush on;")):
            static = stack.enter_context(nginx(NGINX_FILE.replace("@PUSH@", push)))
            file_of(static.files, "paper.json", first)
            if static.ask(path="/paper.json")[2] != first:
                fail("nginx does not serve the file")
            contenders[name] = (static, "-", None, "/paper.json")
        best, wrong = compare(contenders)
    faster = max((name for name in best if name != "ours"), key=lambda name: best[name]["rate"])
    ratio_row(f"from the cache, against {faster}", best["ours"]["rate"], best[faster]["rate"], 0.7, "requests/s",
              f"{len(first)} bytes, ETag {headers.get('ETag')}\n    " + told({"ours": best["ours"], faster: best[faster]}, wrong))


# --- memory ---

def read_through(port, body, accept):
    """POSTs and reads the answer to its end; returns how many bytes came, the last of them, and the seconds (0: refused)."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=600)
    connection.request("POST", "/v1/trajectories", body, {"Content-Type": "application/json", "Accept": accept})
    reply, count, begin = connection.getresponse(), 0, time.monotonic()
    if reply.status != 200:
        return reply.status, reply.read(2000), 0
    tail = b""
    while piece := reply.read1(1 << 18):
        count, tail = count + len(piece), (tail + piece)[-200:]
    connection.close()
    return count, tail, time.monotonic() - begin


def csv(directory):
    """A CSV of ten million samples, about 1 GB: what the server holds of it while it goes out."""
    samples = 10_000_000
    body = f'{{{DOUBLE},"times":{{"start":0,"stop":10000,"count":{samples}}},"output":["phi","phid"]}}'
    with daemon(BUILD, *NO_CACHE, "--max-samples", samples, "--max-compute-seconds", "600") as ours:
        ours.ask(LITTLE, path="/v1/trees")
        time.sleep(0.2)
        idle, most, over = ours.memory(), 0, threading.Event()
        result = []
        reader = threading.Thread(target=lambda: (result.extend(read_through(ours.port, body, "text/csv")), over.set()))
        reader.start()
        while not over.wait(0.05):
            most = max(most, ours.memory())
        reader.join()
    count, tail, seconds = result
    if not seconds:
        skip("CSV of ten million samples", f"status {count}: {tail[:300]}")
        return
    lines = tail.decode().splitlines()
    good = len(lines[-1].split(",")) == 5 and abs(float(lines[-1].split(",")[0]) - 10000) < 1e-9
    if not good or count < 5e8:
        fail(f"the CSV ends with {lines[-1]!r} after {count} bytes")
    above = (most - idle) / 1e6
    row("CSV of ten million samples", f"{above:.1f}", "64.0", "", "< 64", "MB above idle" + ("" if above < 64 else "   (short)"),
        f"{count / 1e9:.2f} GB in {seconds:.1f} s, idle {idle / 1e6:.1f} MB, at most {most / 1e6:.1f} MB")
    if above >= 64:
        fail("the CSV lies in memory")


def soak(directory):
    """A million mixed requests: resident memory has to be flat."""
    count = 1_000_000
    small = f'{{{DOUBLE},"times":{{"start":0,"stop":1,"step":0.1}}}}'
    mix = {
        "trees": (message("/v1/trees", LITTLE), 200), "health": (message("/healthz"), 200), "ready": (message("/readyz"), 200),
        "small": (message("/v1/trajectories", small), 200),
        "csv": (message("/v1/trajectories", small, "Accept: text/csv\r\n"), 200),
        "forces": (message("/v1/forces", f'{{{DOUBLE},"state":{{"phi":[1,2]}}}}'), 200),
        "modes": (message("/v1/modes", LITTLE), 200), "presets": (message("/v1/presets"), 200),
        "none": (message("/nowhere"), 404), "method": (message("/v1/trees", method="DELETE"), 405),
        "no-json": (message("/v1/trees", "{"), 400), "unknown": (message("/v1/trees", f'{{{DOUBLE},"x":1}}'), 422),
        "type": (message("/v1/trajectories", small, "Accept: image/png\r\n"), 406),
        "chunked": (b"POST /v1/trees HTTP/1.1\r\nHost: x\r\nContent-Type: application/json\r\nTransfer-Encoding: chunked\r\n"
                    b"\r\n%x\r\n%s\r\n0\r\n\r\n" % (len(LITTLE), LITTLE.encode()), 200),
    }
    files = [f"{file_of(directory, name, data)}={status}" for name, (data, status) in mix.items()]
    with daemon(BUILD) as ours:
        client(BUILD, ours, files, "--requests", count // 10, "--connections", "32", "--close-every", "50", seconds=600)
        memory = [ours.memory()]
        begin, figures, stalls = time.monotonic(), {}, 0
        for turn in range(10):
            figures = client(BUILD, ours, files, "--requests", count // 10, "--connections", "32", "--close-every", "50",
                             "--leave-every", "997", "--seed", turn, "--slow-ms", "1000", seconds=600)
            stalls += figures["stalls"]
            memory.append(ours.memory())
            if figures["wrong"] or figures["broken"] or figures["refused"]:
                fail(f"soak: {figures}")
        seconds = time.monotonic() - begin
        code = ours.stop()
    grown = (memory[-1] - memory[2]) / 1e6
    row(f"{count} mixed requests", f"{grown:+.2f}", "", "", "flat", "MB grown since the first fifth",
        f"{count / seconds:.0f} requests/s, MB: " + " ".join(f"{m / 1e6:.1f}" for m in memory) + f", {stalls} times nobody was answered for 1 s, ended with {code}")
    if grown > 1 or code:
        fail("memory grows, or the end was not clean")


# --- fairness ---

def batch(directory):
    """p99 of the paper's example alone, and while eight batch clients saturate the server."""
    paper = file_of(directory, "paper.http", message("/v1/trajectories", PAPER))
    # each another computation: the same would be computed once for all
    heavy = [f"{file_of(directory, f'heavy{i}.http', message('/v1/trajectories', chain(60, 20 + i / 1000)))}=0" for i in range(48)]
    for where, spread in (("each from its own address", ["--spread"]), ("all from one address", [])):
        alone, beside = [], []
        with daemon(BUILD, *NO_CACHE, *QUIET) as ours:
            for _ in range(TURNS):
                alone.append(client(BUILD, ours, [paper], "--connections", "1"))
                eight = client(BUILD, ours, heavy, "--connections", "8", *spread, seconds=4.0, wait=False)
                time.sleep(0.7)
                beside.append(client(BUILD, ours, [f"{paper}=0"], "--connections", "1"))
                finish(eight)
        quiet, busy = min(alone, key=lambda f: f["p99"]), min(beside, key=lambda f: f["p99"])
        ratio = busy["p99"] / quiet["p99"]
        row(f"p99 beside 8 batch clients, {where}"[:58], f"{busy['p99']:.2f}", f"{quiet['p99']:.2f}", f"{ratio:.2f}x", "< 5x",
            "ms" + ("" if ratio < 5 else "   (short)"),
            f"alone {quiet['rate']:.0f}/s p50 {quiet['p50']:.2f}, beside {busy['rate']:.0f}/s p50 {busy['p50']:.2f} "
            f"longest {busy['longest']:.1f} ms, wrong {busy['wrong']}")


def drips(directory):
    """Healthy clients' throughput while 2000 connections are open, half of them dripping, over that without them."""
    trees = file_of(directory, "trees.http", message("/v1/trees", LITTLE))
    paper = file_of(directory, "paper.http", message("/v1/trajectories", PAPER))
    slow = ("--drip", "1000", "--idle", "1000")
    for name, text in (("small requests", trees), ("the paper's example", paper)):
        without, beside = [], []
        with daemon(BUILD, *NO_CACHE, *QUIET) as ours:
            for turn in range(2 * TURNS):
                for figures, more in ((without, ()), (beside, slow))[:: 1 - turn % 2 * 2]:
                    before = ours.cpu()
                    figures.append(client(BUILD, ours, [text], *more))
                    figures[-1]["us"] = 1e6 * (ours.cpu() - before) / max(figures[-1]["requests"], 1)
        if not all(f["requests"] for f in without + beside):
            fail(f"2000 open, half dripping: {name}: nobody was answered for a whole turn")
            continue
        free, held = max(without, key=lambda f: f["rate"]), max(beside, key=lambda f: f["rate"])
        pairs = sorted(b["rate"] / w["rate"] for w, b in zip(without, beside))
        if any(f["wrong"] or f["broken"] or f["refused"] for f in without + beside):
            fail("healthy clients got no answer")
        ratio = held["rate"] / free["rate"]
        row(f"2000 open, half dripping: {name}", f"{held['rate']:.0f}", f"{free['rate']:.0f}", f"{ratio:.3f}", "> 0.9",
            "requests/s" + ("" if ratio > 0.9 else "   (short)"),
            f"p99 {held['p99']:.2f} against {free['p99']:.2f} ms, by processor time "
            f"{min(f['us'] for f in without) / min(f['us'] for f in beside):.3f}, pairs " + " ".join(f"{p:.2f}" for p in pairs))


# --- requests that are a burden ---

def hostile(directory):
    """Bodies of the largest size that take longest to be read and checked: processor time of one."""
    del directory
    size = 8 << 20
    random.seed(1)
    matrix = ",".join(f"[{','.join(random.choices('01', k=2000))}]" for _ in range(2000))
    ones = ",".join(["1"] * 2000)
    keys = ",".join(f'"{"a" * 29}{k:03}":1' for k in range(250))
    one = '{"pendulum":{"L":[1],"m":[1],"S":[[1]]},'

    def filled(field, item, count):
        return f'{one}"{field}":[{",".join([item] * count)}]}}'

    bodies = {
        "a matrix of random digits": ("/v1/trees", f'{{"pendulum":{{"L":[{ones}],"m":[{ones}],"S":[{matrix}]}}}}'),
        "many states": ("/v1/forces", filled("states", '{"phi":[1],"phid":[2],"unit":"deg"}', 74000)),
        "objects with many keys": ("/v1/forces", filled("states", f"{{{keys}}}", 900)),
        "zeros": ("/v1/trajectories", filled("times", "0", size // 2 - 100)),
        "words": ("/v1/trajectories", filled("times", '"abcdefghijklmnopqrstuvwx"', 299000)),
    }
    for name, (path, body) in bodies.items():
        with daemon(BUILD, *NO_CACHE, *QUIET, "--max-answer-bytes", "1M", path=path) as ours:
            ours.ask(body)
            least = min(seconds_of(ours, body, 5) for _ in range(3))
        row(f"8 MB: {name}", f"{1e3 * least:.0f}", "", "", "< 150", "ms of processor" + ("" if least < 0.15 else "   (short)"),
            f"{len(body)} bytes")


def seconds_of(server, body, count):
    before = server.cpu()
    for _ in range(count):
        server.ask(body)
    return (server.cpu() - before) / count


def school(directory):
    """Thirty ask for the same run of some megabytes at once: processor time over that of one."""
    del directory
    bodies = [f'{{{DOUBLE},"times":{{"start":0,"stop":{400 + i},"count":100001}},"output":["phi","phid"]}}' for i in range(6)]
    accept, times = TYPES["octets"], []
    with daemon(BUILD, *QUIET) as ours:
        for body in bodies:
            before, answers = ours.cpu(), []
            count = 1 if len(times) % 2 == 0 else 30
            threads = [threading.Thread(target=lambda: answers.append(ours.ask(body, accept)[2])) for _ in range(count)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            times.append((ours.cpu() - before, len(answers[0])))
            if len(answers) != count or any(answer != answers[0] for answer in answers):
                fail("the same request has several answers")
    one, all_of_them = min(t for t, _ in times[::2]), min(t for t, _ in times[1::2])
    row("thirty ask the same at once", f"{1e3 * all_of_them:.0f}", f"{1e3 * one:.0f}", f"{all_of_them / one:.2f}x", "-",
        "ms of processor, sending included", f"{times[0][1]} bytes each")


LINES = {"peers": peers, "representations": representations, "cache": cache, "csv": csv, "batch": batch, "drips": drips,
         "hostile": hostile, "school": school, "soak": soak}
# those of jobs write into the same table
LINES |= {name: lambda directory, line=line: line(sys.modules[__name__]) for name, line in (jobs.LINES | kept.LINES).items()}


def main():
    wanted = sys.argv[2:]
    if SERVER_CORE == CLIENT_CORE:
        print("there is one core only: server and client share it, the ratios say little")
    if not tool("wrk") or not tool("taskset"):
        sys.exit("this needs wrk and taskset: docker/install.sh load")
    print(f"{'':<34} {'ours':>12} {'peer':>12} {'ratio':>9} {'asked':>8}")
    for name, line in LINES.items():
        if wanted and not any(word in name for word in wanted):
            continue
        with tempfile.TemporaryDirectory(prefix="pendulumd-load-") as directory:
            line(directory)
    print("\n" + "\n".join(rows), flush=True)
    sys.exit(failures > 0)


if __name__ == "__main__":
    main()
