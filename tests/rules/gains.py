"""Gains of /v1/controllers against SciPy's solution of the discrete Riccati equation: 200 random pendulums of 1 to 6 arms; an acrobot.

A and B of the answer are compared with the exponential of what /v1/modes answers as M, C, K and B; the gains with those of
solve_discrete_are for A, B, Q and R. Where one motor holds many arms SciPy loses up to 10 digits of them, although the rounding of A
changes only the twelfth: gains that differ from SciPy's are compared with those of 50 decimal digits.

usage: gains.py BUILD
Leaves to others: the equations of motion (tests/laws). Invariant: what is not installed is skipped aloud.
"""
import decimal
import json
import random
import sys

from rule import check, optional, skip, summary
from servers import daemon

numpy, scipy = optional("numpy"), optional("scipy.linalg")
linalg = scipy and scipy.linalg
TOLERANCE, SYSTEMS = 1e-10, 200


def ask(server, path, body):
    status, _, data = server.ask(json.dumps(body), path=path)
    return json.loads(data) if status == 200 else {"status": status, "text": data}


def pendulum(chance, arms):
    wide = lambda: 10 ** chance.uniform(-0.3, 0.3)
    made = {"length": [wide() for _ in range(arms)], "mass": [wide() for _ in range(arms)],
            "parent": [chance.randint(max(0, k - 1), k) if k > 1 else k for k in range(arms)],
            "damping": [10 ** chance.uniform(-3, -1) for _ in range(arms)], "rod": [wide() for _ in range(arms)]}
    if chance.random() < 0.5:
        made["pivot"] = {"cart": {"mass": wide(), "damping": 10 ** chance.uniform(-3, 0)}}
    return made


def gains(a, b, q, r):
    """K of dlqr."""
    x = linalg.solve_discrete_are(a, b, q, r)
    return numpy.linalg.solve(r + b.T @ x @ b, b.T @ x @ a)


def solved(matrix, right):
    """By elimination, of any numbers."""
    n, rows = len(matrix), numpy.hstack([matrix, right])
    for i in range(n):
        pivot = max(range(i, n), key=lambda k: abs(rows[k, i]))
        rows[[i, pivot]] = rows[[pivot, i]]
        rows[i] = rows[i] / rows[i, i]
        for k in range(n):
            if k != i:
                rows[k] = rows[k] - rows[k, i] * rows[i]
    return rows[:, n:]


def exact(a, b, q, r):
    """K in 50 digits, by doubling."""
    decimal.getcontext().prec = 50
    a, b, q, r = (numpy.vectorize(decimal.Decimal, otypes=[object])(x) for x in (a, b, q, r))
    n, now, g, h = len(a), a, b @ solved(r, b.T), q
    while True:
        both = solved(numpy.vectorize(decimal.Decimal, otypes=[object])(numpy.eye(n)) + g @ h, numpy.hstack([now, g]))
        more = now.T @ h @ both[:, :n]
        now, g, h = now @ both[:, :n], g + now @ both[:, n:] @ now.T, h + more
        if abs(more).max() < abs(h).max() * decimal.Decimal("1e-45"):
            return solved(r + b.T @ h @ b, b.T @ h @ a).astype(float)


def off(got, wanted):
    return float(numpy.max(numpy.abs(got - wanted)) / numpy.max(numpy.abs(wanted)))


def system(server, chance, number):
    """(error of A and B, of the gains, of SciPy's gains) of one pendulum."""
    arms = 1 + number % 6
    tree = pendulum(chance, arms)
    theta = [chance.choice([0, 180, 180]) for _ in range(arms)]
    joints = sorted(chance.sample(range(1, arms + 1), chance.randint(1, arms)))
    cart = "pivot" in tree
    request = {"pendulum": tree, "equilibrium": {"theta": theta, "unit": "deg"}, "period": round(10 ** chance.uniform(-2.3, -1), 4),
               "actuators": {"joints": joints, "cart": cart}}
    answer = ask(server, "/v1/controllers", request)
    modes = ask(server, "/v1/modes", {"pendulum": tree, "about": ["up" if x else "down" for x in theta], "include": ["M", "C", "K", "B"]})
    if "text" in answer or "text" in modes:
        raise RuntimeError(f"{answer} {modes}"[:300])
    m, c, k, e = (numpy.array(modes[name]) for name in "MCKB")
    n, inputs = len(m), len(joints) + cart
    inverse, push = numpy.linalg.inv(m), e[:, [j - 1 for j in joints] + [arms] * cart]
    flow = numpy.zeros((2 * n + inputs, 2 * n + inputs))
    flow[:n, n:2 * n] = numpy.eye(n)
    flow[n:2 * n, :n], flow[n:2 * n, n:2 * n], flow[n:2 * n, 2 * n:] = -inverse @ k, -inverse @ c, inverse @ push
    held = linalg.expm(flow * request["period"])
    order = list(range(arms)) + [n + i for i in range(arms)] + ([arms, 2 * n - 1] if cart else [])
    a, b = numpy.array(answer["A"]), numpy.array(answer["B"])
    plant = max(off(a, held[numpy.ix_(order, order)]), off(b, held[numpy.ix_(order, range(2 * n, 2 * n + inputs))]))
    q, r = numpy.diag(answer["Q"]), numpy.diag(answer["R"])
    mine = numpy.array([row["law"]["feedback"]["gains"] for row in answer["control"]])
    theirs = gains(a, b, q, r)
    wanted = exact(a, b, q, r) if off(mine, theirs) > TOLERANCE / 10 else theirs
    return plant, off(mine, wanted), off(theirs, wanted)


# torques, N m, of an elbow that swings two equal arms up in 4 s, each for 0.05 s
SWING = [5.993, 5.443, 4.371, 2.924, 1.398, -0.01, -1.274, -2.453, -3.636, -4.939, -6.512, -8.334, -9.135, -7.698, -5.856, -4.501, -3.516,
         -2.75, -2.111, -1.548, -1.03, -0.541, -0.075, 0.367, 0.78, 1.161, 1.51, 1.826, 2.11, 2.362, 2.582, 2.776, 2.956, 3.149, 3.392,
         3.74, 4.283, 5.203, 6.906, 9.067, 7.825, 5.687, 4.363, 3.347, 2.373, 1.375, 0.408, -0.464, -1.238, -1.941, -2.579, -3.124, -3.54,
         -3.816, -3.969, -4.031, -4.033, -3.996, -3.933, -3.85, -3.749, -3.634, -3.511, -3.385, -3.263, -3.152, -3.055, -2.976, -2.914,
         -2.864, -2.818, -2.763, -2.681, -2.544, -2.31, -1.923, -1.302, -0.338, 1.105, 3.198]


def acrobot(server):
    """An acrobot follows its swing-up by gains and a reference as tables, from a start that is off by 0.05 rad, and stays upright."""
    tree, h, count = {"length": [1, 1], "mass": [1, 1], "parent": [0, 1]}, 0.05, len(SWING)
    t = [k * h for k in range(count + 1)]
    moved = tree | {"torque": [None, {"table": {"t": t, "value": [*SWING, 0], "hold": "zero", "outside": "zero"}}]}
    run = lambda body: ask(server, "/v1/trajectories", {"output": ["theta", "thetad"]} | body)
    state = lambda answer: numpy.hstack([answer["theta"], answer["thetad"]])
    way = state(run({"pendulum": moved, "initial": {"theta": [0, 0]}, "times": t}))
    design = ask(server, "/v1/controllers", {"pendulum": tree, "equilibrium": {"theta": [180, 180], "unit": "deg"}, "period": h,
                                             "actuators": {"joints": [2]}, "Q": [10, 10, 1, 1], "R": [0.1]})
    q, r = numpy.diag(design["Q"]), numpy.diag(design["R"])
    rows = [design["control"][0]["law"]["feedback"]["gains"]]
    cost = linalg.solve_discrete_are(numpy.array(design["A"]), numpy.array(design["B"]), q, r)
    vary = [{"vary": name, "arm": arm} for name in ("theta", "thetad") for arm in (1, 2)] + [{"vary": "torque", "arm": 2}]
    for k in reversed(range(count)):
        slopes = run({"pendulum": tree | {"torque": [None, SWING[k]]}, "times": [0, h], "derivatives": vary,
                      "initial": {"theta": list(way[k, :2]), "thetad": list(way[k, 2:])}})["derivatives"]
        both = numpy.vstack([slopes["theta"][1], slopes["thetad"][1]])
        a, b = both[:, :4], both[:, 4:]
        gain = numpy.linalg.solve(r + b.T @ cost @ b, b.T @ cost @ a)
        cost = q + a.T @ cost @ (a - b @ gain)
        rows.insert(0, list(gain[0]))
    target = numpy.vstack([way[:-1], [numpy.pi, numpy.pi, 0, 0]])
    law = {"feedback": {"gains": {"t": t, "value": rows}, "reference": {"t": t, "value": target.tolist()}}}
    control = [{"joint": 2, "law": law, "period": h, "limit": [-20, 20]}]
    start = {"initial": {"theta": [0.05, -0.05]}, "times": {"stop": 10, "count": 201}}
    open_way, held = (state(run(start | {"pendulum": made})) for made in (moved, moved | {"control": control}))
    off_open, off_held = (numpy.abs(x[count, :2] - way[count, :2]).max() for x in (open_way, held))
    check("an acrobot without feedback misses", off_open > 1, f"{off_open:.2g} rad")
    check("an acrobot along its tables arrives", off_held < 1e-3, f"off by {off_held:.2g} rad")
    print(f"an acrobot after its swing-up: {off_open:.1e} rad off without feedback, {off_held:.1e} rad with it")
    check("and stays upright", numpy.abs(held[-1] - [numpy.pi, numpy.pi, 0, 0]).max() < 1e-4, f"{held[-1]}")


def main(build):
    if not (numpy and linalg):
        skip("gains: numpy or scipy is not installed")
        return summary()
    chance, rows = random.Random(3), []
    with daemon(build) as server:
        rows = [system(server, chance, number) for number in range(SYSTEMS)]
        acrobot(server)
    plant, gain, theirs = (max(row[i] for row in rows) for i in range(3))
    check("A and B are the exponential", plant < TOLERANCE, f"off by {plant:.1e}")
    check("gains are right", gain < TOLERANCE, f"off by {gain:.1e}")
    lost = sum(row[2] > TOLERANCE for row in rows)
    check("SciPy has most of them too", lost < SYSTEMS // 5, f"not {lost} of {SYSTEMS}")
    print(f"A and B {plant:.1e}, gains {gain:.1e}; SciPy's gains are off by {theirs:.1e}, by more than {TOLERANCE} in {lost}")
    return summary()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
