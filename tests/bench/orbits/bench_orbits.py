"""Nonlinear modes of the double pendulum by POST /v1/orbits, beside a shooting written with SciPy: time, and how far they agree.

    bench_orbits.py BUILD

Both find orbits of both modes up to 2 rad, with their multipliers: ours all of the branch, SciPy every sixth, from a start near it;
times are of one orbit: of ours what the answer says, of SciPy that of the processor. SciPy: fsolve over DOP853, with its own differences;
multipliers by central differences of four motions a period. Ours: with its continuation and the motion that
checks every orbit. Leaves to others: whether orbits are right (tests/core/orbits). Invariant: both take one thread.
"""
import json
import os
import subprocess
import sys
import time
import urllib.request

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
import numpy as np  # noqa: E402
from scipy.integrate import solve_ivp  # noqa: E402
from scipy.optimize import fsolve  # noqa: E402

GRAVITY = 9.81


def rate(_, x):
    """Two arms of 1 m and 1 kg, angles from hanging."""
    a, b, v, w = x
    c, s = np.cos(a - b), np.sin(a - b)
    p, q = -s * w * w - 2 * GRAVITY * np.sin(a), s * v * v - GRAVITY * np.sin(b)
    return [v, w, (p - c * q) / (2 - c * c), (2 * q - c * p) / (2 - c * c)]


def motion(start, span):
    return solve_ivp(rate, (0, span), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]


def shoot(guess, arm, amplitude):
    """An orbit whose arm turns back at this angle: the other angle and the period, by theta(T / 4) = 0."""
    def start(y):
        angles = np.insert([y[0]], arm, amplitude)
        return np.concatenate([angles, [0, 0]])

    y = fsolve(lambda y: motion(start(y), y[1] / 4)[:2], guess, xtol=1e-12)
    return y, start(y)


def multipliers(start, period, h=1e-5):
    columns = [(motion(start + h * e, period) - motion(start - h * e, period)) / (2 * h) for e in np.eye(4)]
    return np.linalg.eigvals(np.array(columns).T)


def peer(rows):
    """The same orbits; returns the largest difference of periods and of the multipliers' sums."""
    worst = [0, 0]
    for period, theta, re in rows:
        arm = int(np.argmax(np.abs(theta)))
        y, start = shoot(np.array([theta[1 - arm] * 1.01, period * 1.003]), arm, theta[arm])
        sums = np.sum(multipliers(start, y[1])).real
        worst[0] = max(worst[0], abs(y[1] / period - 1))
        worst[1] = max(worst[1], abs(sums - sum(re)) / max(1, np.max(np.abs(re))))
    return worst


def ask(address, mode, amplitude):
    body = {"pendulum": {"length": [1, 1], "mass": [1, 1], "parent": [0, 1], "gravity": GRAVITY}, "mode": mode, "amplitude": amplitude, "branch": True}
    request = urllib.request.Request(address + "/v1/orbits", json.dumps(body).encode(), {"Content-Type": "application/json"})
    with urllib.request.urlopen(request) as reply:
        return json.load(reply)


def main():
    server = subprocess.Popen([sys.argv[1] + "/pendulumd", "--listen", "127.0.0.1:0", "--store", "none", "--allow-root", "on"],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    try:
        address = server.stderr.readline().split()[-1]
        print(f"{'':28}{'ours, ms':>10}{'SciPy, ms':>12}{'ratio':>8}{'period':>10}{'multipliers':>13}")
        for mode in (1, 2):
            ours = theirs = float("inf")
            for i in range(3):
                answer = ask(address, mode, 2 + 1e-9 * i)  # another answer than the one that is kept
                ours = min(ours, answer["stats"]["compute_seconds"] / len(answer["period"]))
                rows = [(t, np.array(p) + np.pi / 2, re) for t, p, re in zip(answer["period"], answer["phi"], answer["multipliers"]["re"])]
                begin = time.process_time()
                worst = peer(rows[5::6])
                theirs = min(theirs, (time.process_time() - begin) / len(rows[5::6]))
            print(f"mode {mode}, an orbit of {len(rows)}         {1e3 * ours:10.2f}{1e3 * theirs:12.0f}{theirs / ours:8.0f}{worst[0]:10.1e}{worst[1]:13.1e}")
    finally:
        server.terminate()
        server.wait()


main()
