"""Checks that every source has a test file of its name, or that a README names the tests for it.

usage: mirror.py
tests/ROOM/FOLDER/test_X.c (.cpp), or test_X_MORE.c, tests ROOM/FOLDER/X.c; for other sources tests/ROOM/README.md has a row
`FOLDER/X` | test files. The tests that SECURITY.md and tables of constants name must exist.
Leaves to others: the contents of tests, and that they pass. Invariant: a row that is not needed, or names a missing file, is a
fault; so is a test whose name is not that of a source.
"""
import pathlib
import re
import sys

TOP = pathlib.Path(__file__).resolve().parents[2]
ROOMS = ("core", "api", "server")


def own(stem, stems):
    """Whether a test of this name is for one of the sources in its folder: its name, with more behind it or without."""
    words = stem.split("_")
    return next((name for n in range(len(words), 0, -1) if (name := "_".join(words[:n])) in stems), None)


def rows(readme):
    """(source, tests) of the table of a README."""
    for line in readme.splitlines():
        cells = line.split("|")
        if len(cells) == 4 and cells[1].strip().startswith("`"):
            tests = re.findall(r"`([^`]+)`", cells[2])
            yield from ((source, tests) for source in re.findall(r"`([^`]+)`", cells[1]))


def complaints(sources, headers, tests, readmes):
    """What is wrong with the tests of sources; all are paths as text, from the top."""
    stems, tested, told = {}, set(), {}
    for path in sources + headers:
        stems.setdefault(path.rpartition("/")[0], set()).add(pathlib.PurePath(path).stem)
    for path in tests:
        folder, _, name = path.removeprefix("tests/").rpartition("/")
        source = own(name.removeprefix("test_").partition(".")[0], stems.get(folder, set()))
        if source:
            tested.add(f"{folder}/{source}")
        else:
            yield f"{path} has the name of no source"
    for room, readme in readmes.items():
        for source, names in rows(readme):
            told[f"{room}/{source}"] = names
            for name in names:
                if not any(path == f"tests/{name}" or path.startswith(f"tests/{name}/") for path in everything(tests)):
                    yield f"tests/{room}/README.md names {name}, which is not there"
    known = {path.rpartition(".")[0] for path in sources}
    for source in sorted(known - tested - {source for source, names in told.items() if names}):
        yield f"{source} has no test_{source.rpartition('/')[2]}, and tests/{source.partition('/')[0]}/README.md does not say where it is tested"
    for source in sorted(set(told) - known):
        yield f"tests/{source.partition('/')[0]}/README.md has a row for {source}, which is no source"
    for source in sorted(set(told) & tested):
        yield f"tests/{source.partition('/')[0]}/README.md has a row for {source}, which has a test of its own"


def untested(text, names):
    """What is wrong with SECURITY.md: a sentence that names no test, or one that is not there."""
    claims = [row for row in rows_of(text, "sentence") if row]
    for claim, tests in claims:
        named = re.findall(r"`([a-z0-9_]+)`", tests)
        if not named:
            yield f"SECURITY.md names no test of: {claim}"
        yield from (f"SECURITY.md names the test {name}, which is not there" for name in named if name not in names)
    if not claims:
        yield "SECURITY.md has no table of sentences and tests"


def rows_of(text, head):
    """(first, second) cells of the rows of the table whose head begins with a word."""
    _, _, table = text.partition(f"| {head} |")
    for line in table.splitlines()[2:]:
        if not line.startswith("|"):
            return
        cells = line.split("|")
        yield cells[1].strip(), cells[2]


def unfixed(path, text, names):
    """What is wrong with a table of constants: one whose comment names no test in brackets and no reason of safety, or a test that is not there."""
    for comment, body in re.findall(r"(?:/\*((?:(?!\*/).)*)\*/\n)?(?:static const \w+|enum \{) ([^;]*);", text, re.S):
        named = re.findall(r"\[(\w+)\]", comment)
        if not named and "Safety:" not in comment:
            yield f"{path} names no test of {body.partition(' ')[0]}, and no reason of safety"
        yield from (f"{path} names the test {name}, which is not there" for name in named if name not in names)


def tests_of_c():
    """The names of all tests in C."""
    return {name for path in (TOP / "tests").rglob("test_*.c") for name in re.findall(r"TEST\((\w+)\)", path.read_text(encoding="utf-8"))}


def checks_of_python():
    """The names of all functions of drills and rules."""
    return {name for folder in ("drill", "rules") for path in (TOP / "tests" / folder).glob("*.py")
            for name in re.findall(r"^def (\w+)\(", path.read_text(encoding="utf-8"), re.M)}


def everything(tests):
    """The tests that mirror the rooms, and all other files of tests/."""
    return tests + [str(path.relative_to(TOP)) for path in (TOP / "tests").glob("*/*.*")]


def found(top, endings, start=""):
    return sorted(str(path.relative_to(TOP)) for room in ROOMS for path in (TOP / top / room).rglob(f"{start}*")
                  if path.suffix in endings and "node_modules" not in path.parts)


def main():
    sources = found("", (".c", ".cpp"))
    readmes = {room: (TOP / "tests" / room / "README.md").read_text(encoding="utf-8") for room in ROOMS}
    wrong = list(complaints(sources, found("", (".h",)), found("tests", (".c", ".cpp"), "test_"), readmes))
    wrong += untested((TOP / "SECURITY.md").read_text(encoding="utf-8"), tests_of_c() | checks_of_python())
    tests = tests_of_c()
    for path in sorted((TOP / "core").rglob("*_constants.h")):
        wrong += unfixed(path.relative_to(TOP), path.read_text(encoding="utf-8"), tests)
    if len(list(unfixed("x", "/* a [b] */\nenum { A = 1 };\n/* Safety: c. */\nenum { B = 2 };\n/* d [e] */\nstatic const double f = 1;\nenum { G };\n", {"b"}))) != 2:
        wrong.append("faults of a sample of constants are not seen")
    if len(list(untested("| sentence | tests |\n| --- | --- |\n| a | `x_y` |\n| b | none |\n", {"x"}))) != 2 or len(list(untested("", set()))) != 1:
        wrong.append("faults of a sample of SECURITY.md are not seen")
    if len(sources) < 100:
        wrong.append(f"only {len(sources)} sources were found")
    # a sample that breaks every part of the rule once
    sample = list(complaints(["core/a/x.c", "core/a/y.c", "core/a/z.c"], [], ["tests/core/a/test_x_more.c", "tests/core/a/test_w.c"],
                             {"core": "| `a/y` | `core/a/test_x_more.c`, `core/no.c` |\n| `a/x` | `core/a/test_w.c` |\n| `a/v` | `core/a/test_w.c` |"}))
    if len(sample) != 5:
        wrong.append(f"of five faults of a sample the rule says {sample}")
    for complaint in wrong:
        print(f"FAIL {complaint}")
    print(f"{len(sources) + 2 - min(len(wrong), len(sources) + 2)} passed, {len(wrong)} failed")
    return len(wrong) > 0


if __name__ == "__main__":
    sys.exit(main())
