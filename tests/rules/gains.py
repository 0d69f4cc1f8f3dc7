"""Gains of /v1/controllers against SciPy's solution of the discrete Riccati equation: 200 random pendulums of 1 to 6 arms.

A and B of the answer are compared with the exponential of what /v1/modes answers as M, C, K and B; the gains with those of
solve_discrete_are for A, B, Q and R. SciPy's own error is larger than ours where one motor holds many arms, so that the gains are
compared as far as two of its solutions, in different units, agree.

usage: gains.py BUILD
Leaves to others: the equations of motion (tests/laws). Invariant: what is not installed is skipped aloud.
"""
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


def gains(a, b, q, r, unit):
    """K of dlqr, solved in other units of the state."""
    x = linalg.solve_discrete_are(a * unit / unit[:, None], b / unit[:, None], q * unit * unit[:, None], r)
    scaled = b / unit[:, None]
    return numpy.linalg.solve(r + scaled.T @ x @ scaled, scaled.T @ x @ (a * unit / unit[:, None])) / unit


def off(got, wanted):
    return float(numpy.max(numpy.abs(got - wanted)) / numpy.max(numpy.abs(wanted)))


def system(server, chance, number):
    """(error of A and B, error of the gains, disagreement of SciPy with itself) of one pendulum."""
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
    plain = gains(a, b, q, r, numpy.ones(2 * n))
    other = gains(a, b, q, r, numpy.array([1 / numpy.sqrt(m[i % n, i % n]) for i in order]))
    return plant, off(mine, plain), off(other, plain)


def main(build):
    if not (numpy and linalg):
        skip("gains: numpy or scipy is not installed")
        return summary()
    chance, rows = random.Random(3), []
    with daemon(build) as server:
        rows = [system(server, chance, number) for number in range(SYSTEMS)]
    plant, gain = max(row[0] for row in rows), [row[1] for row in rows if row[2] < TOLERANCE / 10]
    check("A and B are the exponential", plant < TOLERANCE, f"off by {plant:.1e}")
    check("gains are SciPy's", max(gain) < TOLERANCE, f"off by {max(gain):.1e}")
    check("SciPy knows most gains itself", len(gain) > SYSTEMS // 2, f"{len(gain)} of {SYSTEMS}")
    rest = max((row[1] for row in rows if row[2] >= TOLERANCE / 10), default=0)
    check("and elsewhere they are near", rest < 1e-4, f"off by {rest:.1e}")
    print(f"A and B {plant:.1e}, gains {max(gain):.1e} in {len(gain)} of {SYSTEMS}, {rest:.1e} elsewhere")
    return summary()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
