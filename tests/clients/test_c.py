"""The library in C and C++: the programs of its README, built against what `make install` installs.

Leaves to others: every header by itself, and uninstall (tests/rules/install.sh). Invariant: installs into a directory of its own.
"""
import os
import re
import subprocess

from clients import TOP
from rule import check


def test_c(server, home):
    prefix = home / "installed"
    build = os.path.relpath(os.environ["PENDULUM_BUILD"], TOP)
    done = subprocess.run(["make", "--no-print-directory", "-o", "build", "-o", f"{build}/pendulum", "-o", f"{build}/pendulumd", f"B={build}", "DESTDIR=", f"PREFIX={prefix}", "install"],
                          cwd=TOP, capture_output=True, text=True, env={k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS"))})
    check("c: make install", done.returncode == 0, done.stdout + done.stderr)
    text = (TOP / "api/clients/c/README.md").read_text(encoding="utf-8")
    command = re.search(r"```\ncc (.*)\n```", text)[1]
    environment = os.environ | {"PKG_CONFIG_PATH": str(prefix / "lib/pkgconfig")}
    found = re.findall(r"```(c|cpp)\n(.*?)```(?:\n\n```\n(.*?)```)?", text, re.S)
    check("c: three programs, the first of ten lines", len(found) == 3 and len(found[0][1].splitlines()) <= 12)
    printed = b""
    for number, (language, program, shown) in enumerate(found, 1):
        (home / "program.c").write_text(program)
        compiler = "gcc" if language == "c" else "g++ -x c++"
        built = subprocess.run(f"{compiler} -Wall -Wextra -Werror {command if language == 'c' else command.replace('gnu17', 'c++17').replace('program.c', 'program.c -x none')}", shell=True, cwd=home, capture_output=True, text=True, env=environment)
        check(f"c: program {number} compiles", built.returncode == 0, built.stderr)
        came = subprocess.run([home / "program"], capture_output=True, check=False).stdout
        check(f"c: program {number} says what the README shows", bool(came) and (not shown or came.decode() == shown), came[:300])
        printed = came if language == "c" else printed
    return printed
