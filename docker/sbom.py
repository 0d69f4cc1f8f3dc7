#!/usr/bin/python3
"""Writes what the programs are made of, as SPDX 2.3 and CycloneDX 1.5: the libraries that they are linked with, by the
Debian packages that hold them, what is compiled in, and what the page is made with.

usage: sbom.py BUILD DIRECTORY [PACKAGE...]     writes DIRECTORY/sbom.spdx.json and DIRECTORY/sbom.cdx.json; an image, which
       brings all libraries along, names the Debian packages that they are of
Leaves to others: where they go (Makefile, debian/rules, root.sh).
Invariant: nothing is listed by hand but the names of what is compiled in (packages.txt has no version); two
builds of the same sources on the same packages write the same bytes.
"""
import hashlib
import json
import os
import re
import subprocess
import sys
import time
import uuid

COMPILED_IN = ("libdragonbox-dev", "libfast-float-dev", "libjs-katex", "fonts-katex", "node-qrcode-generator")  # what leaves no library behind
IN_ENGINE = ("wasi-libc", "libclang-rt-dev-wasm32", "libc++-dev-wasm32")  # parts of engine.wasm, where it was built
PROGRAMS = ("pendulumd", "pendulum")


def run(*command):
    """What a command prints."""
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False).stdout


def libraries(programs):
    """The Debian packages of the libraries that programs need themselves, not those of their libraries."""
    places = {}
    for program in programs:
        wanted = re.findall(r"\(NEEDED\).*\[(.*)\]", run("readelf", "-d", program))
        found = dict(re.findall(r"(\S+) => (/\S+)", run("ldd", program)))
        places |= {name: found[name] for name in wanted if name in found}
    owners = {}
    for line in run("dpkg", "-S", *places.values(), *map(os.path.realpath, places.values())).splitlines():
        package, place = line.split(": ", 1)
        owners[place] = package.split(":")[0]
    for place in places.values():
        if place not in owners and os.path.realpath(place) not in owners:
            sys.exit(f"sbom.py: no Debian package has {place}")
    return {owners.get(place) or owners[os.path.realpath(place)] for place in places.values()}


def debian(name):
    """A Debian package: name, version, source and address."""
    version, source, arch = run("dpkg-query", "-W", "-f", "${Version} ${source:Package} ${Architecture}\n", name).splitlines()[0].split()
    system = dict(line.rstrip().split("=", 1) for line in open("/etc/os-release", encoding="utf-8") if "=" in line)
    release = system.get("VERSION_CODENAME", "").strip('"')
    return {"name": name, "version": version, "purl": f"pkg:deb/debian/{name}@{version.replace(':', '%3A').replace('+', '%2B')}?arch={arch}&distro={release}&source={source}"}


def spdx(version, parts, made, digest):
    """SPDX 2.3."""
    packages = [{"name": "pendulumd", "SPDXID": "SPDXRef-pendulumd", "versionInfo": version, "downloadLocation": "NOASSERTION",
                 "filesAnalyzed": False, "licenseConcluded": "GPL-3.0-or-later", "licenseDeclared": "GPL-3.0-or-later",
                 "copyrightText": "NOASSERTION", "primaryPackagePurpose": "APPLICATION"}]
    relations = [{"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES", "relatedSpdxElement": "SPDXRef-pendulumd"}]
    for part in parts:
        key = "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", part["name"])
        one = {"name": part["name"], "SPDXID": key, "versionInfo": part["version"], "downloadLocation": "NOASSERTION",
               "filesAnalyzed": False, "licenseConcluded": "NOASSERTION", "licenseDeclared": "NOASSERTION",
               "copyrightText": "NOASSERTION",
               "externalRefs": [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl", "referenceLocator": part["purl"]}]}
        packages.append(one)
        relations.append({"spdxElementId": "SPDXRef-pendulumd", "relatedSpdxElement": key,
                          "relationshipType": "DYNAMIC_LINK" if part["linked"] else "CONTAINS"})
    return {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": f"pendulumd-{version}",
            "documentNamespace": f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, 'pendulumd:' + digest)}",
            "creationInfo": {"created": made, "creators": ["Tool: pendulumd-sbom"]}, "packages": packages, "relationships": relations}


def cyclonedx(version, parts, made, digest):
    """CycloneDX 1.5."""
    components = []
    for part in parts:
        components.append({"type": "library", "bom-ref": part["purl"], "name": part["name"], "version": part["version"], "purl": part["purl"]})
    own = f"pkg:generic/pendulumd@{version}"
    return {"bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
            "serialNumber": f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_URL, 'pendulumd-cdx:' + digest)}",
            "metadata": {"timestamp": made, "component": {"type": "application", "bom-ref": own, "name": "pendulumd", "version": version,
                                                          "purl": own, "licenses": [{"license": {"id": "GPL-3.0-or-later"}}]}},
            "components": components,
            "dependencies": [{"ref": own, "dependsOn": [part["purl"] for part in parts]}]}


def main(build, directory, *shipped):
    """Both documents."""
    version = run("docker/version.sh").strip()
    linked = shipped or libraries([os.path.join(build, program) for program in PROGRAMS])
    parts = [debian(name) | {"linked": True} for name in sorted(linked)]
    engine = "build/web/engine.wasm"
    contained = COMPILED_IN + (IN_ENGINE if os.path.exists(engine) and os.path.getsize(engine) else ())
    parts += [debian(name) | {"linked": False} for name in contained]
    made = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", "0")) or time.time()))
    digest = hashlib.sha256(json.dumps([version, parts], sort_keys=True).encode()).hexdigest()
    os.makedirs(directory, exist_ok=True)
    for name, document in (("sbom.spdx.json", spdx), ("sbom.cdx.json", cyclonedx)):
        with open(os.path.join(directory, name), "w", encoding="utf-8") as file:
            json.dump(document(version, parts, made, digest), file, indent=1)
            file.write("\n")


main(*sys.argv[1:])
