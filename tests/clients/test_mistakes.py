"""The table of mistakes.txt: what each client says of a typical mistake.

Leaves to others: the sentences of every field (tests/api). Invariant: what is not installed is skipped aloud; every mistake is made.
"""
import json
import os
import pathlib
import shlex
import subprocess

from clients import DOUBLE, TOP
from rule import OCTAVE, check, optional, skip
from servers import tool

SCRIPT = {
    "js": """import { Client, Pendulum } from "pendulumd";
const double = new Pendulum(%s), said = [];
for (const mistake of JSON.parse(process.argv[1]))
  said.push(await Promise.resolve().then(() => (0, eval)(`(Client, Pendulum, double) => ${mistake}`)(Client, Pendulum, double)).then(() => "", String));
console.log(JSON.stringify(said));""" % json.dumps(DOUBLE),
    "octave": "addpath(argv(){1}); mistakes = jsondecode(argv(){2}); for k = 1:numel(mistakes); said = ''; try; eval([mistakes{k} ';']); catch e; said = e.message; end; printf('%s\\0', said); end"}


def python(mistakes, home):
    import pendulumd
    names = vars(pendulumd) | {"double": pendulumd.Pendulum(**DOUBLE)}
    for mistake in mistakes:
        try:
            yield "\n".join(eval(mistake, names).warnings)
        except Exception as error:
            yield "\n".join([str(error), *getattr(error, "__notes__", ())])


def lines(command, mistakes, home):
    for mistake in mistakes:
        done = subprocess.run([*command(mistake)], cwd=home, capture_output=True, text=True, timeout=60)
        yield done.stdout + done.stderr


def cli(mistakes, home):
    return lines(lambda mistake: ["pendulum", *shlex.split(mistake)], mistakes, home)


def curl(mistakes, home):
    url = os.environ["PENDULUM_URL"]
    return lines(lambda mistake: ["curl", "-s", *[url + word if word.startswith("/v1/") else word for word in shlex.split(mistake)]], mistakes, home)


def js(mistakes, home):
    done = subprocess.run([tool("node"), "--input-type=module", "--eval", SCRIPT["js"], json.dumps(mistakes)], cwd=home, capture_output=True, text=True, timeout=300)
    check("mistakes: js comes to its end", done.returncode == 0, done.stderr)
    return json.loads(done.stdout or "[]")


def octave(mistakes, home):
    (home / "mistakes.m").write_text(SCRIPT["octave"])
    command = [OCTAVE, "--norc", "--quiet", "mistakes.m", TOP / "api/clients/octave", json.dumps(mistakes)]
    return subprocess.run(command, cwd=home, capture_output=True, text=True, timeout=300).stdout.split("\0")[:-1]


def test_mistakes(server, home):
    os.environ["PATH"] = f"{pathlib.Path(os.environ['PENDULUM_BUILD'])}:{os.environ['PATH']}"
    token = os.environ.pop("PENDULUM_TOKEN")
    (home / "double.json").write_text(json.dumps(DOUBLE))
    (home / "broken.json").write_text('{"length": [1,],')
    (home / "track.csv").write_text("t,theta\n0,1\n")
    there = {"python": optional("pendulumd"), "cli": True, "js": (home / "js/dist").exists(), "octave": OCTAVE, "curl": tool("curl")}
    for part in (TOP / "tests/clients/mistakes.txt").read_text(encoding="utf-8").split("\n@ ")[1:]:
        client, *rows = [line for line in part.splitlines() if line]
        if not there[client]:
            skip(f"the mistakes in {client}", "it is not here")
            continue
        mistakes, wanted = zip(*(row.split(" => ") for row in rows))
        said = list(globals()[client](mistakes, home))
        check(f"mistakes: {client} makes every one", len(said) == len(rows), f"{len(said)} of {len(rows)}")
        for mistake, words, text in zip(mistakes, wanted, said):
            lacks = [word for word in words.split("; ") if word not in text.replace('\\"', '"')]
            check(f"mistakes: {client}: {mistake}", not lacks, f"does not say {lacks}: {text}")
    os.environ["PENDULUM_TOKEN"] = token
