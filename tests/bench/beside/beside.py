"""Whole requests of users' tasks beside an older program in the same run, a line each: ours, the older one's, their ratio.

    beside.py BUILD OLD [PART-OF-A-NAME...]     (make bench-beside OLD=...; OLD: a pendulumd, or a commit, which is built once)

Both daemons take turns, one request each, which of them first by turns. A figure is the processor time of the daemon for one request,
from its bytes to the last byte of its answer, the median; the ratio is the median of the turns' ratios. Above 1 the program is quicker than it was.
Tasks: the examples of the OpenAPI document; motions, ensembles and derivatives as core/forms.md names them; the forms of an answer.
Leaves to others: peers (the other benchmarks), jobs and many clients (make load). Invariant: a task counts where both answer 200.
"""
import contextlib
import json
import pathlib
import random
import statistics
import subprocess
import sys
import time

TOP = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(TOP / "tests/load"))
from load import PAPER, TYPES  # noqa: E402
from servers import daemon  # noqa: E402

SECONDS, TURNS, SHORT = 1.5, (9, 201), 0.97
KINDS = {"points": {}, "damped": {"damping": 0.01, "stiffness": 0.1}, "rods": {"rod": 0.5}}


def tree(arms, kind="points", parent=lambda k: k):
    """A chain, or what `parent` makes of it."""
    return {"length": [1] * arms, "mass": [1 + 0.01 * k for k in range(arms)], "parent": [parent(k) for k in range(arms)],
            **{name: [value] * arms for name, value in KINDS[kind].items()}}


def motion(arms, kind="points", stop=20, parent=lambda k: k, **more):
    start = {"theta": [1 + 0.3 * (k % 3) for k in range(arms)]}
    return {"pendulum": tree(arms, kind, parent), "initial": start, "times": {"stop": stop, "count": 51}, "output": ["phi", "phid"], **more}


def tasks(document):
    """(name, path, body, accept) of each."""
    for path, item in document["paths"].items():
        examples = item.get("post", {}).get("requestBody", {}).get("content", {}).get("application/json", {}).get("examples", {})
        yield from ((f"{path[4:]}: {name}", path, json.dumps(example["value"]), None) for name, example in examples.items())
    yield from ((f"the paper's example as {name}", "/v1/trajectories", PAPER, accept) for name, accept in TYPES.items())
    chance = random.Random(1)
    bushy = [k and chance.randint(max(1, k - 3), k) for k in range(200)]
    made = {f"{arms} {kind}, {stop} s": motion(arms, kind, stop) for kind in KINDS for arms, stop in ((1, 20), (2, 20), (4, 20), (8, 20), (16, 5), (64, 2))}
    made |= {f"a bushy tree of {arms} {kind}, 2 s": motion(arms, kind, 2, lambda k: bushy[k]) for kind in ("points", "damped") for arms in (20, 200)}
    made |= {f"{arms} {kind} with their horizon": motion(arms, kind, 10, trust=True) for kind in KINDS for arms in (1, 2, 4, 8)}
    made |= {f"{arms} points by {method}": motion(arms, stop=5, method=method) for method in ("rk8pd", "ode23", "symplectic") for arms in (2, 20)}
    vary = [{"vary": "gravity"}, *({"vary": name, "arm": 1} for name in ("length", "mass"))]
    made |= {f"{arms} {kind} with three derivatives": motion(arms, kind, 10, derivatives=vary) for kind in KINDS for arms in (1, 2, 4)}
    yield from ((name, "/v1/trajectories", json.dumps(body), None) for name, body in made.items())
    for kind in KINDS:
        for arms in (1, 2, 4, 8):
            grid = [{"vary": "theta", "arm": 1, "start": -3, "stop": 3, "count": 200}]
            body = {"pendulum": tree(arms, kind), "grid": grid, "duration": 10, "observables": ["first_flip", "final"]}
            yield f"200 members of {arms} {kind}, 10 s", "/v1/ensembles", json.dumps(body), None


def built(old):
    """The build of the older program: of a file its folder, of a commit build/beside/COMMIT."""
    if pathlib.Path(old).is_file():
        return pathlib.Path(old).resolve().parent
    commit = subprocess.run(["git", "-C", TOP, "rev-parse", "--verify", "--short", f"{old}^{{commit}}"], check=True, capture_output=True, text=True).stdout.strip()
    place = TOP / "build/beside" / commit
    if not place.exists():
        place.mkdir(parents=True)
        sources = subprocess.run(["git", "-C", TOP, "archive", commit], check=True, capture_output=True).stdout
        subprocess.run(["tar", "-x", "-C", place], input=sources, check=True)
    subprocess.run(["make", "-C", place, "-s", "-j2", "build"], check=True, stdout=subprocess.DEVNULL)
    return place / "build/release"


def spent(server, path, body, accept):
    """Seconds of processor that one request took, and the status of its answer."""
    before = server.cpu()
    status = server.ask(body, accept, path)[0]
    return server.cpu() - before, status


def compare(pair, *request):
    """Median seconds of both, and the median of the turns' ratios old by new; the statuses alone where one is not 200."""
    statuses = [spent(server, *request)[1] for server in pair]
    if statuses != [200, 200]:
        return statuses
    rows, end = [], time.monotonic() + SECONDS
    while len(rows) < TURNS[0] or len(rows) < TURNS[1] and time.monotonic() < end:
        turn = {}
        for which in (0, 1) if len(rows) % 2 else (1, 0):
            turn[which] = spent(pair[which], *request)[0]
        rows.append((turn[0], turn[1]))
    return *(statistics.median(column) for column in zip(*rows)), statistics.median(b / a for a, b in rows)


def main(build, old, *parts):
    options, ratios = ("--cache-bytes", "0", "--access-log", "off"), []
    with contextlib.ExitStack() as stack:
        pair = [stack.enter_context(daemon(place, *options)) for place in (build, built(old))]
        print(f"{'':<44} {'us':>12} {'old':>12} {'ratio':>7}")
        for name, *request in tasks(json.loads(pair[0].ask(path="/openapi.json")[2])):
            if parts and not any(part in name for part in parts):
                continue
            found = compare(pair, *request)
            if len(found) == 2:
                print(f"{name:<44} {f'answers {found[0]}':>12} {found[1]:12}", flush=True)
                continue
            ratios.append(found[2])
            print(f"{name:<44} {1e6 * found[0]:12.1f} {1e6 * found[1]:12.1f} {found[2]:6.3f}x{'   (short)' if found[2] < SHORT else ''}", flush=True)
    print(f"{len(ratios)} tasks: median {statistics.median(ratios):.3f}, least {min(ratios):.3f}; {sum(r < SHORT for r in ratios)} below {SHORT}")


if __name__ == "__main__":
    main(*sys.argv[1:])
