"""Tests the deployment files: whatever they refer to exists; and the processes of docker/compose.yaml are run without
containers: PostgreSQL, api and worker processes, and nginx with docker/nginx.conf in front of them.

usage: deploy.py BUILD
Leaves to others: nginx alone (nginx.py), Slurm (tests/drill/slurm.py), the image (image.sh).
Invariant: everything listens on loopback or a Unix socket; tests of programs that are not installed are reported as skipped.
"""
import http.client
import json
import os
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


def contained(what, service):
    """A container of compose without root, without capabilities, with nothing to write but memory and volumes."""
    own = service["image"] == "pendulumd"
    bounded(what, service)
    check(f"{what}: another image can be named", own or re.fullmatch(r"\$\{[A-Z]+_IMAGE:-[\w./-]+:[\w.-]+\}", service["image"]), service["image"])


def bounded(what, service):
    """What holds in the file as it is written, and as the engine reads it."""
    own = service["image"] == "pendulumd"
    user = str(service.get("user") or (re.search(r"^USER (\S+)", (TOP / "docker/Dockerfile").read_text(), re.M)[1] if own else "root"))
    check(f"{what}: not root", re.fullmatch(r"[1-9]\d*(:[1-9]\d*)?", user), user)
    check(f"{what}: read-only", service.get("read_only") is True)
    check(f"{what}: no capabilities", service.get("cap_drop") == ["ALL"] and not service.get("cap_add"))
    check(f"{what}: no new privileges", "no-new-privileges:true" in service.get("security_opt", ()))
    check(f"{what}: bounded", service.get("pids_limit") and service.get("mem_limit"))


def defaults():
    text = subprocess.run([BUILD / "pendulumd", "--help=markdown"], capture_output=True, text=True, check=True).stdout
    return dict(re.findall(r"^\| `--([\w-]+)[^|]*\| `?([^`|]*)`? \|", text, re.M))


def options():
    return {"PENDULUMD_" + name.replace("-", "_").upper() for name in defaults()}


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
    check(f"{name}: no password has a default", not re.search(r"PASSWORD:?-|://[^/@\s]*:[^/@\s]*@", text))
    for service, body in services.items():
        contained(f"{name}: {service}", body)
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


def as_read(name, services):
    """The file as docker-compose itself reads it: its schema, its variables, what is merged into each service."""
    program = tool("docker-compose")
    if not program:
        skip(f"{name} as docker-compose reads it", "docker-compose is not installed")
        return
    settings = {key: value for key, value in os.environ.items() if not key.startswith(("POSTGRES_", "COMPOSE_"))}

    def config(**more):
        # an operator's own docker/.env is not asked
        with tempfile.NamedTemporaryFile() as empty:
            command = [program, "--env-file", empty.name, "-f", TOP / "docker" / name, "config"]
            return subprocess.run(command, env=settings | more, capture_output=True, text=True, timeout=60)

    run = config()
    if "POSTGRES_PASSWORD" in (TOP / "docker" / name).read_text():
        check(f"{name}: without a password it says what to do", run.returncode and "the database needs a password" in run.stderr, run)
        password = "it's $HOME, \"and\" more"
        run = config(POSTGRES_PASSWORD=password)
    check(f"{name}: docker-compose takes it", run.returncode == 0, run.stderr)
    read = yaml.safe_load(run.stdout)["services"] if run.returncode == 0 else {}
    check(f"{name}: docker-compose finds its services", read.keys() == services.keys(), list(read))
    for service, body in read.items():
        bounded(f"{name} as read: {service}", body)
        for key in ("PGPASSWORD", "POSTGRES_PASSWORD"):
            given = (body.get("environment") or {}).get(key)
            # what is printed is a file again, in which a dollar is written twice
            check(f"{name} as read: the {key} of {service}", given is None or given.replace("$$", "$") == password, given)


def labels_of(document):
    return document["spec"]["template"]["metadata"]["labels"]


def pod_is_contained(name, pod, environment):
    """What a pod may do, whom it trusts, and what it is made of."""
    container, = pod["containers"]
    may, all_may = container["securityContext"], pod["securityContext"]
    check(f"{name}: not root", all_may["runAsNonRoot"] and all_may["runAsUser"] > 0 and all_may["seccompProfile"]["type"] == "RuntimeDefault", all_may)
    check(f"{name}: read-only, without capabilities", may["readOnlyRootFilesystem"] and may["capabilities"]["drop"] == ["ALL"] and not may["allowPrivilegeEscalation"], may)
    check(f"{name}: no account of the cluster", pod["automountServiceAccountToken"] is False)
    proxy = environment.get("PENDULUMD_TRUSTED_PROXY", {})
    check(f"{name}: no network is trusted unless the operator says which", "value" not in proxy, proxy)
    version = subprocess.run([BUILD / "pendulumd", "--version"], capture_output=True, text=True, check=True).stdout.split()[1]
    check(f"{name}: its image is of the release that this version comes after", container["image"] == f"pendulumd:{version.partition(chr(43))[0]}", container["image"])


def reached_by_few(documents, deployments):
    """Each deployment has a policy for what comes in and what goes out; the label of a namespace, or a port, stands in each rule."""
    policies = [document for document in documents if document["kind"] == "NetworkPolicy"]
    for pods in deployments:
        name = pods["metadata"]["name"]
        own = [policy["spec"] for policy in policies if policy["spec"]["podSelector"]["matchLabels"].items() <= labels_of(pods).items()]
        check(f"{name}: a policy of the network", own and all(set(spec["policyTypes"]) == {"Ingress", "Egress"} for spec in own), own)
        for spec in own:
            check(f"{name}: who reaches it is said", all(rule.get("from") and all(rule["from"]) for rule in spec["ingress"]), spec["ingress"])
            check(f"{name}: what it reaches is said", all(rule.get("ports") for rule in spec["egress"]), spec["egress"])


def kubernetes():
    documents = list(yaml.safe_load_all((TOP / "docker/kubernetes.yaml").read_text()))
    named = {(document["kind"], document["metadata"]["name"]): document for document in documents}
    check("kubernetes.yaml: its names differ", len(named) == len(documents))
    deployments = [document for document in documents if document["kind"] == "Deployment"]
    secret = re.search(r"create secret generic (\w+) --from-literal=(\w+)=", (TOP / "docker/kubernetes.yaml").read_text())
    router = (TOP / "server/http/router.c").read_text()
    for document in deployments:
        name, pod = document["metadata"]["name"], document["spec"]["template"]["spec"]
        container, = pod["containers"]
        ports = {port["name"]: port["containerPort"] for port in container["ports"]}
        check(f"{name}: its selector", document["spec"]["selector"]["matchLabels"] == labels_of(document))
        known(f"{name}: its options", {entry["name"] for entry in container["env"]}, options())
        pod_is_contained(name, pod, {entry["name"]: entry for entry in container["env"]})
        given = {entry["name"]: entry.get("value") for entry in container["env"]}
        if given["PENDULUMD_ROLE"] != "worker":
            # all have to hear that it goes before it is told so itself
            pause = container["lifecycle"]["preStop"]["sleep"]["seconds"]
            check(f"{name}: it waits before it ends", pause > 0, pause)
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
    reached_by_few(documents, deployments)
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
                check(f"{name}: the metric {metric}", f'"{metric}"' in (TOP / "server/base/metrics.h").read_text())


def unit():
    """The systemd unit waits as long as a drain may take."""
    seconds = re.search(r"^TimeoutStopSec=(\d+)$", (TOP / "docker/pendulumd.service").read_text(), re.M)[1]
    lasts("pendulumd.service", float(seconds), float(defaults()["drain-seconds"]))
    analyze = tool("systemd-analyze")
    if not analyze:
        skip("pendulumd.service: its exposure", "there is no systemd-analyze")
        return
    with tempfile.TemporaryDirectory(prefix="pendulumd-unit-") as directory:
        path = pathlib.Path(directory, "pendulumd.service")
        path.write_text((TOP / "docker/pendulumd.service").read_text().replace("@PREFIX@/bin/pendulumd", str(BUILD / "pendulumd")))
        said = subprocess.run([analyze, "--no-pager", "security", "--offline=true", "--threshold=9", path], capture_output=True, text=True)
        check("pendulumd.service: its exposure is below 1.0", not said.returncode, said.stdout + said.stderr)
        said = subprocess.run([analyze, "verify", path], capture_output=True, text=True)
        check("pendulumd.service: systemd understands it", "pendulumd.service:" not in said.stderr, said.stderr)


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
    written = {name: compose(name) for name in ("compose.one.yaml", "compose.yaml")}
    for name, services in written.items():
        as_read(name, services)
    kubernetes()
    unit()
    live(written["compose.yaml"])
except (OSError, http.client.HTTPException, RuntimeError, KeyError) as error:
    check("it runs", False, repr(error))
sys.exit(summary())
