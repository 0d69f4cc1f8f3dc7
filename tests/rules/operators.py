"""Tests docker/monitoring with the metrics of a live server and by promtool; the backups of docker/README.md, taken while
jobs run and restored into a new store, on both databases; which versions may share a store; and a pooler for PostgreSQL.

Leaves to others: crashes (tests/drill), the deployment files (deploy.py). Invariant: a backup without a job, a part or
a bit is a fault; tests that need promtool or PostgreSQL are reported as skipped if these are missing.
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

import yaml

from rule import TOP, check, skip, summary
from house import JOBS, OCTETS, PATIENCE, SUMS, Daemon, walk
from places import place, postgres_programs

MONITORING = TOP / "docker/monitoring"
LITTLE = '{"pendulum":{"length":[1],"mass":[1],"parent":[0]}}'
LONG = {f"of {stop} s": ("/v1/trajectories", walk(stop, 2001)) for stop in (6000, 24000, 96000, 384000, 1536000)}
KINDS = JOBS | LONG
PARTS = ("--job-part-seconds", "0.03", "--job-lease-seconds", "5")


# --- alerts and the dashboard

def expressions():
    """What is asked of Prometheus, by whom."""
    rules = yaml.safe_load((MONITORING / "alerts.yaml").read_text())["groups"][0]["rules"]
    board = json.loads((MONITORING / "dashboard.json").read_text())
    check("every panel has a title, a unit and something to show", all(
        panel["title"] and panel["fieldConfig"]["defaults"]["unit"] and panel["targets"] for panel in board["panels"]))
    cells = [(panel["gridPos"]["x"], panel["gridPos"]["y"]) for panel in board["panels"]]
    check("no two panels of the dashboard lie upon each other", len(set(cells)) == len(cells), cells)
    found = [(rule["alert"], rule["expr"]) for rule in rules]
    found += [(panel["title"], target["expr"]) for panel in board["panels"] for target in panel["targets"]]
    found += [("keda", text) for text in re.findall(r"with the query (.*)[.]$", (MONITORING / "keda.yaml").read_text(), re.M)]
    return [(what, text.replace("$__rate_interval", "5m").replace("$instance", ".*")) for what, text in found]


def served(daemon):
    """The metrics of a server that has computed something, as they are served."""
    daemon.ask("POST", "/v1/modes", LITTLE)
    return daemon.ask("GET", "/metrics")[2].decode()


def against(text, asked):
    """Every name that is asked for is served, and so is every value of a label that is named in full."""
    names = set(re.findall(r"^([a-z_]+)[{ ]", text, re.M))
    labels = set(re.findall(r'([a-z]+)="([^"]*)"', text))
    for what, expression in asked:
        for name in set(re.findall(r"\b(?:pendulumd|process)_[a-z_]+", expression)):
            check(f"{what}: {name} is served", name in names)
        for label, value in re.findall(r'([a-z]+)!?="([^"]*)"', expression):
            known = label == "status" or (label, value) in labels
            check(f'{what}: {label}="{value}" is served', known)
        for label, values in re.findall(r'([a-z]+)=~"([a-z|-]+)"', expression):
            check(f"{what}: each of {values} is served", all((label, value) in labels for value in values.split("|")))


def promtool(text, asked):
    tool = shutil.which("promtool") or os.environ.get("PROMTOOL")
    if not tool:
        skip("promtool", "it is not here (Debian: prometheus)")
        return

    def run(what, *words, **more):
        ended = subprocess.run([tool, *words], cwd=MONITORING, capture_output=True, text=True, **more)
        check(what, ended.returncode == 0, ended.stdout + ended.stderr)

    run("promtool finds nothing in the metrics", "check", "metrics", input=text)
    run("promtool finds nothing in the alert rules", "check", "rules", "alerts.yaml")
    run("every alert fires when it should, and else does not", "test", "rules", "alerts_test.yaml")
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        rules = [{"record": f"expression:{i}", "expr": expression} for i, (_, expression) in enumerate(asked)]
        yaml.safe_dump({"groups": [{"name": "all", "rules": rules}]}, file)
        file.flush()
        run("every expression is one of Prometheus", "check", "rules", file.name)
    tried = {row["alertname"] for one in yaml.safe_load((MONITORING / "alerts_test.yaml").read_text())["tests"]
             for row in one["alert_rule_test"] if row["exp_alerts"]}
    alerts = {what for what, _ in asked if what.startswith("Pendulumd")}
    check("every alert is seen to fire", alerts <= tried, alerts - tried)


# --- the values of the metrics of jobs

def metrics(daemon):
    """Name and labels, and value, of each line."""
    text = daemon.ask("GET", "/metrics")[2].decode()
    return {key: float(value) for key, value in (line.rsplit(" ", 1) for line in text.splitlines() if line[0] != "#")}


def until(daemon, key, value):
    """The metrics once one of them has a value: the store is asked for its figures once a second."""
    end = time.monotonic() + PATIENCE
    while (found := metrics(daemon))[key] != value and time.monotonic() < end:
        time.sleep(0.05)
    return found


def values(build, directory):
    """A job waits for a worker, which comes, computes it and goes."""
    with place("postgres") as store:
        api = Daemon(build, store.url, "api", directory, PARTS)
        begun = time.monotonic()
        job = submitted(api, "map")
        time.sleep(3)
        found, passed = metrics(api), time.monotonic() - begun
        oldest = found["pendulumd_job_oldest_waiting_seconds"]
        check("the oldest job that waits has its age, of a second ago", 1 < oldest < passed and passed - oldest < PATIENCE / 10, (oldest, passed))
        waiting, workers = found["pendulumd_job_parts_waiting"], found["pendulumd_store_workers"]
        check("the parts of a job are counted while no worker is there", waiting > 1 and workers == 0, (waiting, workers))
        connected = store.rows("SELECT COUNT(*) FROM pg_stat_activity WHERE application_name LIKE 'pendulumd%'")[0][0]
        check("an api has three connections to the store", found["pendulumd_store_connections"] == connected == 3, connected)
        worker = Daemon(build, store.url, "worker", directory, PARTS)
        check("a job ends when a worker comes", ended(api, job)["status"] == "successful")
        passed, connected = time.monotonic() - begun, until(api, "pendulumd_store_workers", 1)["pendulumd_store_connections"]
        check("a worker is counted, and its connection", connected == 4, connected)
        check("no job waits once all have ended", until(api, "pendulumd_job_oldest_waiting_seconds", 0)["pendulumd_job_parts_waiting"] == 0)
        found = metrics(worker)

        def of(stage):
            return [found[f'pendulumd_job_duration_seconds_{what}{{stage="{stage}"}}'] for what in ("count", "sum")]
        (waits, waited), (runs, ran) = of("wait"), of("run")
        check("a job waits once, from its submission to its first part", waits == 1 and 3 <= waited <= passed, (waits, waited, passed))
        check("each part is timed from its claim to its result", runs == waiting and 0 < ran <= passed * runs, (runs, waiting, ran, passed))
        check("a wait of three seconds is not in the bucket of 1 s", found['pendulumd_job_duration_seconds_bucket{stage="wait",le="1"}'] == 0
              and found['pendulumd_job_duration_seconds_bucket{stage="wait",le="+Inf"}'] == 1, (waits, waited))
        worker.kill()
        connected = until(api, "pendulumd_store_workers", 0)["pendulumd_store_connections"]
        check("a worker that was killed is not counted", connected == 3, connected)
        api.kill(15)


# --- a pooler

def pooled(build, directory):
    """PgBouncer in front of PostgreSQL: a pool of transactions is refused in a sentence, a pool of sessions works."""
    with place("postgres") as store:
        for mode in ("transaction", "session"):
            pathlib.Path(store.directory, "pool.ini").write_text(
                f"[databases]\n* = host={store.directory} user=pendulumd\n[pgbouncer]\nunix_socket_dir = {store.directory}\nlisten_addr =\n"
                f"listen_port = 6432\nauth_type = any\npool_mode = {mode}\n", encoding="utf-8")
            pooler = store.spawn(shutil.which("pgbouncer"), "pool.ini")
            try:
                end = time.monotonic() + PATIENCE
                while not pathlib.Path(store.directory, ".s.PGSQL.6432").exists() and time.monotonic() < end:
                    time.sleep(0.01)
                daemon = Daemon(build, f"{store.url}&port=6432", "all", directory)
                if mode == "session":
                    check("a job is computed through a pool of sessions", ended(daemon, submitted(daemon, "map"))["status"] == "successful")
                else:
                    check("a pool of transactions is refused", False, daemon.log.read_text())
                daemon.kill(15)
            except RuntimeError as error:
                said = str(error).strip().splitlines()
                check("a pool of transactions is refused in one sentence", mode == "transaction" and len(said) == 1 and "PgBouncer" in said[0], said)
            finally:
                pooler.terminate()
                pooler.wait(PATIENCE)


# --- backups

def back_up(store, directory):
    """As docker/README.md says, while daemons write; what a restore needs."""
    if store.name == "sqlite":
        copy = pathlib.Path(directory, "copy.db")
        subprocess.run(["sqlite3", store.file, f".backup {copy}"], check=True, timeout=300)
        return copy
    store.run("pg_dump", "-Fc", "-f", "backup", "-d", store.url)
    return pathlib.Path(store.directory, "backup")


def restore(copy, store):
    """Into a store in which nothing is."""
    if store.name == "sqlite":
        shutil.copy(copy, store.file)
        return
    shutil.copy(copy, pathlib.Path(store.directory, "backup"))
    os.chmod(pathlib.Path(store.directory, "backup"), 0o644)
    store.run("pg_restore", "--exit-on-error", "-d", store.url, "backup")


def results(daemon, job):
    return daemon.ask("GET", f"/v1/jobs/{job}/results", headers={"Accept": OCTETS})[2]


def over(view):
    return view["status"] not in ("accepted", "running")


def awaited(daemon, job, is_there):
    """What a job is once that is there, or it is over, or patience is."""
    end = time.monotonic() + PATIENCE
    while not is_there(view := json.loads(daemon.ask("GET", f"/v1/jobs/{job}")[2])) and not over(view) and time.monotonic() < end:
        time.sleep(0.005)
    return view


def ended(daemon, job):
    return awaited(daemon, job, over)


def submitted(daemon, kind):
    path, body = KINDS[kind]
    status, fields, text = daemon.ask("POST", path, body, {"Prefer": "respond-async", "Job-Title": kind})
    check(f"a job {kind} is accepted", status == 202, text)
    return fields["Location"].rsplit("/", 1)[1]


def backed_up(daemon, store, directory):
    """A backup and a job that had a part before it and was not over after it: a longer one until that is so."""
    for kind in LONG:
        job = submitted(daemon, kind)
        awaited(daemon, job, lambda view: view["parts"]["done"])
        copy = back_up(store, directory)
        view = awaited(daemon, job, lambda view: True)
        if not over(view):
            break
    check(f"{store.name}: a job is under way before a backup and after it", view["status"] == "running" and view["parts"]["done"], view)
    return copy, job, view["parts"]


def drill(build, kind, directory):
    """One finished job, one under way and a scene are in the backup, and what comes after it is not."""
    with place(kind) as store, place(kind) as other:
        first = Daemon(build, store.url, "all", directory, PARTS)
        done = submitted(first, "map")
        view = ended(first, done)
        right = {done: results(first, done)}
        scene = json.loads(first.ask("POST", "/v1/scenes", '{"request":' + LITTLE[:-1] + ',"times":{"stop":1,"step":0.1}}}')[2])["id"]
        copy, open_, parts = backed_up(first, store, directory)
        later = submitted(first, "map")
        check(f"{kind}: the job under way ends where it was", ended(first, open_)["status"] == "successful")
        right[open_] = results(first, open_)
        first.kill()
        restore(copy, other)
        states = dict(other.rows("SELECT id, state FROM jobs"))
        check(f"{kind}: the backup was taken while a job was under way", states.get(open_) == 1, states)
        second = Daemon(build, other.url, "all", directory, PARTS)
        check(f"{kind}: what had ended is there as it was", {**ended(second, done), "remaining_seconds": 0} == {**view, "remaining_seconds": 0})
        check(f"{kind}: a job under way at the backup goes on and ends", ended(second, open_)["status"] == "successful", parts)
        for job, bits in right.items():
            check(f"{kind}: its results are the same to the bit", bits and results(second, job) == bits, job)
        check(f"{kind}: a scene is there", second.ask("GET", f"/v1/scenes/{scene}")[0] == 200)
        check(f"{kind}: what came after the backup is not", second.ask("GET", f"/v1/jobs/{later}")[0] == 404)
        check(f"{kind}: new jobs are taken", ended(second, submitted(second, "map"))["status"] == "successful")
        for what, command in SUMS:
            rows = [] if "drill_kept" in command else other.rows(command)
            check(f"{kind}: {what} agrees", not rows, rows)
        upgrade(build, kind, other, second, directory)
        second.kill(15)


def upgrade(build, kind, store, daemon, directory):
    """What a process does when a newer one has changed the tables under it: it goes on without the store, and no other
    of its version starts."""
    store.rows("UPDATE pendulumd SET version = version + 1")
    status, _, text = daemon.ask("POST", "/v1/modes", LITTLE, {"Prefer": "respond-async"})
    check(f"{kind}: an older program takes no job of newer tables", status == 503, text)
    check(f"{kind}: it says so to a load balancer of jobs", daemon.ask("GET", "/readyz?need=jobs")[0] == 503)
    check(f"{kind}: it answers what needs no store", daemon.ask("POST", "/v1/modes", LITTLE)[0] == 200)
    try:
        Daemon(build, store.url, "all", directory).kill(15)
        said = "it started"
    except RuntimeError as error:
        said = str(error)
    check(f"{kind}: an older program does not start on newer tables", "this program needs version" in said, said)
    store.rows("UPDATE pendulumd SET version = version - 1")


def main(build):
    with tempfile.TemporaryDirectory(prefix="pendulumd-operators-") as directory:
        asked = expressions()
        daemon = Daemon(build, f"sqlite:{directory}/metrics.db", "all", directory)
        text = served(daemon)
        daemon.kill(15)
        against(text, asked)
        promtool(text, asked)
        if shutil.which("sqlite3"):
            drill(build, "sqlite", directory)
        else:
            skip("a backup of SQLite", "sqlite3 is not here")
        if postgres_programs():
            drill(build, "postgres", directory)
            values(build, directory)
        else:
            skip("PostgreSQL's backup and metrics", "it is not here")
        if postgres_programs() and shutil.which("pgbouncer"):
            pooled(build, directory)
        else:
            skip("a pooler in front of PostgreSQL", "pgbouncer is not here")
    return summary()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
