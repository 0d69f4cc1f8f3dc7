"""Everything mixed for a time: memory, descriptors, threads, processes and files stay as many as they were.

usage: soak.py BUILD [--seconds N] [--isolate]
Leaves to others: kills and faults (drill.py), right answers (the rooms' tests). Invariant: what is compared is after all kinds of
requests have come, and everything that was asked is answered as it should be.
"""
import argparse
import collections
import http.client
import json
import pathlib
import random
import subprocess
import sys
import tempfile
import time

PATIENCE = 120  # s
TREE = '"pendulum":{"length":[1,1],"mass":[1,1],"parent":[0,1]}'
MOTION = f'{{{TREE},"initial":{{"theta":[1,2]}},"times":{{"stop":%s,"count":200}}}}'
KINDS = {  # path, body, header fields, statuses
    "modes": ("/v1/modes", f"{{{TREE}}}", {}, {200}),
    "table": ("/v1/trajectories", MOTION % 3, {"Accept": "text/csv"}, {200}),
    "fault": ("/v1/trees", '{"pendulum":{"length":[1,-1]}}', {}, {422}),
    "no JSON": ("/v1/trees", '{"pendulum"', {}, {400}),
    "job": ("/v1/trajectories", MOTION % 5, {"Prefer": "respond-async"}, {202}),
    "gone": ("/v1/trajectories", MOTION % 3000, {}, set()),
}


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
            "files": len(list(place.iterdir())), "kilobytes": status(pid, "VmRSS:")}


def ask(port, kind):
    path, body, headers, good = KINDS[kind]
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)
    connection.request("POST", path, body, {"Content-Type": "application/json"} | headers)
    if not good:
        time.sleep(0.005)
        connection.close()
        return True
    reply = connection.getresponse()
    data = reply.read()
    if reply.status == 202:  # it is awaited and removed
        place = f"/v1/jobs/{json.loads(data)['id']}"
        connection.request("GET", f"{place}?wait=20")
        connection.getresponse().read()
        connection.request("DELETE", place)
        last = connection.getresponse()
        last.read()
        connection.close()
        return last.status in (200, 204)
    connection.close()
    return reply.status in good


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=300)
    parser.add_argument("--isolate", action="store_true", help="computations in processes of their own")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="pendulumd-soak-") as directory:
        command = [asked.build / "pendulumd", "--listen", "127.0.0.1:0", "--store", f"sqlite:{directory}/store.db", "--cache-bytes", "1M",
                   "--allow-root", "on", "--isolate", "on" if asked.isolate else "off"]
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        port = int(process.stderr.readline().rsplit(":", 1)[1])
        chance, counts, wrong, before = random.Random(1), collections.Counter(), collections.Counter(), None
        began = time.monotonic()
        while time.monotonic() < began + asked.seconds:
            kind = chance.choice(list(KINDS))
            counts[kind] += 1
            wrong[kind] += not ask(port, kind)
            if not before and time.monotonic() > began + asked.seconds / 3:
                time.sleep(1)
                before = figures(process.pid, pathlib.Path(directory))
        time.sleep(1)
        after = figures(process.pid, pathlib.Path(directory))
        process.terminate()
        left = process.wait(PATIENCE)
    print(f"{sum(counts.values())} requests: {dict(counts)}; before {before}, after {after}")
    most = {"processes": before["processes"], "descriptors": before["descriptors"] + 2, "threads": before["threads"], "files": before["files"] + 1,
            "kilobytes": 1.1 * before["kilobytes"] + 2048}
    bad = [name for name in most if after[name] > most[name]] + [kind for kind in KINDS if wrong[kind]] + (["the end"] if left else [])
    print("".join(f"FAIL {name}\n" for name in bad) + f"{len(most) + len(KINDS) + 1 - len(bad)} passed, {len(bad)} failed")
    sys.exit(bool(bad))


main()
