"""Tests the answers of /v1/equations: their programs are run, their formulas are parsed and evaluated.

At random states of many trees the accelerations and forces of each must equal those of /v1/forces; programs are also
tested with real pendulums, with each load alone and with all together. The parser of formulas
knows no mechanics: it turns \\ell_{2} into a number and juxtaposition into a product, and nothing else.

usage: equations.py BUILD
Leaves to others: whether /v1/forces is right (tests/laws). Invariant: skipped tests are reported.
"""
import cmath
import itertools
import json
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile

from rule import OCTAVE, TOP, check, optional, skip, summary
from servers import daemon

numpy = optional("numpy")
scipy = optional("scipy")

TOLERANCE = 1e-10  # relative to the largest; measured 4e-13
STATES = 3
worst = {}


def near(kind, what, got, wanted, tolerance=TOLERANCE):
    """Lists of numbers that agree relative to the largest; that one is not 0."""
    scale = max(map(abs, wanted), default=0)
    off = max((abs(a - b) for a, b in zip(got, wanted)), default=0) / scale if scale and len(got) == len(wanted) else 1
    worst[kind] = max(worst.get(kind, 0), off)
    check(f"{kind}: {what}", off <= tolerance, f"off by {off:.1e}: {got} and {wanted}"[:300])


def ask(server, path, body):
    status, _, data = server.ask(json.dumps(body), path=path)
    if status != 200:
        raise RuntimeError(f"{path} answers {status}: {data[:300]}")
    return json.loads(data)


# --- trees ---

def trees():
    """(name, pendulum, form): every shape of up to four arms, then random ones, in random order of the arms."""
    chance = random.Random(7)
    shapes = [parents for n in range(1, 5) for parents in itertools.product(*([[0]] + [range(1, k) for k in range(2, n + 1)]))]
    shapes += [[0] + [chance.randint(1, k) for k in range(1, n)] for n in (6, 8, 12)]
    shapes += [range(20)]  # a chain: the longest formulas that there are
    for parents in shapes:
        n = len(parents)
        yield f"{n} arms {list(parents)}", pendulum(chance, parents), "explicit"
    for n in (1, 4, 9, 30, 120):
        yield f"{n} arms", pendulum(chance, [0] + [chance.randint(max(1, k - 3), k) for k in range(1, n)]), "compact"


def pendulum(chance, parents):
    n = len(parents)
    order = list(range(n))
    chance.shuffle(order)
    place = {arm: i for i, arm in enumerate(order)}
    return {"length": [round(chance.uniform(0.3, 2), 3) for _ in parents], "mass": [10 ** chance.uniform(-1, 1) for _ in parents],
            "parent": [place[parents[arm] - 1] + 1 if parents[arm] else 0 for arm in order], "gravity": 9.81}


def harmonics(chance, count):
    return {"harmonics": [{"amplitude": chance.uniform(-1, 1), "omega": chance.uniform(1, 9), "phase": chance.uniform(0, 6)}
                          for _ in range(count)]}


LOADS = {
    "rods": lambda chance: {"rod": chance.uniform(0.2, 2)},
    "bodies": lambda chance: {"body": {"mass": chance.uniform(0.2, 2), "center": [chance.uniform(-1, 1), chance.uniform(-1, 1)],
                                       "inertia": chance.uniform(0.1, 1)}},
    "hung elsewhere": lambda chance: {"at": [chance.uniform(-1, 1), chance.uniform(-1, 1)]},
    "springs": lambda chance: {"stiffness": chance.uniform(1, 9), "rest": chance.uniform(-1, 1)},
    "damping": lambda chance: {"damping": chance.uniform(0.1, 1)},
    "dry friction": lambda chance: {"friction": {"torque": chance.uniform(0.1, 1), "speed": chance.uniform(0.1, 1)}},
    "drag": lambda chance: {"drag": {"linear": chance.uniform(0.1, 1), "quadratic": chance.uniform(0.1, 1)}},
    "torques": lambda chance: {"torque": chance.uniform(-3, 3)},
    "motors": lambda chance: {"torque": {"constant": chance.uniform(-3, 3)} | harmonics(chance, 2)},
}
WHOLE = {
    "drag per mass": lambda chance: {"drag_per_mass": chance.uniform(0.1, 1)},
    "a driven pivot": lambda chance: {"pivot": {"x": harmonics(chance, 1), "y": harmonics(chance, 2)}},
    "an accelerated pivot": lambda chance: {"pivot": {"acceleration": [chance.uniform(-5, 5), chance.uniform(-5, 5)]}},
    "a cart": lambda chance: {"pivot": {"cart": {"mass": chance.uniform(0.2, 2), "angle": chance.uniform(-1, 1),
                                                 "damping": chance.uniform(0, 1), "stiffness": chance.uniform(1, 9),
                                                 "force": {"constant": chance.uniform(-3, 3)} | harmonics(chance, 2)}}},
}


REAL = {"length": [1, 0.7], "mass": [1, 0], "parent": [0, 1], "rod": [None, 0.5], "damping": [0.1, 0.2], "stiffness": [None, 2],
        "torque": [{"harmonics": [{"amplitude": 3, "omega": 4}]}, None], "drag": [{"linear": 0.1}, None],
        "pivot": {"y": {"harmonics": [{"amplitude": 0.05, "omega": 20}]}}}


CART = {"length": [1, 0.7], "mass": [1, 0.5], "parent": [0, 0], "damping": [0.1, 0.2], "drag": [{"linear": 0.1}, None],
        "pivot": {"cart": {"mass": 1, "damping": 0.2, "stiffness": 3, "angle": 0.2, "force": {"harmonics": [{"amplitude": 3, "omega": 4}]}}}}


# the table of a torque, one that holds its values, and the place of the pivot
TABLES = {"length": [1, 0.7], "mass": [1, 0.5], "parent": [0, 1], "damping": [0.1, 0.2],
          "torque": [{"table": {"t": [0.5, 2, 5], "value": [1, -3, 2], "hold": "linear", "outside": "zero"}},
                     {"table": {"t": [1, 3], "value": [0.5, -1], "hold": "zero", "outside": "hold"}}],
          "pivot": {"x": {"table": {"t": [0, 1, 2.5, 4, 5], "value": [0, 0.3, -0.2, 0.1, 0]}}, "y": {"table": {"t": [0, 5], "value": [0, 1]}}}}
PUSHED = {"length": [1, 0.7], "mass": [1, 0.5], "parent": [0, 0], "torque": [{"table": {"t": [0], "value": [0.2], "hold": "linear", "outside": "hold"}}, None],
          "pivot": {"cart": {"mass": 1, "force": {"table": {"t": [0, 2, 4], "value": [1, -1, 0], "hold": "linear", "outside": "hold"}}}}}


def real_trees():
    """(name, pendulum): random trees with each load on some of their arms, and with all loads."""
    chance = random.Random(11)
    kinds = [[name] for name in (*LOADS, *WHOLE)] + [[*LOADS, "drag per mass", "a driven pivot"]] * 4
    kinds += [["a cart", name] for name in ("drag", "motors", "drag per mass")] + [[*LOADS, "drag per mass", "a cart"]] * 3
    for i, kind in enumerate(kinds):
        n = 1 + i % 6 if len(kind) < 3 else (1, 3, 7, 24)[i % 4]
        tree = pendulum(chance, [0] + [chance.randint(max(1, k - 3), k) for k in range(1, n)])
        arms = [{"name": f"{k + 1}", "length": tree["length"][k], "mass": tree["mass"][k]} | ({"parent": f"{parent}"} if parent else {})
                for k, parent in enumerate(tree["parent"])]
        for arm in arms:
            for name in kind:
                if name in LOADS and (chance.random() < 0.7 or arm is arms[-1] or n < 4) and (name != "hung elsewhere" or "parent" in arm):
                    arm |= LOADS[name](chance)
            if "rod" in arm and chance.random() < 0.5:
                arm["mass"] = 0
        whole = {"arms": arms, "gravity": 9.81}
        for name in kind:
            whole |= WHOLE[name](chance) if name in WHOLE else {}
        yield f"{n} arms with {' and '.join(kind)}", whole


def states(n):
    chance = random.Random(n)
    return [{"phi": [chance.uniform(-4, 4) for _ in range(n)], "phid": [chance.uniform(-3, 3) for _ in range(n)]}
            for _ in range(STATES)]


# --- formulas ---

TOKEN = re.compile(r"\\(?:ell|phi|lambda)_\{\d+\}|\\d?dot\{\\phi\}_\{\d+\}|[mz]_\{\d+\}|g|\\cos|\\sin|e\^\{\\mathrm\{i\}|\^\{2\}|\\bigl\[|\\bigr\]|[()+\-}]|[01]")


class Reader:
    """A recursive reader of sums, products and the functions that occur."""

    def __init__(self, text, value):
        text = re.sub(r"\\qquad\{\}|\\\\\[1ex\]|\s|&", "", text)
        self.tokens = TOKEN.findall(text)
        if "".join(self.tokens) != text:
            raise ValueError(f"cannot read {text}")
        self.value = value
        self.at = 0

    def peek(self):
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def take(self):
        self.at += 1
        return self.tokens[self.at - 1]

    def all(self):
        result = self.sum()
        if self.peek():
            raise ValueError(f"{self.peek()} at the end")
        return result

    def sum(self):
        result = 0
        sign = 1
        if self.peek() == "-":
            self.take()
            sign = -1
        while True:
            result += sign * self.product()
            if self.peek() not in ("+", "-"):
                return result
            sign = 1 if self.take() == "+" else -1

    def product(self):
        result = self.factor()
        while self.peek() and self.peek() not in ("+", "-", ")", "}", "\\bigr]"):
            result *= self.factor()
        return result

    def factor(self):
        token = self.take()
        if token in ("(", "\\bigl["):
            result = self.sum()
            self.take()
        elif token in ("\\cos", "\\sin"):
            result = {"\\cos": cmath.cos, "\\sin": cmath.sin}[token](self.factor()).real
        elif token.startswith("e^"):
            result = cmath.exp(1j * self.factor())
            self.take()
        elif token in ("0", "1"):
            result = int(token)
        else:
            result = self.value[token]
        if self.peek() == "^{2}":
            self.take()
            result *= result
        return result


def names(tree, state, answer):
    value = {"g": tree["gravity"]}
    for name, list_ in (("\\ell", tree["length"]), ("m", tree["mass"]), ("\\phi", state["phi"]), ("\\dot{\\phi}", state["phid"]),
                        ("\\ddot{\\phi}", answer["phidd"])):
        value |= {f"{name}_{{{k + 1}}}": number for k, number in enumerate(list_)}
    return value


def rows_of(matrix):
    inner = re.search(r"\\begin\{(?:pmatrix|array\}\{[cr]+)\}(.*)\\end\{(?:pmatrix|array)\}", matrix)[1]
    return [row.split("&") for row in inner.split("\\\\")]


def lines_of(aligned):
    inner = aligned.removeprefix("\\begin{aligned}").removesuffix("\\end{aligned}")
    return inner.replace("\\\\&\\qquad{}=", "=").replace("\\\\[1ex]", "\\\\").split("\\\\")


def check_formulas(what, latex, tree, state, answer):
    n, value = len(tree["parent"]), names(tree, state, answer)
    left, right = [], []
    for line in lines_of(latex["aaa"]):
        sides = line.split("=")
        left.append(Reader(sides[0], value).all())
        right.append(Reader(sides[1], value).all())
    near("(aaa) as a formula", what, left, right)
    forces = [Reader(line.split("=")[1], value).all() for line in lines_of(latex["bbb"])]
    near("(bbb) as a formula", what, forces, answer["lambda"])
    tips = [Reader(line.split("=")[1], value).all() for line in lines_of(latex["z"])]
    near("z as a formula", what, tips, [complex(*z) for z in zip(answer["z"]["re"], answer["z"]["im"])])
    path = [[Reader(entry, value).all() for entry in row] for row in rows_of(latex["S"])]
    force = [[Reader(entry, value).all() for entry in row] for row in rows_of(latex["B"])]
    unit = [[sum(path[k][i] * force[k][j] for k in range(n)) for j in range(n)] for i in range(n)]
    check(f"S^T B = I: {what}", unit == [[int(i == j) for j in range(n)] for i in range(n)], unit)
    turn = [length * cmath.exp(1j * phi) for length, phi in zip(tree["length"], state["phi"])]
    mass = [turn[i].conjugate() * sum(path[k][i] * tree["mass"][k] * path[k][j] for k in range(n)) * turn[j]
            for i in range(n) for j in range(n)]
    near("M as a formula", what, [Reader(entry, value).all() for row in rows_of(latex["M"]) for entry in row], mass)


def check_katex(formulas):
    """All formulas through KaTeX, strictly."""
    script = (f"import katex from {json.dumps('/usr/share/javascript/katex/katex.mjs')};\n"
              "let all=''; for await (const piece of process.stdin) all += piece;\n"
              "for (const [name, text] of JSON.parse(all)) { try { "
              "katex.renderToString(text, {displayMode: true, throwOnError: true, strict: 'error'}); }"
              "catch (error) { console.log(name + ': ' + error.message); } }\n")
    ran = subprocess.run(["node", "--input-type=module", "-e", script], input=json.dumps(formulas), capture_output=True,
                         text=True, timeout=600)
    check("KaTeX reads every formula", ran.returncode == 0 and not ran.stdout and len(formulas) > 100,
          (ran.stdout + ran.stderr)[:500])


# --- programs ---

def check_python(what, code, state, answer, *time):
    scope = {"__name__": "equations"}
    exec(compile(code, "equations", "exec"), scope)
    phi, rate = numpy.array(state["phi"]), numpy.array(state["phid"])
    acc = scope["phidd"](phi, rate, *time)
    near("Python", f"phidd of {what}", acc.tolist(), answer["phidd"])
    near("Python", f"lambda of {what}", scope["lambda_"](phi, rate, acc, *time).tolist(), answer["lambda"])


def octave(directory, script):
    """Runs a script; what it prints. Drawing does nothing: where tests run there may be no screen."""
    for name in ("subplot", "plot", "axis", "title", "xlabel"):
        (directory / f"{name}.m").write_text(f"function {name}(varargin)\nend\n")
    (directory / "program.m").write_text(script)
    ran = subprocess.run([OCTAVE, "--no-gui", "--no-history", "--norc", "-q", "program.m"], cwd=directory,
                         capture_output=True, text=True, timeout=600)
    check("Octave runs the scripts", ran.returncode == 0, ran.stderr[:500])
    return [[float(word) for word in line.split()] for line in ran.stdout.splitlines()]


def check_octave(cases):
    script = ""
    for _, code, state, _, *time in cases:
        functions = code.split("\nright =")[0]
        phi, rate = (" ".join(map(repr, state[name])) for name in ("phi", "phid"))
        now = "".join(f", {number!r}" for number in time)
        script += (f"{functions}\nphi = [{phi}].'; w = [{rate}].'; a = phidd(phi, w{now});\n"
                   f"printf('%.17g ', a); printf('\\n'); printf('%.17g ', lambda(phi, w, a{now})); printf('\\n');\n")
    with tempfile.TemporaryDirectory() as directory:
        lines = octave(pathlib.Path(directory), script)
    for (what, _, _, answer, *_), acc, force in zip(cases, lines[::2], lines[1::2], strict=True):
        near("Octave", f"phidd of {what}", acc, answer["phidd"])
        near("Octave", f"lambda of {what}", force, answer["lambda"])


def check_whole(server, tree, initial):
    """The programs from their first line to their last, against the trajectory."""
    answer = ask(server, "/v1/equations", {"pendulum": tree, "initial": initial})
    wanted = ask(server, "/v1/trajectories", {"pendulum": tree, "initial": initial, "times": {"stop": 5, "step": 0.01}})
    if OCTAVE:
        with tempfile.TemporaryDirectory() as directory:
            lines = octave(pathlib.Path(directory), answer["code"]["matlab"] +
                           "printf('%.17g ', x(end, 1:n)); printf('\\n'); printf('%.17g ', force(end, :)); printf('\\n');\n")
        near("Octave's ode45 over 5 s", "phi", lines[0], wanted["phi"][-1], 1e-5)
        near("Octave's ode45 over 5 s", "lambda", lines[1], wanted["lambda"][-1], 1e-5)
    if scipy and numpy:
        scope = {"__name__": "equations"}
        functions, _, program = answer["code"]["python"].partition('\nif __name__ == "__main__":\n')
        body = "\n".join(line[4:] for line in program.splitlines() if "plt" not in line and "tips" not in line and "forces." not in line)
        exec(compile(functions + "\n" + body, "equations", "exec"), scope)
        near("SciPy over 5 s", "phi", scope["x"][:scope["n"], -1].tolist(), wanted["phi"][-1], 1e-5)
    else:
        skip("SciPy", "SciPy or NumPy is not installed")


def check_curl(server, what, line, state):
    """The line for a shell asks for this pendulum's motion: its body answers, and the first sample is the start."""
    body = json.loads(re.search(r"-d '(.*)'$", line)[1]) | {"times": [0, 1e-3]}
    answer = ask(server, "/v1/trajectories", body)
    near("curl", what, answer["phi"][0], state["phi"])
    check(f"curl: the cart of {what}", body["initial"].get("cart") == state.get("cart"), line)


def check_real(server, cases, formulas):
    """The programs of real pendulums at two instants."""
    for what, tree in real_trees():
        cart = {"cart": {"x": 0.3, "v": -0.7}} if "cart" in tree.get("pivot", {}) else {}
        start = states(len(tree["arms"]))[0] | cart
        answer = ask(server, "/v1/equations", {"pendulum": tree, "initial": start})
        formulas += [(f"{name} of {what}", text) for name, text in answer["latex"].items()]
        check_curl(server, what, answer["curl"], start)
        for i, state in enumerate(states(len(tree["arms"]))[:2]):
            time = 0.7 * i
            forces = ask(server, "/v1/forces", {"pendulum": tree, "states": [state | cart], "time": time})
            row = {"phidd": forces["phidd"][0], "lambda": forces["lambda"][0]}
            if cart:  # the last entry of all vectors
                state = {"phi": state["phi"] + [cart["cart"]["x"]], "phid": state["phid"] + [cart["cart"]["v"]]}
                row["phidd"] = row["phidd"] + [forces["cart"]["acceleration"][0]]
            if numpy:
                check_python(what, answer["code"]["python"], state, row, time)
            if i:
                cases.append((what, answer["code"]["matlab"], state, row, time))


def main(build):
    cases, formulas = [], []
    with daemon(build) as server:
        for what, tree, form in trees():
            answer = ask(server, "/v1/equations", {"pendulum": tree, "form": form})
            forces = ask(server, "/v1/forces", {"pendulum": tree, "states": states(len(tree["parent"]))})
            formulas += [(f"{name} of {what}", text) for name, text in answer["latex"].items()]
            for s, state in enumerate(states(len(tree["parent"]))):
                row = {"phidd": forces["phidd"][s], "lambda": forces["lambda"][s], "z": {part: forces["z"][part][s] for part in ("re", "im")}}
                if form == "explicit":
                    check_formulas(what, answer["latex"], tree, state, row)
                if numpy:
                    check_python(what, answer["code"]["python"], state, row)
                if s == 0:
                    cases.append((what, answer["code"]["matlab"], state, row))
        check_real(server, cases, formulas)
        check_whole(server, REAL, {"phi": [0, -0.5], "phid": [0, 1]})
        check_whole(server, CART, {"phi": [0, -0.5], "phid": [0, 1], "cart": {"x": 0.1, "v": 1}})
        ruled = TABLES | {"friction": [{"torque": 0.1}, None], "stop": [None, {"min": -2}],
                          "control": [{"joint": 2, "period": 0.02, "delay": 1, "limit": [-5, 5], "law": {"pid": {"p": 1, "reference": 0}}}]}
        words = ask(server, "/v1/equations", {"pendulum": ruled})["latex"]
        formulas += [(f"{name} of rules", text) for name, text in words.items()]
        check_whole(server, TABLES, {"phi": [0, -0.5], "phid": [0, 1]})
        check_whole(server, PUSHED, {"phi": [0, -0.5], "phid": [0, 1], "cart": {"x": 0.1, "v": 1}})
        check_whole(server, {"length": [2, 1.5, 0.75, 1.25], "mass": [1, 1, 1, 0.1], "parent": [0, 1, 2, 2]},
                    {"phi": [0, -0.5, 0.25, 1], "phid": [0, 1, 0, -1]})
    if not numpy:
        skip("the Python programs", "NumPy is not installed")
    if OCTAVE:
        check_octave(cases)
    else:
        skip("the Octave scripts", "Octave is not installed")
    if shutil.which("node"):
        check_katex(formulas)
    else:
        skip("KaTeX", "Node.js is not installed")
    for kind, off in worst.items():
        print(f"worst of {kind}: {off:.1e}")
    return summary()


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1]))
