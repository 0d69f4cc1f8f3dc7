"""The command line against a live server and without one: its README, forms, jobs, trouble, completion, man page.

Leaves to others: whether `make install` puts it in place (tests/rules/install.sh). Invariant: it runs in a directory of its own.
"""
import fcntl
import json
import os
import pathlib
import re
import shutil
import signal
import stat
import subprocess
import time

import numpy as np

from clients import DOUBLE, FOUR, TOP, programs
from front import PAGE, Front
from rule import check, skip


def test_cli(server, home):
    build, work = pathlib.Path(os.environ["PENDULUM_BUILD"]), home / "cli"
    work.mkdir()
    os.environ["PATH"] = f"{build}:{os.environ['PATH']}"
    for name, tree in (("four", FOUR), ("double", DOUBLE), ("request", {"pendulum": DOUBLE, "times": [0, 1], "initial": {"theta": [0.1, 1 / 3]}})):
        (work / f"{name}.json").write_text(json.dumps(tree))

    def run(*words, status=0, url=None, **more):
        done = subprocess.run(["pendulum", *map(str, words)], cwd=work, capture_output=True, text=True, timeout=120,
                              env=os.environ | ({"PENDULUM_URL": url} if url else {}), **more)
        check(f"cli: {' '.join(map(str, words))}", done.returncode == status, f"{done.returncode}: {done.stdout[-300:]}{done.stderr}")
        return done.stdout if status == 0 else done.stderr

    test_answers(run, work, server)
    test_refusals(run, work, server)
    test_files(run, work)
    test_jobs(run, work, server)
    test_beside(run)
    programs("sh", ["sh", "-c"], folder="cli", home=work)
    return (work / "server.bin").read_bytes()


def test_answers(run, work, server):
    times = "0:5:0.01"
    run("run", "four.json", "--t", times, "-o", "server.bin")
    run("run", "four.json", "--t", times, "-o", "local.bin", "--local", url="http://127.0.0.1:1")
    check("cli: without a server the bytes are the same", (work / "server.bin").read_bytes() == (work / "local.bin").read_bytes())
    for words in (("--t", "0:5/501"), ("--t", times, "--server", os.environ["PENDULUM_URL"] + "/"), ("--t", times, "--phi", "0,0,0,0", "--phid", "0,0,0,0")):
        run("run", "four.json", *words, "-o", "other.bin")
        check(f"cli: {words} is the same", (work / "server.bin").read_bytes() == (work / "other.bin").read_bytes())
    for form in ("npz", "mat", "csv", "json", "ndjson"):
        run("run", "request.json", "-o", f"far.{form}")
        run("run", "request.json", "-o", f"near.{form}", "--local", url="http://127.0.0.1:1")
    far, near = np.load(work / "far.npz"), np.load(work / "near.npz")
    check("cli: arrays are the same", set(far.files) == {*near.files, "stats_compute_seconds"} and all(np.array_equal(far[n], near[n]) for n in near.files), far.files)
    check("cli: a number of the file keeps its bits", far["phi"][0, 1] == 1 / 3 - np.pi / 2 or abs(far["phi"][0, 1] - (1 / 3 - np.pi / 2)) < 1e-15)
    check("cli: CSV is the same", (work / "far.csv").read_text() == (work / "near.csv").read_text())
    run("run", "request.json", "-o", "./plain")
    check("cli: a file without an ending is CSV, in a directory too", (work / "plain").read_text() == (work / "far.csv").read_text())
    moved = json.loads(run("run", "request.json", "--t", "0,0.5,1", "--as", "json", "-s", "pendulum.gravity=1.62", "--method", "ode23", "--local"))
    check("cli: options replace fields of the file", moved["t"] == [0, 0.5, 1] and moved["stats"]["method"] == "ode23")
    for place in ((), ("--local",)):
        tree = json.loads(run("ask", "trees", "double.json", "-s", "pendulum.damping=[0.1,0.2]", *place))
        check(f"cli: fields of real pendulums {place}", tree["arms"][1]["damping"] == 0.2, tree)
        check(f"cli: equations {place}", "latex" in json.loads(run("ask", "equations", "double.json", *place)))
        fit = {"pendulum": {"length": [1], "mass": [1], "parent": [0]}, "unknowns": [{"vary": "length", "arm": 1}],
               "data": {"csv": "t,theta\n0,0.1\n0.2,0.081\n0.4,0.0313\n0.6,-0.0303\n0.8,-0.0803\n1,-0.1"}}
        check(f"cli: fits {place}", '"length"' in run("ask", "fits", "-", *place, input=json.dumps(fit)))
        (work / "track.csv").write_bytes("Zeit;Winkel (\xb0)\n0,0;5,7\n0,2;4,6\n0,4;1,8\n0,6;-1,7\n0,8;-4,6\n1,0;-5,7\n".encode("latin-1"))
        seen = json.loads(run("ask", "tables", "double.json", "-f", "track.csv", *place))["tables"][0]
        check(f"cli: tables {place}", [column["is"] for column in seen["columns"]] == ["t", "theta 1"] and seen["decimal"] == ",", seen)
        del fit["data"]
        check(f"cli: fits of a file {place}", '"length' in run("ask", "fits", "-", "--csv", "track.csv", *place, input=json.dumps(fit)))
        check(f"cli: a table where the route has one {place}", run("ask", "modes", "double.json", *place).startswith("mode,omega"))
        for form in ("bin", "csv", "npz"):
            done = subprocess.run(["pendulum", "run", "double.json", "--t", "0:20:0.1", "--theta", "2,2", "-o", f"warned.{form}", *place], cwd=work, capture_output=True, text=True)
            check(f"cli: a warning of {form} {place}", done.returncode == 0 and re.search(r"warning: .* t = 1[23]\.\d+ s", done.stderr), done.stderr)
    check("cli: standard input", json.loads(run("ask", "trees", "-", "--as", "json", input='{"length":[1],"mass":[1],"parent":[0]}'))["n"] == 1)
    for place in ((), ("--local",)):
        run("map", "double.json", "--x", "theta1:-3:3:20", "--y", "theta2:-3:3:30", "--duration", 5, "-o", "map.png", *place)
        head = (work / "map.png").read_bytes()[:24]
        check(f"cli: a map {place}", head[1:4] == b"PNG" and head[16:24] == bytes([0, 0, 0, 20, 0, 0, 0, 30]), head)
    check("cli: gravity is an axis without an arm", len(run("map", "double.json", "--x", "gravity:1:9:3", "--y", "theta2:-3:3:3", "--duration", 1).splitlines()) == 10)


def test_refusals(run, work, server):
    for status, words, text in ((3, ("run", "four.json", "--t", "0:5:0.01", "-s", "fruit=3"), "/fruit is not a known field"), (3, ("run", "four.json"), "422 1 error in the request: see errors\n  /times (--t) is missing"),
                        (3, ("run", "four.json", "--t", "0:5:0.01", "-s", "pendulum.fruit=x y", "--local"), "/pendulum/fruit is not a known field"),
                        (2, ("run", "four.json", "--t", "0:x:1"), "START:STOP:STEP"), (1, ("run", "none.json", "--t", "0:1:1"), "No such file"), (2, ("run", "four.json", "--t", "5"), "START:STOP:STEP"),
                        (2, ("run", "four.json", "--t", "0:1:1", "-o", "a.odd"), "unknown format odd"), (2, ("run", "four.json", "-s", "rtol"), "NAME=VALUE"),
                        (2, ("map", "double.json", "--x", "theta1:0:1", "--y", "theta2:0:1:3"), "is not an axis"), (2, ("map", "double.json"), "two axes"),
                        (2, ("map", "double.json", "--x", "theta1:0:inf:3", "--y", "theta2:0:1:3"), "is not an axis"), (3, ("map", "double.json", "--x", "theta9:0:1:3", "--y", "theta2:0:1:3"), "  /grid/0/arm (--x) "),
                        (2, ("run", "four.json", "--t", "0:nan:1"), "START:STOP:STEP"), (2, ("run", "four.json", "--t", "0,1", "--theta", "1,x"), "--theta takes numbers"),
                        (1, ("run", "four.json", "--t", "0:5:0.01", "-o", "/no/such/place.npz"), "No such file"), (3, ("ask", "fruit", "four.json"), "404"),
                        (2, ("ask", "fruit", "four.json", "--local"), "needs a server"), (3, ("get", "no-such-job"), "404"), (2, ("cancel", "a b"), "is not the id of a job"),
                        (2, ("get", "x", "--local"), "--local cannot run jobs"), (2, ("run", "four.json", "--t", "0:1:1", "--local", "--job"), "--local cannot run jobs"),
                        (4, ("run", "four.json", "--t", "0:1:1", "--server", "http://127.0.0.1:1", "--patience", 1e6, "-o", "none.npz"), "no server at http://127.0.0.1:1 ("),
                        (4, ("run", "four.json", "--t", "0:1:1", "--server", "file:///etc", "--patience", 0), "rotocol"),
                        (1, ("run", "-", "--t", "0:1:1"), "does not contain a JSON object")):
        said = run(*words, status=status, input="[1]")
        check(f"cli: {text}", text in said and "pendulum: " in said, said)
    check("cli: nothing is left of what was refused", not [one for one in work.iterdir() if ".part" in one.name])
    front = Front(server.port)
    front.moods = [PAGE]
    check("cli: another server", "answers with a web page" in run("modes", "four.json", url=front.url, status=4))
    front.close()
    for words, text in (((), "is needed: run, modes"), (("fruit",), "unknown command fruit"), (("run",), "run takes 1 argument, got 0"), (("ask", "modes"), "ask takes 2 arguments, got 1"), (("run", "four.json", "--fruit"), "see pendulum --help")):
        check(f"cli: usage of {words}", text in run(*words, status=2))
    for place in ((), ("--local",)):
        long = subprocess.Popen(["pendulum", "run", "double.json", "--t", "0:100:0.001", *place], cwd=work, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        long.stdout.readline()
        long.stdout.close()
        check(f"cli: a reader that goes away ends it in silence {place}", not long.stderr.read() and long.wait() in (141, -signal.SIGPIPE))


def test_files(run, work):
    """What `-o` may replace, and what it leaves as it is."""
    words = ("run", "double.json", "--local", "--t", "0:1:0.5", "--theta", "2,2")
    text = run(*words)
    for place in ("-", "/dev/stdout", "/dev/fd/1"):
        check(f"cli: {place} is standard output", run(*words, "-o", place) == text and not (work / "-").exists())
    (work / "appended").write_text("before\n")
    with open(work / "appended", "a") as file:
        subprocess.run(["pendulum", *words, "-o", "appended"], cwd=work, stdout=file)
    check("cli: a file that standard output appends to", (work / "appended").read_text() == "before\n" + text)
    os.mkfifo(work / "pipe")
    reader = subprocess.Popen(["cat", "pipe"], cwd=work, stdout=subprocess.PIPE, text=True)
    run(*words, "-o", "pipe")
    check("cli: a pipe stays one", reader.communicate(timeout=60)[0] == text and stat.S_ISFIFO((work / "pipe").stat().st_mode))
    run(*words, "-o", "/dev/null")
    check("cli: a device stays one", stat.S_ISCHR(os.stat("/dev/null").st_mode))
    (work / "deep").mkdir()
    target, link = work / "deep" / "target.csv", work / "link.csv"
    target.write_text("old")
    target.chmod(0o640)
    link.symlink_to("deep/target.csv")
    run(*words, "-o", "link.csv")
    check("cli: a link's target is replaced and keeps its mode", link.is_symlink() and target.read_text() == text and stat.S_IMODE(target.stat().st_mode) == 0o640)
    target.write_text("old")
    target.chmod(0o440)
    (work / "lost.csv").symlink_to("nowhere.csv")
    for place, word in (("link.csv", "is read-only"), ("lost.csv", "does not exist"), ("deep", "directory")):
        check(f"cli: {place} {word}", word in run(*words, "-o", place, status=1))
    check("cli: a read-only file is left", target.read_text() == "old" and not (work / "nowhere.csv").exists())
    both = [("run", "double.json", "--local", "--t", "0:40:0.001", "--theta", theta) for theta in ("1,1", "2,1")]
    whole = [run(*each) for each in both]
    for _ in range(3):
        running = [subprocess.Popen(["pendulum", *each, "-o", "both.csv"], cwd=work, stderr=subprocess.DEVNULL) for each in both]
        check("cli: two runs into one file leave one of the answers", [one.wait() for one in running] == [0, 0] and (work / "both.csv").read_text() in whole)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a check in the background ignores it, and so would the program
    long = subprocess.Popen(["pendulum", "run", "double.json", "--local", "--t", "0:20000:0.001", "--theta", "2,1", "-o", "long.csv"], cwd=work)
    while long.poll() is None and not list(work.glob("long.csv.part-*")):
        time.sleep(0.01)
    long.send_signal(signal.SIGINT)
    check("cli: an interrupted run leaves nothing", long.wait() == -signal.SIGINT and not list(work.glob("long.csv*")))
    check("cli: no temporary file is left", not list(work.rglob("*.part-*")))


def test_jobs(run, work, server):
    words = ("run", "four.json", "--t", "0:40:0.001")
    run(*words, "-o", "whole.npz")
    run(*words, "-o", "job.npz", "--job", "--key", "of-the-command-line")
    whole, job = np.load(work / "whole.npz"), np.load(work / "job.npz")
    check("cli: a job's results", all(np.array_equal(whole[name], job[name]) for name in ("t", "phi", "lambda")))
    found = run(*words, "--detach", "--key", "of-the-command-line").strip()
    check("cli: a key leads to the same job", re.fullmatch("[0-9a-z]{26}", found) and found in run("jobs"))
    named = run("run", "four.json", "--t", "0:1:1", "--detach", "--title", "größe % of it").strip()
    listed = run("jobs", "--title", "ße % OF").splitlines()
    check("cli: a title finds its job alone", len(listed) == 1 and listed[0].startswith(named) and listed[0].endswith("größe % of it"), listed)
    run("get", named, "-o", "job.h5")
    check("cli: HDF5", (work / "job.h5").read_bytes()[:4] == b"\x89HDF")
    check("cli: no job is of that state", not run("jobs", "--title", "ße % OF", "--status", "failed"))
    run("get", found, "-o", "again.npz")
    data = (work / "again.npz").read_bytes()
    check("cli: get brings the same bytes", data == (work / "job.npz").read_bytes())
    front = Front(server.port)
    # each line of the front takes the next mood: the job, the head of the results, the results
    front.moods = [("refuse", "503 Service Unavailable", "Retry-After: 1"), ("pass",), ("pass",), ("cut", 1000000), ("cut", 1000000)]
    run("get", found, "-o", "cut.npz", url=front.url)
    ranges = [head for head in front.heads if "Range: bytes=" in head]
    check("cli: a download goes on by Range", data == (work / "cut.npz").read_bytes() and len(ranges) == 2 and "If-Range" in ranges[0], front.heads)
    etag = re.search(r'If-Range: "(\w{32})', ranges[0])[1]
    with open(work / f"part.npz.part-{etag}", "wb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        check("cli: one process downloads an answer to a file", "another process" in run("get", found, "-o", "part.npz", status=1))
    for beginning in (data[:70000], data, data + b"more"):
        (work / f"part.npz.part-{etag}").write_bytes(beginning)
        run("get", found, "-o", "part.npz")
        check(f"cli: a file of which {len(beginning)} bytes were there", data == (work / "part.npz").read_bytes())
    front.moods, front.heads[:] = [("cut", 200000)], []
    run(*words, "-o", "twice.npz", url=front.url)
    check("cli: an answer that was cut off is asked for again", len(front.heads) == 2 and np.array_equal(np.load(work / "twice.npz")["phi"], whole["phi"]))
    front.moods = [("cut", 200000)] * 99
    run(*words, "-o", "never.npz", "--patience", 0.5, url=front.url, status=4)
    check("cli: no file is there before it is whole", not (work / "never.npz").exists())
    front.moods = [("refuse", "429 Too Many Requests", "Retry-After: 60")]
    check("cli: a server that is busy for longer", "429" in run(*words, "--patience", 2, url=front.url, status=3))
    front.close()
    long = run("run", "four.json", "--t", "0:4000:0.001", "--detach").strip()
    check("cli: cancel", run("cancel", long) == "dismissed\n" and "dismissed" in run("get", long, status=5))


def test_beside(run):
    help_text, page = run("--help"), (TOP / "api/clients/cli/pendulum.1").read_text()
    told = set(re.findall(r"--([a-z]+)", help_text))
    check("cli: the man page tells every option", told == set(re.findall(r"\\-\\-([a-z]+)", page)), told ^ set(re.findall(r"\\-\\-([a-z]+)", page)))
    check("cli: version", re.match(r"pendulum [0-9.]+(\+git[0-9]{8}\.[0-9a-f]{8})?, engine [0-9a-f]{16}\n", run("--version")))
    shown = subprocess.run(["man", "--warnings", "-l", TOP / "api/clients/cli/pendulum.1"], capture_output=True, text=True) if shutil.which("man") else None
    if shown:
        check("cli: man shows it", shown.returncode == 0 and "pendulum get ID" not in shown.stderr and not shown.stderr and "EXIT STATUS" in shown.stdout, shown.stderr)
    else:
        skip("the man page as man shows it", "man is not installed")
    for words, wanted in ((("pendulum", "m"), "modes map"), (("pendulum", "run", "--d"), "--detach --duration"), (("pendulum", "run", "f", "--as", "n"), "npz ndjson")):
        script = f"source {TOP}/api/clients/cli/pendulum.bash; COMP_WORDS=({' '.join(words)}); COMP_CWORD={len(words) - 1}; _pendulum; echo ${{COMPREPLY[*]}}"
        done = subprocess.run(["bash", "-c", script], capture_output=True, text=True)
        check(f"cli: completion of {words}", done.stdout.split() == wanted.split(), done.stdout + done.stderr)
