"""Runs the programs of docker/growth.md (with a stand-in for sbatch) and compares their output with the page; then tests batch
workers that end early, and the statements of keda.yaml and slurm.timer.sh on a real PostgreSQL.

usage: growth.py BUILD     (build/release)
Leaves to others: a real Slurm (tests/drill/slurm.py). Invariant: all files are in a folder that is removed at the end.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

import yaml

from rule import TOP, check, optional, skip, summary
from servers import daemon

BLOCK = re.compile(r"```(sh|parallel|slurm|dask|duckdb|python)\n(.*?)```\n\n```\n(.*?)```", re.S)
DUCKDB = TOP / "build/readers/node_modules/@duckdb/node-api/lib/index.js"  # what tests/rules/readback.sh fetches
SELECT = """const found = await (await (await (await import(process.argv[1])).DuckDBInstance.create(":memory:")).connect()).runAndReadAll(process.argv[2]);
console.log(found.getRows().map(String).join("\\n"));"""
NEEDS = {"duckdb": DUCKDB.exists, "parallel": lambda: shutil.which("parallel"), "dask": lambda: optional("distributed"), "python": lambda: optional("numpy")}
# sbatch of one machine: the tasks of an array one after the other, a second time if one asks for that; a job that depends on others runs if they succeeded
SBATCH = r"""#!/usr/bin/python3
import os, re, subprocess, sys
words, array = sys.argv[1:], []
while words and words[0].startswith("--") and words[0] != "--wrap":
    word = words.pop(0)
    array = [int(x) for x in re.findall(r"[0-9]+", word)] if word.startswith("--array=") else array
    if word.startswith("--dependency=afterok:") and os.path.exists(f"job-{word.rpartition(':')[2]}.failed"):
        sys.exit("a dependency failed")
if words[0] == "--wrap":
    sys.exit(subprocess.run(["sh", "-c", words[1]]).returncode)
job = str(os.getpid())
for task in range(array[0], array[-1] + 1):
    for again in range(5):
        status = subprocess.run(words, stdout=2, env=os.environ | {"SLURM_ARRAY_JOB_ID": job, "SLURM_JOB_ID": job, "SLURM_ARRAY_TASK_ID": str(task),
                                                                   "SLURM_ARRAY_TASK_MAX": str(array[-1]), "SLURM_RESTART_COUNT": str(again)}).returncode
        if not os.path.exists(f"requeue-{job}_{task}"):
            break
        os.remove(f"requeue-{job}_{task}")
    if status:
        open(f"job-{job}.failed", "w").close()
print(job)
"""


def fits(shown, output):
    return re.fullmatch(".*".join(re.escape("".join(part.split())) for part in shown.split("...")), "".join(output.split()), re.S)


def script(path, text):
    path.write_text(text)
    path.chmod(0o755)


def stand_ins(folder):
    folder.mkdir()
    (folder / "python3").symlink_to("/usr/bin/python3")
    for name, text in (("sbatch", SBATCH), ("scontrol", '#!/bin/sh\necho "$2" >> requeued\n: > "requeue-$2"\n'), ("squeue", "#!/bin/sh\ncat there 2>/dev/null || :\n")):
        script(folder / name, text)


def page(build, home, url):
    environment = os.environ | {"PATH": f"{home / 'bin'}:{TOP / build}:{os.environ['PATH']}", "PYTHONPATH": str(TOP / "api/clients/python"), "PENDULUM_URL": url}
    for language, program, shown in BLOCK.findall((TOP / "docker/growth.md").read_text(encoding="utf-8")):
        if not NEEDS.get(language, lambda: True)():
            skip(f"growth.md: {language}", "it is not installed")
            continue
        (home / "program.py").write_text(program)
        command = ["node", "--input-type=module", "-e", SELECT, DUCKDB, program] if language == "duckdb" else ["/usr/bin/python3", "program.py"] if language in ("dask", "python") else ["bash", "-euc", program]
        done = subprocess.run(command, capture_output=True, text=True, timeout=600, cwd=home, env=environment)
        check(f"growth.md: {language}", done.returncode == 0 and fits(shown, done.stdout), f"\n{program}\n--- prints\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return environment


def parts(home, environment):
    """Exit statuses of parts, a task that is queued again, and files that were altered or are missing."""
    def run(*words, **more):
        return subprocess.run(words, cwd=home, env=environment | more, capture_output=True, text=True)
    local = ("pendulum", "ask", "ensembles", "request.json", "--local", "--part")
    for part, out, status in (("1/4", "set/again.parquet", 0), ("5/4", "x.csv", 65), ("1/4", "x.png", 65), ("1/4", "nowhere/x.csv", 75), ("1/9999", "x.csv", 65), ("4", "x.csv", 65)):
        done = run(*local, part, "-o", out)
        check(f"part {part} into {out}: status {status}", done.returncode == status, done)
    read = run("python3", "-c", "from pendulumd.dataset import parts; print(sum(len(part['final_phi_2']) for part in parts('set/manifest.json')))")
    check("Python reads all parts of a manifest", read.stdout == "4000\n", read)
    check("a part is the same each time", (home / "set/again.parquet").read_bytes() == (home / "set/part-00001.parquet").read_bytes())
    whole = run("pendulum", "ask", "ensembles", "request.json", "--local").stdout.splitlines()
    each = [line for k in range(1, 8) for line in run(*local, f"{k}/7").stdout.splitlines()[k > 1:] if not line.startswith("#")]
    check("the rows of all parts are those of the whole", each == [line for line in whole if not line.startswith("#")], len(each))
    (home / "set-slurm/part-00002.parquet").write_bytes(b"PAR1 other bytes PAR1")
    check("an altered part is named", "part-00002.parquet is not the file" in run("python3", "-m", "pendulumd.dataset", "set-slurm").stderr)
    os.remove(home / "set-slurm/part-00002.parquet")
    check("a missing part is named", "part 2 is missing" in run("python3", "-m", "pendulumd.dataset", "set-slurm").stderr)
    script(home / "short", '#!/bin/sh\n[ -e tried ] || { : > tried; exit 75; }\nexec pendulum "$@"\n')
    done = run("sbatch", "--parsable", "--array=1-2", str(TOP / "docker/parts.sbatch"), "request.json", "set-again", PENDULUM=str(home / "short"))
    check("a task that ends with 75 is queued again", done.returncode == 0 and (home / "requeued").read_text().count("\n") == 1 and len(list((home / "set-again").glob("*.sha256"))) == 2, done)
    long = subprocess.Popen([*local, "1/1", "-s", "random.count=3000000", "-o", "long.parquet"], cwd=home, env=environment)
    while long.poll() is None and not list(home.glob("long.parquet.part-*")):
        time.sleep(0.01)
    long.terminate()
    check("a part that is told to end says 75 and leaves nothing", long.wait() == 75 and not list(home.glob("long.parquet*")))


def workers(build, home, environment):
    """A batch worker that is told to end while work is left, and one that has none."""
    store = f"sqlite:{home}/queue.db"
    with daemon(build, "--store", store, "--role", "api") as server:
        environment = environment | {"PENDULUM_URL": f"http://127.0.0.1:{server.port}"}
        subprocess.run(["pendulum", "ask", "ensembles", "request.json", "--detach", "-s", "random.count=20000000"], cwd=home, env=environment, check=True, stdout=subprocess.DEVNULL)
        command = [TOP / build / "pendulumd", "--store", store, "--role", "worker", "--listen", "127.0.0.1:0", "--until-idle-seconds", "30", "--access-log", "off"]
        for what, left in (("with work left ends with 75", 75), ("without work ends with 0", 0)):
            worker = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=os.environ | {"PENDULUMD_ALLOW_ROOT": "on"})
            worker.stderr.readline()
            time.sleep(3)
            worker.terminate()
            check(f"a batch worker {what}", worker.wait(60) == left, worker.returncode)
            subprocess.run("pendulum jobs | cut -d' ' -f1 | xargs -n 1 pendulum cancel", shell=True, env=environment, check=True, stdout=subprocess.DEVNULL)


def statements(build, home, environment):
    """What KEDA and the timer ask of PostgreSQL."""
    sys.path.insert(0, str(TOP / "tests/drill"))
    from places import place
    if not shutil.which("psql") or not os.path.isdir("/usr/lib/postgresql"):
        return skip("statements on PostgreSQL", "it is not installed")
    query = yaml.safe_load((TOP / "docker/monitoring/keda.yaml").read_text())["spec"]["triggers"][0]["metadata"]["query"]
    with place("postgres") as store, daemon(build, "--store", store.url, "--role", "api") as server:
        environment = environment | {"PENDULUM_URL": f"http://127.0.0.1:{server.port}", "PENDULUMD_STORE": store.url, "PARTS": "1", "MOST": "3"}
        for waits in range(3):
            asked = subprocess.run(["psql", "-XAtq", store.url, "-c", query], capture_output=True, text=True, check=False).stdout.strip()
            check(f"KEDA's query counts {waits} parts that wait", asked == str(waits), asked)
            subprocess.run(["pendulum", "ask", "ensembles", "request.json", "--detach"], cwd=home, env=environment, check=True, stdout=subprocess.DEVNULL)
        (home / "there").write_text("one\n")
        script(home / "worker", '#!/bin/sh\necho "$SLURM_ARRAY_TASK_ID" >> started\n')
        done = subprocess.run([TOP / "docker/slurm.timer.sh"], cwd=home, env=environment | {"PENDULUMD": str(home / "worker")}, capture_output=True, text=True, check=False)
        check("the timer starts the workers that are missing", done.returncode == 0 and (home / "started").read_text() == "1\n2\n", done)


def main():
    build = sys.argv[1]
    with tempfile.TemporaryDirectory(prefix="pendulumd-growth-") as top:
        home = pathlib.Path(top)
        (home / "docker").symlink_to(TOP / "docker")
        stand_ins(home / "bin")  # sbatch, scontrol and squeue of one machine; Debian's python3, which has NumPy
        (home / "results").mkdir()
        with daemon(build, "--store", f"sqlite:{home}/store.db", "--results", f"file://{home}/results", "--job-part-seconds", "0.05") as server:
            environment = page(build, home, f"http://127.0.0.1:{server.port}")
        parts(home, environment)
        environment["PENDULUM_TOKEN"] = "0123456789abcdef0123456789abcdef"
        workers(build, home, environment)
        statements(build, home, environment)
    sys.exit(summary())


main()
