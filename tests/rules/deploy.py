"""The files that put pendulumd on several processes: what they refer to is there; and what docker/compose.yaml describes,
run for real without containers: PostgreSQL, its api and worker processes, nginx with docker/nginx.conf before them.

usage: deploy.py BUILD
Leaves to others: nginx by itself (nginx.py), Slurm (tests/drill/slurm.py), the image (image.sh).
Invariant: everything listens on loopback or a Unix socket; a program that is not installed is skipped aloud.
"""
import http.client
import json
import pathlib
import random
import re
import secrets
import subprocess
import sys
import tempfile
import time

import yaml

from rule import TOP, check, shipped_nginx, skip, summary
from house import JOBS, OCTETS, Daemon, House, undisturbed
from places import place, postgres_programs
from servers import nginx, tool

BUILD = pathlib.Path(sys.argv[1]).resolve()


def known(what, names, right):
    wrong = set(names) - set(right)
    check(what, names and not wrong, f"{sorted(wrong)} of {sorted(names)}")


def options():
    text = subprocess.run([BUILD / "pendulumd", "--help=markdown"], capture_output=True, text=True, check=True).stdout
    return {"PENDULUMD_" + name.replace("-", "_").upper() for name in re.findall(r"^\| `--([\w-]+)", text, re.M)}


def defaults():
    text = subprocess.run([BUILD / "pendulumd", "--help=markdown"], capture_output=True, text=True, check=True).stdout
    return dict(re.findall(r"^\| `--([\w-]+)[^|]*\| `?([^`|]*)`? \|", text, re.M))


def lasts(what, grace, drain):
    """A computation outlives a drain, and a drain is not cut short: the end of the last answers takes 5 s more at most."""
    check(f"{what}: a drain is longer than a computation", drain > float(defaults()["max-compute-seconds"]), drain)
    check(f"{what}: a drain has its time", grace >= drain + 5, f"{grace} s for {drain} s")


# --- what the files refer to

def compose(name):
    text = (TOP / "docker" / name).read_text()
    document = yaml.safe_load(text)
    services = document["services"]
    used = {key: set() for key in ("networks", "volumes")}
    for service, body in services.items():
        for needed, how in (body.get("depends_on") or {}).items():
            check(f"{name}: {service} waits for {needed}", needed in services and
                  (how["condition"] != "service_healthy" or "healthcheck" in services[needed] or services[needed].get("image") == "pendulumd"))
        used["networks"] |= set(body["networks"])
        for volume in body.get("volumes", ()):
            source = volume.split(":")[0]
            if source.startswith("."):
                check(f"{name}: {source} is there", (TOP / "docker" / source).exists())
            else:
                used["volumes"].add(source)
    for key, names in used.items():
        check(f"{name}: its {key}", names == set(document[key]), f"{names} are used, {set(document[key])} are there")
    variables = {variable for body in services.values() for variable in body.get("environment", {}) if variable.startswith("PENDULUMD_")}
    known(f"{name}: its options", variables, options())
    for service in (service for service in services.values() if service.get("image") == "pendulumd"):
        drain = float(service["environment"].get("PENDULUMD_DRAIN_SECONDS", defaults()["drain-seconds"]))
        lasts(name, float(service["stop_grace_period"].rstrip("s")), drain)
    upstream = re.search(r"set \$pendulumd (\w+):(\d+);", (TOP / "docker/nginx.conf").read_text())
    check(f"{name}: nginx finds {upstream[1]}", set(services[upstream[1]]["networks"]) & set(services["nginx"]["networks"]))
    check(f"{name}: nginx alone is published", [service for service, body in services.items() if "ports" in body] == ["nginx"])
    proxy = services[upstream[1]]["environment"].get("PENDULUMD_TRUSTED_PROXY")
    check(f"{name}: nginx is trusted", proxy == document["networks"]["inside"]["ipam"]["config"][0]["subnet"], proxy)
    return services


def labels_of(document):
    return document["spec"]["template"]["metadata"]["labels"]


def kubernetes():
    documents = list(yaml.safe_load_all((TOP / "docker/kubernetes.yaml").read_text()))
    named = {(document["kind"], document["metadata"]["name"]): document for document in documents}
    check("kubernetes.yaml: its names differ", len(named) == len(documents))
    deployments = [document for document in documents if document["kind"] == "Deployment"]
    secret = re.search(r"create secret generic (\w+) --from-literal=(\w+)=", (TOP / "docker/kubernetes.yaml").read_text())
    router = (TOP / "server/router.c").read_text()
    for document in deployments:
        name, pod = document["metadata"]["name"], document["spec"]["template"]["spec"]
        container, = pod["containers"]
        ports = {port["name"]: port["containerPort"] for port in container["ports"]}
        check(f"{name}: its selector", document["spec"]["selector"]["matchLabels"] == labels_of(document))
        known(f"{name}: its options", {entry["name"] for entry in container["env"]}, options())
        given = {entry["name"]: entry.get("value") for entry in container["env"]}
        if given["PENDULUMD_ROLE"] != "worker":
            pause = container.get("lifecycle", {}).get("preStop", {}).get("sleep", {}).get("seconds", 0)
            lasts(name, pod["terminationGracePeriodSeconds"] - pause, float(given.get("PENDULUMD_DRAIN_SECONDS", defaults()["drain-seconds"])))
        for entry in container["env"]:
            key = entry.get("valueFrom", {}).get("secretKeyRef")
            if key:
                check(f"{name}: its secret", (key["name"], key["key"]) == secret.groups(), key)
        for probe in ("startupProbe", "livenessProbe", "readinessProbe"):
            get = container[probe]["httpGet"]
            check(f"{name}: its {probe}", get["port"] in ports and f'"{get["path"]}"' in router, get)
        scrape = document["spec"]["template"]["metadata"]["annotations"]
        check(f"{name}: its metrics", f'"{scrape["prometheus.io/path"]}"' in router and int(scrape["prometheus.io/port"]) in ports.values(), scrape)
    for document in documents:
        name, spec = document["metadata"]["name"], document["spec"]
        if document["kind"] in ("Service", "PodDisruptionBudget"):
            selector = spec["selector"].get("matchLabels", spec["selector"])
            check(f"{name}: the {document['kind']} finds its pods", [pods for pods in deployments if selector.items() <= labels_of(pods).items()])
        if document["kind"] == "HorizontalPodAutoscaler":
            target = spec["scaleTargetRef"]
            check(f"{name}: what is scaled", named[target["kind"], target["name"]]["spec"].get("replicas") is None, "both say how many")
            for metric in spec["metrics"]:
                metric = metric["external"]["metric"]["name"]
                check(f"{name}: the metric {metric}", f'"{metric}"' in (TOP / "server/metrics.h").read_text())


# --- the same live

class Front:
    """nginx, asked as a Daemon is."""

    ask, role = Daemon.ask, "front"

    def __init__(self, port):
        self.port = port


def settled(front, method, path, body=None, headers=None):
    """An answer that is none of the proxy's limit of requests."""
    while (answer := front.ask(method, path, body, headers))[0] == 429:
        time.sleep(0.2)
    return answer


def any_answers(front, apis, right):
    """Every job is everybody's, whoever took it."""
    jobs, token = {}, {"Authorization": f"Bearer {secrets.token_hex(16)}"}
    for i, kind in enumerate(("map", "walk", "map", "walk")):
        path, body = JOBS[kind]
        answers = [settled(front, "POST", path, body, {"Prefer": "respond-async", "Idempotency-Key": f"key-{i}"} | token) for _ in range(3)]
        check("a key makes one job, whoever is asked", {status for status, *_ in answers} == {202} and
              len({headers["Location"] for _, headers, _ in answers}) == 1, answers)
        jobs[answers[0][1]["Location"]] = kind
    for location, kind in jobs.items():
        end = time.monotonic() + 300
        while (view := json.loads(apis[0].ask("GET", location)[2]))["status"] in ("accepted", "running") and time.monotonic() < end:
            time.sleep(0.02)
        check("it ends well", view["status"] == "successful", view)
        for who in (*apis, front):
            status, _, data = settled(who, "GET", location + "/results", headers={"Accept": OCTETS})
            check("the results are those of an undisturbed answer", status == 200 and data == right[kind], f"{status}, {len(data)} bytes")
    lists = [json.loads(settled(front, "GET", "/v1/jobs", headers=token)[2])["jobs"] for _ in range(4)]
    check("whoever lists them, they are the client's", all({f"/v1/jobs/{job['id']}" for job in jobs_} == set(jobs) for jobs_ in lists), lists)
    return next(iter(jobs))


def one_dies(front, house, apis, job):
    """An api process that is gone is not asked any more, and nobody notices."""
    apis.pop(0).kill()
    house.daemons = [daemon for daemon in house.daemons if daemon.process.poll() is None]
    path, body = JOBS["walk"]
    for _ in range(4):
        answers = [settled(front, "GET", job)[0], settled(front, "POST", path, body, {"Prefer": "respond-async"})[0]]
        check("an api process dies and nobody notices", answers == [200, 202], answers)


def live(services):
    if not postgres_programs() or not tool("nginx"):
        skip("the processes of compose.yaml", "postgresql or nginx-light is not installed")
        return
    with tempfile.TemporaryDirectory(prefix="pendulumd-drill-") as directory, place("postgres") as store:
        right = undisturbed(BUILD, directory)
        house = House(BUILD, store, random.Random(1), directory, right)
        try:
            for body in services.values():
                if body.get("image") == "pendulumd":
                    for _ in range(body["deploy"]["replicas"]):
                        house.start(body["environment"]["PENDULUMD_ROLE"], "--trusted-proxy", "127.0.0.1/32")
            apis = [daemon for daemon in house.daemons if daemon.role == "api"]
            check("two answer, two compute", (len(apis), len(house.daemons)) == (2, 4), [daemon.role for daemon in house.daemons])
            with nginx(shipped_nginx([api.port for api in apis])) as server:
                front = Front(server.port)
                job = any_answers(front, list(apis), right)
                one_dies(front, house, apis, job)
        finally:
            house.close()


try:
    compose("compose.one.yaml")
    kubernetes()
    live(compose("compose.yaml"))
except (OSError, http.client.HTTPException, RuntimeError, KeyError) as error:
    check("it runs", False, repr(error))
sys.exit(summary())
