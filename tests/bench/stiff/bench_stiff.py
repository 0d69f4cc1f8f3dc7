"""Stiff pendulums by method radau and by taylor, beside SciPy's Radau in the same run: steps, time, error.

    bench_stiff.py BUILD

All start at rest. Ours at the default tolerance of radau, 1e-9, and at 1e-12; SciPy with rtol 1e-10 and a thousandth of it as atol, with the
Jacobian given. Times are what the answer says, least of three, and of SciPy that of the processor. Errors are those of the angles at the
last instant, rad: of one arm from the expansion for strong friction, whose next terms are 4e-13 at damping 1e4, 5e-11 at friction speed 1e-6, and below 1e-15 else; of two arms from radau
at rtol 1e-14. Leaves to others: whether motions are right (tests/core/derivatives/test_method_radau.c). Invariant: both take one thread.
"""
import json
import math
import os
import subprocess
import sys
import time
import urllib.error
import urllib.request

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
import numpy as np  # noqa: E402
from scipy.integrate import solve_ivp  # noqa: E402

G = 9.81


def syrup(length, mass, damping, theta, stop):
    """theta'' + c theta' + w sin theta = 0 with c large: theta' = -(w/c) sin theta from where the first 1/c seconds lead."""
    c, w = damping / (mass * length**2), G / length
    start = theta + w * math.sin(theta) / c**2
    return 2 * math.atan(math.tan(start / 2) * math.exp(-w / c * stop * (1 + w * math.cos(theta) / c**2)))


def one(name, length, mass, damping, stop=4.0, theta=1.0):
    c, w = damping / (mass * length**2), G / length
    return {"name": name, "arms": [{"length": length, "mass": mass, "damping": damping}], "theta": [theta], "stop": stop,
            "f": lambda t, x: [x[1], -c * x[1] - w * math.sin(x[0])], "jac": lambda t, x: [[0, 1], [-w * math.cos(x[0]), -c]],
            "exact": [syrup(length, mass, damping, theta, stop)]}


def stuck(name, torque, speed, stop=4.0, theta=1.0):
    def jac(t, x):
        return [[0, 1], [-G * math.cos(x[0]), -torque / speed * (1 - math.tanh(x[1] / speed) ** 2)]]
    return {"name": name, "arms": [{"length": 1, "mass": 1, "friction": {"torque": torque, "speed": speed}}], "theta": [theta], "stop": stop,
            "f": lambda t, x: [x[1], -G * math.sin(x[0]) - torque * math.tanh(x[1] / speed)], "jac": jac,
            "exact": [theta - speed * math.atanh(G * math.sin(theta) / torque) * stop]}


def elbow(name, stiffness, damping, stop=1.0):
    """Two arms of 1 m and 1 kg with a spring and a damper between them."""
    def f(t, x):
        a, b, v, w = x
        c, s, m = math.cos(a - b), math.sin(a - b), -stiffness * (b - a) - damping * (w - v)
        p, q = -s * w * w - 2 * G * math.sin(a) - m, s * v * v - G * math.sin(b) + m
        return [v, w, (p - c * q) / (2 - c * c), (2 * q - c * p) / (2 - c * c)]
    return {"name": name, "stop": stop, "theta": [1.0, 1.1], "f": f, "jac": None, "exact": None,
            "arms": [{"name": "a", "length": 1, "mass": 1}, {"parent": "a", "length": 1, "mass": 1, "stiffness": stiffness, "damping": damping}]}


CASES = [one("damping 1e4", 1, 1, 1e4), one("damping 1e6", 1, 1, 1e6), one("damping 1e8", 1, 1, 1e8),
         one("1 mm, 1 mg, damping 0.01", 1e-3, 1e-6, 0.01), stuck("stuck, friction speed 1e-6", 9, 1e-6),
         stuck("stuck, friction speed 1e-9", 9, 1e-9), elbow("elbow spring 1e8, damper 1e5", 1e8, 1e5)]


def ask(address, case, method, rtol, turn=0):
    body = {"pendulum": {"arms": case["arms"], "gravity": G}, "initial": {"theta": case["theta"]}, "method": method, "rtol": rtol,
            "times": [0, case["stop"] / (2 + turn), case["stop"]], "output": ["theta"]}  # another answer than the one that is kept
    request = urllib.request.Request(address + "/v1/trajectories", json.dumps(body).encode(), {"Content-Type": "application/json"})
    try:
        with urllib.request.urlopen(request) as reply:
            return json.load(reply)
    except urllib.error.HTTPError as refusal:
        return json.load(refusal)


def ours(address, case, method, rtol):
    answers = [ask(address, case, method, rtol, turn) for turn in range(3)]
    if "stats" not in answers[0]:
        return f"{method} {rtol:.0e}: refused, {answers[0]['detail'].split(', longer')[0].split(', more')[0]}"
    error = max(abs(x - y) for x, y in zip(answers[0]["theta"][-1], case["exact"]))
    seconds = min(answer["stats"]["compute_seconds"] for answer in answers)
    return f"{method} {rtol:.0e}: {answers[0]['stats']['steps']} steps, {1e3 * seconds:.3g} ms, {error:.1e}"


def peer(case):
    start = np.concatenate([case["theta"], np.zeros(len(case["theta"]))])
    begin = time.process_time()
    motion = solve_ivp(case["f"], (0, case["stop"]), start, method="Radau", rtol=1e-10, atol=1e-13, jac=case["jac"])
    seconds = time.process_time() - begin
    error = max(abs(x - y) for x, y in zip(motion.y[:len(case["theta"]), -1], case["exact"]))
    return f"SciPy's Radau 1e-10: {len(motion.t) - 1} steps, {1e3 * seconds:.3g} ms, {error:.1e}"


def main():
    server = subprocess.Popen([sys.argv[1] + "/pendulumd", "--listen", "127.0.0.1:0", "--store", "none", "--allow-root", "on"],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    try:
        address = server.stderr.readline().split()[-1]
        for case in CASES:
            if not case["exact"]:
                case["exact"] = ask(address, case, "radau", 1e-14)["theta"][-1]
            print(case["name"])
            for line in (ours(address, case, "radau", 1e-9), ours(address, case, "radau", 1e-12), ours(address, case, "taylor", 1e-12), peer(case)):
                print("    " + line)
    finally:
        server.terminate()
        server.wait()


main()
