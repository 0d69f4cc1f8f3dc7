"""Turns the page's files into what is compiled in.

    assets_embed.py server/web BUNDLES ENGINE GUIDES                   C source that defines srv_assets_table and its count
    assets_embed.py server/web BUNDLES ENGINE GUIDES SITE OPENAPI      a folder SITE that any web host serves: the page without a server

The style and the first script of index.html stand in it, allowed by their digests.
Takes the HTML documents, the worksheets (sheets/*.json) with their translations, the manifest and its icons of the first directory, and
what assets_bundle.sh made: the bundles of scripts and styles, and the libraries under lib/. ENGINE is the engine for browsers; an empty file, as on a machine that cannot make it, is left out. GUIDES has the guides, whose texts become guides.json, in the order of its README. All of it is served under /page/DIGEST, a digest of all files, so that a
browser may keep it for ever; @PAGE@ in an HTML document becomes that path, without the slash before it, since a proxy may stand a path before it, @ENGINE@ the attribute data-engine where there is one, @OFFLINE@ data-offline: there is a service worker, sw.js, which learns the path and, by @FILES@, the files. Each file is there as it is and, where that
is shorter, gzipped at the best level. The same files give the same source.
SITE has the documents with the attribute data-static instead, and without a service worker; a policy stands in them, as a host may
send none.
"""
import base64
import gzip
import hashlib
import json
import pathlib
import re
import sys

MEDIA_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".json": "application/json",
    ".txt": "text/plain; charset=utf-8",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".webmanifest": "application/manifest+json",
    ".woff2": "font/woff2",
    ".wasm": "application/wasm",
}


def own_files(web, bundles):
    """The page's own files, by their names."""
    for path in sorted(web.glob("*.html")):
        yield path.name, path.read_bytes()
    for path in sorted([*web.glob("*.webmanifest"), *web.glob("icon*.*")]):
        yield path.name, path.read_bytes()
    for path in sorted([*web.glob("sheets/*.json"), *web.glob("text/*/sheets.json")]):
        yield path.relative_to(web).as_posix(), path.read_bytes()
    for path in sorted(path for path in bundles.rglob("*") if path.is_file()):
        yield path.relative_to(bundles).as_posix(), path.read_bytes()


def c_bytes(data, width=120):
    """Lines of C string literals that hold any bytes: digits behind an octal escape cannot be misread, nor trigraphs."""
    safe = [chr(b) if 32 <= b < 127 and b not in b'"\\?' else f"\\{b:03o}" for b in range(256)]
    line = []
    length = 0
    for b in data:
        if length > width:
            yield '"' + "".join(line) + '"'
            line, length = [], 0
        line.append(safe[b])
        length += len(safe[b])
    yield '"' + "".join(line) + '"'


def inlined(data, contents):
    """The page with its style and with what runs first in it: two requests less before anything is seen; and what allows them."""
    style, script = contents["page.css"].strip(), contents["early.js"].strip()
    for part, end in ((style, b"</style"), (script, b"</script")):
        if end in part or b"<!--" in part or b"</head>" in part:
            sys.exit("assets_embed: a style or a script that would end before its end")
    named = b'<link rel="stylesheet" href="@PAGE@/page.css">', b'<script type="module" src="@PAGE@/early.js" async></script>'
    if any(data.count(name) != 1 for name in named):
        sys.exit("assets_embed: index.html does not name its style and its first script once")
    data = data.replace(named[0], b"<style>" + style + b"</style>")
    return data.replace(named[1], b'<script type="module" async>' + script + b"</script>"), [source(part) for part in (script, style)]


def source(text):
    """How a policy names a script or a style that stands in a document."""
    return "'sha256-" + base64.b64encode(hashlib.sha256(text).digest()).decode() + "'"


def policy(script, style):
    """What a document may load: this server's own, the engine (WebAssembly) among it; who may frame it stands behind."""
    return (f"default-src 'none'; script-src 'self' 'wasm-unsafe-eval' {script}; style-src 'self' {style}; "
            "img-src 'self' data: blob:; media-src blob:; font-src 'self'; connect-src 'self'; manifest-src 'self'; base-uri 'none'; "
            "form-action 'none'; frame-ancestors ")


def kept(files):
    """What the service worker may keep: what is served under the digest."""
    return [name for name, _ in files if not name.endswith(".html") and name != "sw.js"]


def write(files, digest, out):
    engine = any(name == "engine.wasm" for name, _ in files)
    out.write('#include "server/http/assets.h"\n\n')
    rows = []
    allowed = []
    for number, (name, data) in enumerate(files):
        suffix = pathlib.PurePosixPath(name).suffix
        if suffix not in MEDIA_TYPES:
            sys.exit(f"assets_embed: {name} has no media type; the table here has {' '.join(MEDIA_TYPES)}")
        if name == "index.html":
            data, allowed = inlined(data, dict(files))
        if suffix == ".html" or name == "sw.js":
            data = data.replace(b"@PAGE@", f"page/{digest}".encode()).replace(b"@ENGINE@", b" data-engine" if engine else b"")
            data = data.replace(b"@OFFLINE@", b" data-offline").replace(b"@FILES@", " ".join(kept(files)).encode())
        packed = bytearray(gzip.compress(data, 9, mtime=0))
        packed[9] = 255  # the system it was made on, which Pythons name differently
        forms = [("plain", data)] + ([("packed", packed)] if len(packed) < len(data) else [])
        for form, held in forms:
            out.write(f"static const char {form}_{number}[] =\n")
            out.writelines(f"    {line}\n" for line in c_bytes(held))
            out.write("    ;\n")
        tag = hashlib.sha256(data).hexdigest()[:32]
        second = f"packed_{number}, sizeof packed_{number} - 1" if len(forms) > 1 else "NULL, 0"
        rows.append(f'    {{"{name}", "{MEDIA_TYPES[suffix]}", "W/\\"{tag}\\"", plain_{number}, sizeof plain_{number} - 1, {second}}},\n')
    out.write(f'\nconst char srv_assets_digest[] = "{digest}";\n')
    out.write(f'const char srv_assets_policy[] = "{policy(*allowed)}";\n\n')
    out.write("const struct srv_asset srv_assets_table[] = {\n" + "".join(rows) + "};\n\n")
    out.write(f"const int srv_assets_count = {len(rows)};\n")


def site(files, digest, home, openapi):
    """Writes the page as a folder, in which every name is found without a server that knows them."""
    home.mkdir(parents=True, exist_ok=True)
    inner = home / "page" / digest
    contents = dict(files)
    for name, data in files:
        if name.endswith(".html"):
            data, allowed = inlined(data, contents) if name == "index.html" else (data, ["", ""])
            meta = f'<meta http-equiv="Content-Security-Policy" content="{policy(*allowed).removesuffix("; frame-ancestors ")}">'.encode()
            data = data.replace(b"@PAGE@", f"page/{digest}".encode()).replace(b"@ENGINE@", b" data-engine").replace(b"@OFFLINE@", b"")
            data = data.replace(b"<html ", b"<html data-static ").replace(b'<meta charset="utf-8">', b'<meta charset="utf-8">\n' + meta)
            (home / name).write_bytes(data.replace(b'href="docs"', b'href="docs.html"'))
        elif name != "sw.js":
            (inner / name).parent.mkdir(parents=True, exist_ok=True)
            (inner / name).write_bytes(data)
    (home / "openapi.json").write_bytes(openapi)


def engine_file(path):
    """The engine, if there is one."""
    data = path.read_bytes()
    if data:
        yield "engine.wasm", data


def guides(home):
    """The guides as a list of {"name", "text"}."""
    names = re.findall(r"\]\(([\w-]+)\.md\)", (home / "README.md").read_text(encoding="utf-8"))
    texts = [{"name": name, "text": (home / f"{name}.md").read_text(encoding="utf-8")} for name in names]
    yield "guides.json", json.dumps(texts, ensure_ascii=False).encode()


def main(web, bundles, engine, guide, home=None, openapi=None):
    files = sorted([*own_files(pathlib.Path(web), pathlib.Path(bundles)), *engine_file(pathlib.Path(engine)), *guides(pathlib.Path(guide))])
    sha = hashlib.sha256()
    for name, data in files:
        sha.update(f"{name} {len(data)}\n".encode() + data)
    if home:
        site(files, sha.hexdigest()[:16], pathlib.Path(home), pathlib.Path(openapi).read_bytes())
    else:
        write(files, sha.hexdigest()[:16], sys.stdout)


if __name__ == "__main__":
    if len(sys.argv) not in (5, 7):
        sys.exit(__doc__)
    main(*sys.argv[1:])
