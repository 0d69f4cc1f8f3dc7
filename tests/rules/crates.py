"""Crates of jobs, read by Python's zipfile and json (and by rocrate, where that is installed), held against the rules of RO-Crate 1.1 and Process
Run Crate 0.5, proven by `pendulumd --replay`, and spoilt, which that has to notice.

usage: crates.py BUILD
Leaves to others: which bits a crate has (tests/api/call/test_crate.c). Invariant: what is not installed is skipped aloud.
"""
import hashlib
import io
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import zipfile
from urllib.error import HTTPError
from urllib.parse import urlencode
from urllib.request import Request, urlopen

from rule import check, optional, skip, summary
from servers import daemon

TWO = {"length": [1, 1], "mass": [1, 1], "parent": [0, 1]}
JOBS = {
    "a trajectory": ("trajectories", {"pendulum": TWO, "times": {"start": 0, "stop": 5, "step": 0.01}}, "npz"),
    "a long one": ("trajectories", {"pendulum": TWO, "times": {"start": 0, "stop": 400, "step": 0.005}}, "csv"),
    "an ensemble": ("ensembles", {"pendulum": TWO, "duration": 3, "grid": [{"vary": "theta", "arm": 1, "start": -3, "stop": 3, "count": 40},
                                                                           {"vary": "theta", "arm": 2, "start": -3, "stop": 3, "count": 30}]}, "parquet"),
    "orbits": ("orbits", {"pendulum": TWO, "mode": 2, "amplitude": 0.5}, "json"),
}
ROCRATE = optional("rocrate")


class Server:
    """A daemon that keeps jobs."""

    def __init__(self, port):
        self.url = f"http://127.0.0.1:{port}"

    def get(self, path):
        with urlopen(self.url + path) as answer:
            return answer.headers, answer.read()

    def status(self, path):
        try:
            return self.get(path)[0] and 200
        except HTTPError as refusal:
            return refusal.code

    def job(self, operation, body, title):
        headers = {"Content-Type": "application/json", "Prefer": "respond-async", "Job-Title": title}
        with urlopen(Request(f"{self.url}/v1/{operation}", json.dumps(body).encode(), headers)) as answer:
            job = json.load(answer)
        while job["status"] in ("accepted", "running"):
            job = json.loads(self.get(f"/v1/jobs/{job['id']}?wait=60")[1])
        check(f"{title} is computed", job["status"] == "successful", job["message"])
        return job


def entities(what, metadata):
    """The graph by id, with what RO-Crate 1.1 asks of every crate."""
    graph = {entity["@id"]: entity for entity in metadata["@graph"]}
    check(f"{what}: ids are unique", len(graph) == len(metadata["@graph"]))
    context = metadata["@context"]
    check(f"{what}: the context is that of RO-Crate 1.1", context[0] == "https://w3id.org/ro/crate/1.1/context", context)
    descriptor = graph["ro-crate-metadata.json"]
    check(f"{what}: the descriptor is one of RO-Crate 1.1", descriptor["@type"] == "CreativeWork" and descriptor["about"] == {"@id": "./"}
          and descriptor["conformsTo"] == {"@id": "https://w3id.org/ro/crate/1.1"}, descriptor)
    root = graph["./"]
    check(f"{what}: the root is a data set that says what it has to", root["@type"] == "Dataset"
          and all(root.get(name) for name in ("name", "description", "datePublished", "license", "hasPart")), root)
    check(f"{what}: every entity has a type", all(entity.get("@type") for entity in graph.values()))
    return graph


def references(value):
    """All ids that are referred to within a value."""
    if isinstance(value, list):
        for item in value:
            yield from references(item)
    elif isinstance(value, dict):
        if list(value) == ["@id"]:
            yield value["@id"]
        for item in value.values():
            yield from references(item)


def check_graph(what, graph):
    terms = {"http://schema.org/CompletedActionStatus", "https://w3id.org/ro/crate/1.1"}
    dangling = {name for entity in graph.values() for name in references({key: value for key, value in entity.items() if key != "@id"})
                if name not in graph} - terms
    check(f"{what}: every reference leads to an entity", not dangling, dangling)
    run = graph["#run"]
    tool = graph[run["instrument"]["@id"]]
    check(f"{what}: the run is an action with a tool, an object and a result", run["@type"] == "CreateAction" and run["startTime"] <= run["endTime"]
          and tool["@type"] == "SoftwareApplication" and re.fullmatch(r"[0-9.]+\+[0-9a-f]{16}", tool["softwareVersion"]), run)
    check(f"{what}: the root mentions the run", graph["./"]["mentions"] == {"@id": "#run"})


def check_files(what, archive, graph):
    names = set(archive.namelist()) - {"ro-crate-metadata.json"}
    check(f"{what}: the root names all files", {part["@id"] for part in graph["./"]["hasPart"]} == names, names)
    for name in names:
        data, entity = archive.read(name), graph[name]
        check(f"{what}: {name} has its length", entity["@type"] == "File" and int(entity["contentSize"]) == len(data), entity)
        if "sha256" in entity:
            check(f"{what}: {name} has its digest", hashlib.sha256(data).hexdigest() == entity["sha256"], entity)
    digested = {name for name in names if "sha256" in graph[name]}
    check(f"{what}: request and results have digests", len(digested) == 2, digested)


def replayed(build, crate, directory):
    """The exit status of a replay, what it said, and the results that it wrote."""
    path = pathlib.Path(directory) / "crate.zip"
    path.write_bytes(crate)
    ended = subprocess.run([build / "pendulumd", "--replay", path], capture_output=True)
    return ended.returncode, ended.stderr.decode(), ended.stdout


def repacked(crate, change, pack=zipfile.ZIP_STORED):
    """The crate with files changed: change(name, data) gives the bytes."""
    packed = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(crate)) as archive, zipfile.ZipFile(packed, "w", pack) as other:
        for name in archive.namelist():
            other.writestr(name, change(name, archive.read(name)))
    return packed.getvalue()


def redigested(name, data, file, new):
    """The data of a file, and of metadata that agree with it, after the file's bytes became others."""
    if name == file:
        return new
    if name != "ro-crate-metadata.json":
        return data
    metadata = json.loads(data)
    for entity in metadata["@graph"]:
        if entity["@id"] == file:
            entity["sha256"] = hashlib.sha256(new).hexdigest()
    return json.dumps(metadata).encode()


def check_spoilt(build, crate, directory):
    """What --replay says of crates that are not what the server sent."""
    with zipfile.ZipFile(io.BytesIO(crate)) as archive:
        request = archive.read("request.json")
        results = next(name for name in archive.namelist() if name.startswith("results."))
        numbers = bytearray(archive.read(results))
    numbers[len(numbers) // 2] ^= 1
    other = request.replace(b'"stop":5', b'"stop":6')
    check("the request can be another", other != request)
    cases = {
        "a crate packed by another program with the same bytes": (0, "bit for bit", repacked(crate, lambda name, data: data)),
        "a crate that is compressed": (2, "packed", repacked(crate, lambda name, data: data, zipfile.ZIP_DEFLATED)),
        "a crate without its end": (2, "ro-crate-metadata", crate[:-30]),
        "a crate with a bit of its results changed": (2, "digest", repacked(crate, lambda name, data: bytes(numbers) if name == results else data)),
        "a crate with another request": (2, "digest", repacked(crate, lambda name, data: other if name == "request.json" else data)),
        "results that were forged with their digest": (1, "are others", repacked(
            crate, lambda name, data: redigested(name, data, results, bytes(numbers)))),
        "a request that was forged with its digest": (1, "are others", repacked(
            crate, lambda name, data: redigested(name, data, "request.json", other))),
        "metadata that are no JSON": (2, "not JSON", repacked(crate, lambda name, data: data[:-9] if name.startswith("ro-") else data)),
        "no metadata": (2, "no run", repacked(crate, lambda name, data: b"{}" if name.startswith("ro-") else data)),
    }
    for what, (status, word, spoilt) in cases.items():
        code, said, _ = replayed(build, spoilt, directory)
        check(f"--replay of {what}", code == status and word in said, f"{code}: {said}")


def check_cite(what, text, job, request):
    fields = dict(re.findall(r"^  (\w+) = \{(.*)\},?$", text, re.MULTILINE))
    check(f"{what}: an entry for BibTeX", text.startswith(f"@misc{{pendulumd-{job['id']},\n") and text.endswith("\n}\n") and text.count("{") == text.count("}"), text)
    check(f"{what}: it says when, where and by what", fields["date"] == job["finished"][:10] and fields["year"] == job["finished"][:4]
          and fields["url"].endswith(f"/v1/jobs/{job['id']}/results") and fields["version"] == f"{{{job['version']}}}", fields)
    check(f"{what}: it has the request's digest", hashlib.sha256(request).hexdigest() in fields["note"], fields)


def check_rights(server, what, link):
    """A crate whose author and license are stated."""
    license_, author = "https://creativecommons.org/licenses/by/4.0/", "Élise N. O'Ether & Co"
    crate = server.get(f"{link}?{urlencode({'author': author, 'license': license_})}")[1]
    with zipfile.ZipFile(io.BytesIO(crate)) as archive:
        graph = entities(f"{what}, with rights", json.loads(archive.read("ro-crate-metadata.json")))
        cite = archive.read("cite.bib").decode()
    check_graph(f"{what}, with rights", graph)
    root = graph["./"]
    check(f"{what}: its license", root["license"] == {"@id": license_} and graph[license_]["@type"] == "CreativeWork", root)
    person = graph[root["author"]["@id"]]
    check(f"{what}: its author", person["@type"] == "Person" and person["name"] == author, person)
    check(f"{what}: its author in the entry", f"author = {{{author.replace('&', chr(92) + '&')}}}" in cite, cite)


def check_job(server, build, directory, what, operation, body, extension):
    job = server.job(operation, body, what)
    links = {link["rel"]: link["href"] for link in job["links"]}
    request = server.get(links["request"])[1]
    headers, text = server.get(links["cite"])
    check(f"{what}: the entry's type", headers["Content-Type"] == "application/x-bibtex; charset=utf-8", headers["Content-Type"])
    check_cite(what, text.decode(), job, request)
    check_rights(server, what, links["crate"])
    headers, crate = server.get(f"{links['crate']}?results={extension}")
    check(f"{what}: the crate's type", headers["Content-Type"] == "application/zip", headers["Content-Type"])
    check(f"{what}: the crate is the same each time", server.get(f"{links['crate']}?results={extension}")[1] == crate)
    with zipfile.ZipFile(io.BytesIO(crate)) as archive:
        check(f"{what}: the archive is whole", archive.testzip() is None)
        metadata = json.loads(archive.read("ro-crate-metadata.json"))
        check(f"{what}: the request is the job's", archive.read("request.json") == request)
        check(f"{what}: the results have their name", f"results.{extension}" in archive.namelist(), archive.namelist())
        graph = entities(what, metadata)
        check_graph(what, graph)
        check_files(what, archive, graph)
        results = archive.read(f"results.{extension}")
    code, said, again = replayed(build, crate, directory)
    check(f"{what}: --replay proves it", code == 0 and again == results, said)
    if ROCRATE:
        check_rocrate(what, crate, directory)
    return crate


def check_rocrate(what, crate, directory):
    from rocrate.rocrate import ROCrate
    path = pathlib.Path(directory) / "again.zip"
    path.write_bytes(crate)
    read = ROCrate(str(path))
    check(f"{what}: rocrate reads the run", read.get("#run")["result"].id.startswith("results."))


def main(build):
    if not ROCRATE:
        skip("rocrate reads crates", "it is not installed")
    with tempfile.TemporaryDirectory(prefix="pendulumd-crates-") as directory:
        with daemon(build, "--store", f"sqlite:{directory}/db") as running:
            server = Server(running.port)
            for what, (operation, body, extension) in JOBS.items():
                crate = check_job(server, build, directory, what, operation, body, extension)
                if what == "a trajectory":
                    check_spoilt(build, crate, directory)
            check("there is no crate of a job that is not there", server.status(f"/v1/jobs/{26 * '0'}/crate") == 404)
    return summary()


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve()))
