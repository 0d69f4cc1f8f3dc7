"""The JavaScript client: its build with types from the OpenAPI document, its README, client.mjs, types.ts, an animation in a browser.

Leaves to others: the page of the server (tests/web). Invariant: what npm fetches lies in build/; where it cannot, it is skipped aloud.
"""
import functools
import http.server
import os
import pathlib
import re
import shutil
import subprocess
import threading
import urllib.parse

from clients import TOP, programs
from front import PAGE, Front
from rule import check, skip
from servers import tool

FOLDER = TOP / "api/clients/js"


def fetched(source, home):
    """Whether npm's packages of a folder are in build/HOME."""
    script = f'. tests/rules/npm.sh; fetch_packages {source.relative_to(TOP)} build/{home}'
    return tool("npm") and subprocess.run(["bash", "-c", script], cwd=TOP).returncode == 0


def test_js(server, home):
    if not tool("node") or not fetched(FOLDER, "clientjs"):
        skip("the JavaScript client", "npm is not here or cannot fetch what builds it")
        return None
    package = home / "js"
    shutil.copytree(FOLDER, package, ignore=shutil.ignore_patterns("dist", "openapi.ts", "node_modules"))
    (package / "node_modules").symlink_to(TOP / "build/clientjs/node_modules")
    (home / "node_modules").mkdir()
    (home / "node_modules/pendulumd").symlink_to(package)
    run = functools.partial(subprocess.run, capture_output=True, text=True, timeout=300)
    built = run(["npm", "run", "--silent", "build"], cwd=package, env=os.environ | {"OPENAPI": str(TOP / "api/call/openapi.yaml")})
    check("js: it builds, with types from the OpenAPI document", built.returncode == 0, built.stdout + built.stderr)
    shutil.copy(TOP / "tests/clients/types.ts", home)
    strict = ["--strict", "--skipLibCheck", "--noEmit", "--noUncheckedIndexedAccess", "--target", "ES2022", "--module", "NodeNext", "--lib", "ES2022,DOM"]
    typed = run([package / "node_modules/.bin/tsc", *strict, "types.ts"], cwd=home)
    wrong = (home / "types.ts").read_text().count("// @ts-expect-error")
    check("js: right programs compile without a cast, and wrong ones do not", typed.returncode == 0 and wrong >= 10
          and not re.search(r"\bas (?!if)|<any>|: any", (home / "types.ts").read_text().partition("\n\n")[2]), typed.stdout)

    fronts, pages = [Front(server.port) for _ in range(3)], Front(server.port)
    pages.moods = [PAGE] * 9
    fronts[0].moods = [("refuse", "429 Too Many Requests", "Retry-After: 1"), ("refuse", "503 Service Unavailable", "Retry-After: 0")]
    fronts[1].moods = [("cut", 1000000)] * 3
    fronts[2].moods = [("cut", 50000)] * 9
    shutil.copy(TOP / "tests/clients/client.mjs", home)
    out = home / "js.doubles"
    done = run([tool("node"), "--expose-gc", "client.mjs", *(front.url for front in fronts), out, pages.url], cwd=home)
    lines = done.stdout.splitlines()
    for line in lines:
        check(f"js: {line.partition(' ')[2]}", line.startswith("ok "), done.stderr[-500:])
    check("js: the script comes to its end", done.returncode == 0 and len(lines) == 27, f"{len(lines)} checks; {done.stderr[-2000:]}")
    check("js: what was cut is asked for by Range", sum("range: bytes=" in head.lower() for head in fronts[1].heads) >= 1, fronts[1].heads)
    for front in (*fronts, pages):
        front.close()
    programs("js", [tool("node"), "--input-type=module", "--eval"], home=home)
    test_animation(server, home, package)
    return out.read_bytes() if out.exists() else None


def test_animation(server, home, package):
    if not tool("chromium") or not fetched(TOP / "tests/web", "webtest"):
        skip("the animation of the JavaScript client", "chromium or what drives it is not here")
        return
    page = re.search(r"```html\n(.*?)```", (FOLDER / "README.md").read_text(), re.S)[1]
    check("js: the animation has 20 lines", len(page.splitlines()) <= 21, len(page.splitlines()))
    (package / "animation.html").write_text(page)

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_):
            pass

    files = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=package))
    threading.Thread(target=files.serve_forever, daemon=True).start()
    query = urllib.parse.urlencode({"server": f"http://127.0.0.1:{server.port}"})
    done = subprocess.run([tool("node"), TOP / "tests/clients/animation.mjs", f"http://127.0.0.1:{files.server_port}/animation.html?{query}"],
                          capture_output=True, text=True, timeout=300, env=os.environ | {"PACKAGES": str(pathlib.Path(TOP, "build/webtest")), "HOME": str(home)})
    check("js: the animation moves in a browser", done.returncode == 0 and done.stdout.startswith("ok "), done.stdout + done.stderr)
    shutil.copy(TOP / "api/clients/python/pendulumd/widget.js", package)
    (package / "host.html").write_text("<!doctype html><body></body>")
    done = subprocess.run([tool("node"), TOP / "tests/clients/widget.mjs", f"http://127.0.0.1:{files.server_port}/host.html", f"http://127.0.0.1:{server.port}/"],
                          capture_output=True, text=True, timeout=300, env=os.environ | {"PACKAGES": str(pathlib.Path(TOP, "build/webtest")), "HOME": str(home)})
    check("js: the widget of notebooks works in a browser", done.returncode == 0 and done.stdout.count("ok ") == 4 and "FAIL" not in done.stdout, done.stdout + done.stderr)
    files.shutdown()
