"""Bifurcations of random branches by POST /v1/orbits, checked with multipliers of our own.

    bench_bifurcations.py BUILD [SEED]

36 branches of random trees: 20 driven ones of 1 to 4 arms with friction, followed in the torque or in its frequency, and 16 ideal ones of 3 to 5
arms. At every bifurcation that is answered the monodromy matrix is integrated here, from equations written here, by SciPy's DOP853: false is one
where no multiplier is at 1, at -1, or on the circle, as its kind says. Missed are multipliers that are on another side of the circle at one orbit
than at the one before, beyond those that the bifurcations between them account for. Leaves to others: speed (bench_orbits.py).
Invariant: a row of a branch and the last line, which counts all.
"""
import json
import os
import subprocess
import sys
import urllib.request

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
import numpy as np  # noqa: E402
from scipy.integrate import solve_ivp  # noqa: E402

GRAVITY, TINY = 9.81, 1e-30
TOLERANCE = 3e-5  # of a multiplier that grows no faster than a thousandfold


def branches(seed):
    draw = np.random.default_rng(seed)

    def between(low, high, digits=2):
        return round(float(draw.uniform(low, high)), digits)

    def tree(n):
        arms = []
        for k in range(n):
            arms.append({"name": f"a{k}", "length": between(0.4, 1.2), "mass": between(0.2, 1.2)})
            if k:
                arms[k]["parent"] = f"a{draw.integers(max(0, k - 2), k)}"
        return arms

    for i in range(20):
        arms = tree(1 + i % 4)
        for arm in arms:
            arm["damping"] = between(0.01, 0.12, 3)
        omega = between(0.8, 2)
        arms[0]["torque"] = {"harmonics": [{"amplitude": between(0.5, 3), "omega": omega}]}
        branch = {"vary": "omega", "to": between(2.5, 4)} if i % 2 else {"vary": "torque_amplitude", "arm": 1, "to": between(4, 8)}
        yield {"pendulum": {"arms": arms}, "branch": branch, "points": 80}
    for i in range(16):
        n = 3 + i % 3
        yield {"pendulum": {"arms": tree(n)}, "mode": 1 + int(draw.integers(0, n)), "amplitude": 2, "branch": True}


def acceleration(request, value):
    """The equations of motion of many states at once, angles from hanging: columns of x are states."""
    arms = request["pendulum"]["arms"]
    n, number = len(arms), {arm["name"]: k for k, arm in enumerate(arms)}
    parent = [number[arm["parent"]] if "parent" in arm else -1 for arm in arms]
    length, mass = np.array([arm["length"] for arm in arms]), np.array([arm["mass"] for arm in arms])
    on_path = np.zeros((n, n))
    for k in range(n):
        j = k
        while j >= 0:
            on_path[k, j], j = 1, parent[j]
    carried = on_path.T * mass @ on_path
    inertia, weight = carried * np.outer(length, length), np.diag(carried) * length * GRAVITY
    torque = dict(arms[0].get("torque", {"harmonics": [{"amplitude": 0, "omega": 0}]})["harmonics"][0])
    if isinstance(request["branch"], dict):
        torque["omega" if request["branch"]["vary"] == "omega" else "amplitude"] = value

    def rate(t, x):
        theta, speed = x[:n], x[n:]
        apart = theta[:, None] - theta[None]
        force = -np.einsum("ijm,jm->im", inertia[:, :, None] * np.sin(apart), speed * speed) - weight[:, None] * np.sin(theta)
        force[0] += torque["amplitude"] * np.cos(torque["omega"] * t)
        for k in range(n):
            rubs = arms[k].get("damping", 0) * (speed[k] - (speed[parent[k]] if parent[k] >= 0 else 0))
            force[k] -= rubs
            if parent[k] >= 0:
                force[parent[k]] += rubs
        matrix = np.moveaxis(inertia[:, :, None] * np.cos(apart), 2, 0)
        return np.concatenate([speed, np.linalg.solve(matrix, force.T[:, :, None])[:, :, 0].T])
    return n, rate


def multipliers(request, there):
    n, rate = acceleration(request, there.get("value", there.get("omega")))
    start = np.concatenate([np.array(there["phi"]) + np.pi / 2, there["phid"]])

    def both(t, y):  # the motion, and its derivative by a complex step
        x, along = y[:2 * n], y[2 * n:].reshape(2 * n, 2 * n)
        moved = rate(t, np.concatenate([x[:, None].astype(complex), x[:, None] + 1j * TINY * along], 1))
        return np.concatenate([moved[:, 0].real, (moved[:, 1:].imag / TINY).ravel()])

    end = solve_ivp(both, (0, there["period"]), np.concatenate([start, np.eye(2 * n).ravel()]), method="DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    return np.linalg.eigvals(end[2 * n:].reshape(2 * n, 2 * n))


def away(request, there):
    """How far the multipliers are from what the kind says, over the tolerance."""
    all_of_them, driven = multipliers(request, there), isinstance(request["branch"], dict)
    size = max(1, np.max(np.abs(all_of_them)) / 1000)
    if not driven:  # one pair is 1 all along; what meets there is known to the root of errors
        all_of_them, size = np.delete(all_of_them, np.argsort(np.abs(all_of_them - 1))[:2]), 100 * size
    if there["kind"] != "torus":
        return np.min(np.abs(all_of_them - (-1 if there["kind"] == "doubling" else 1))) / (TOLERANCE * size)
    pairs = all_of_them[all_of_them.imag > 1e-4]
    off = np.abs(np.abs(pairs) - 1)
    if driven:
        return np.min(off, initial=np.inf) / (TOLERANCE * size)
    meet = [abs(pairs[i] - pairs[j]) + off[i] for i in range(len(pairs)) for j in range(i)]
    return min(meet, default=np.inf) / (5 * TOLERANCE * size)


def missed(request, answer):
    size = np.hypot(answer["multipliers"]["re"], answer["multipliers"]["im"]).reshape(len(answer["period"]), -1)
    sure = 1e-5
    growing, doubtful = (size > 1 + sure).sum(1), (size > 1 + 1e-9).sum(1)
    count = last = told = 0
    for row in range(1, len(growing)):
        told += sum(2 if b["kind"] == "torus" else 1 for b in answer["bifurcations"] if b["after"] == row)
        if growing[row] != doubtful[row]:
            continue
        change = abs(int(growing[row]) - int(growing[last]))
        count += change - told if change > told else (told - change) % 2
        last, told = row, 0
    return count


def ask(address, body):
    request = urllib.request.Request(address + "/v1/orbits", json.dumps(body).encode(), {"Content-Type": "application/json"})
    with urllib.request.urlopen(request) as reply:
        return json.load(reply)


def main():
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 35
    server = subprocess.Popen([sys.argv[1] + "/pendulumd", "--listen", "127.0.0.1:0", "--store", "none", "--allow-root", "on"],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    total = np.zeros(5, int)
    try:
        address = server.stderr.readline().split()[-1]
        print(f"{'branch':28}{'orbits':>8}{'shots':>8}{'answered':>10}{'false':>7}{'missed':>8}{'worst':>9}")
        for i, body in enumerate(branches(seed)):
            answer = ask(address, body)
            parts = [away(body, there) for there in answer["bifurcations"]]
            row = [len(answer["period"]), answer["stats"]["shots"], len(parts), sum(part > 1 for part in parts), missed(body, answer)]
            kind = "driven" if isinstance(body["branch"], dict) else f"mode {body['mode']}"
            print(f"{i + 1:3} {kind}, {len(body['pendulum']['arms'])} arms".ljust(28)
                  + f"{row[0]:8}{row[1]:8}{row[2]:10}{row[3]:7}{row[4]:8}{max(parts, default=0):9.2g}")
            total += row
        print("all".ljust(28) + f"{total[0]:8}{total[1]:8}{total[2]:10}{total[3]:7}{total[4]:8}")
    finally:
        server.terminate()
        server.wait()


if __name__ == "__main__":
    main()
