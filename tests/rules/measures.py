"""Holds the C of the rooms to the measures of CONTRIBUTING.md: columns, statements a line, lengths, branching, comments.

usage: measures.py [--list]     --list names the longest and the most branched functions, and counts
Leaves to others: layout (layout.sh), who includes whom (layers.sh). Invariant: reads text only; nothing is compiled.
"""
import re
import subprocess
import sys
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
COLUMNS, FILE_LINES, FUNCTION_LINES, BRANCHES, ASSERTIONS = 100, 500, 60, 15, 10
HIDDEN = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.S)
BRANCH = re.compile(r"\b(?:if|for|while|case)\b|&&|\|\||\?")


def blank(text):
    """The code alone: comments, strings and preprocessor lines become spaces, lines stay where they are."""
    text = HIDDEN.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), text)
    return re.sub(r"(?m)^[ \t]*#(?:[^\n\\]|\\\n|\\.)*", lambda m: re.sub(r"[^\n]", " ", m[0]), text)


def blocks(code):
    """Every outermost pair of braces: where it begins and ends, and what stands before it."""
    depth, begin, before = 0, 0, 0
    for match in re.finditer(r"[{};]", code):
        at = match.start()
        if match[0] == "{":
            if not depth:
                begin = at
            depth += 1
        elif match[0] == "}":
            depth -= 1
            if not depth:
                yield begin, at, code[before:begin]
                before = at + 1
        elif not depth:
            before = at + 1


def functions(code):
    """Name, first line, lines and branches of each function."""
    for begin, end, before in blocks(code):
        head = before.strip()
        if not head.endswith(")") or re.match(r"(?:typedef|struct|union|enum)\b[^()]*$", head):
            continue
        name = re.search(r"([A-Za-z_]\w*)(?:\([^()]*\))?\s*\((?:[^()]|\([^()]*\))*\)(?:\s*__asm__.*)?$", head)
        first = code.count("\n", 0, begin - len(before) + len(before) - len(before.lstrip())) + 1
        body = code[begin:end]
        yield (name[1] if name else head[-40:]), first, code.count("\n", 0, end) + 2 - first, 1 + len(BRANCH.findall(body))


def prototypes(path, text):
    """Public prototypes of a header that no comment stands above; several may share the comment above the first."""
    code = blank(text)
    lines = text.split("\n")
    for match in re.finditer(r"(?m)^(?!typedef|static|return|extern \"C\")[A-Za-z_][\w \t*]*?\b(\w+)\([^;{}]*\)\s*;", code):
        above = code.count("\n", 0, match.start()) - 1
        while above >= 0 and lines[above].strip() and not lines[above].rstrip().endswith("*/"):
            above -= 1
        if above < 0 or not lines[above].strip():
            yield f"{path}: {match[1]} has no comment"


def main():
    files = subprocess.run(["git", "-C", TOP, "ls-files", "core", "api", "server"], capture_output=True, text=True).stdout.split()
    files = files or [str(p.relative_to(TOP)) for room in ("core", "api", "server") for p in (TOP / room).rglob("*")]
    files = sorted(f for f in files if f.endswith((".c", ".h", ".cpp")) and "node_modules" not in f)
    if len(files) < 100:
        sys.exit(f"FAIL only {len(files)} sources were found\n0 passed, 1 failed")
    wrong = {"columns": [], "file": [], "function": [], "branches": [], "prototypes": []}
    every, total, assertions = [], 0, 0
    for path in files:
        text = (TOP / path).read_text(encoding="utf-8")
        lines = text.split("\n")
        total += len(lines)
        assertions += len(re.findall(r"\b(?:assert|static_assert|_Static_assert)\(", text))
        wrong["columns"] += [f"{path}:{i}: {len(line)} columns" for i, line in enumerate(lines, 1) if len(line) > COLUMNS]
        if len(lines) > FILE_LINES + 1:
            wrong["file"].append(f"{path}: {len(lines) - 1} lines")
        for name, first, length, branches in functions(blank(text)):
            every.append((length, branches, f"{path}:{first}: {name}"))
            if length > FUNCTION_LINES:
                wrong["function"].append(f"{path}:{first}: {name} has {length} lines")
            if branches > BRANCHES:
                wrong["branches"].append(f"{path}:{first}: {name} branches {branches} times")
        if path.endswith(".h") and not path.endswith("_template.h"):
            wrong["prototypes"] += prototypes(path, text)
    if "--list" in sys.argv:
        print(f"{len(files)} files, {total} lines, {len(every)} functions, {1000 * assertions / total:.1f} assertions a thousand lines")
        print("longest:", *[f"  {n} {w}" for n, _, w in sorted(every, reverse=True)[:12]], sep="\n")
        print("most branches:", *[f"  {b} {w}" for _, b, w in sorted(every, key=lambda e: -e[1])[:12]], sep="\n")
    names = {"columns": f"lines have at most {COLUMNS} columns", "file": f"files have at most {FILE_LINES} lines",
             "function": f"functions have at most {FUNCTION_LINES} lines", "branches": f"functions branch at most {BRANCHES} times",
             "prototypes": "every public function has a comment"}
    failed = 0
    for key, complaints in wrong.items():
        for complaint in complaints[:40]:
            print(" ", complaint)
        if complaints:
            failed += 1
            print(f"FAIL {names[key]}: {len(complaints)} do not")
    if 1000 * assertions < ASSERTIONS * total:
        failed += 1
        print(f"FAIL there are {1000 * assertions / total:.1f} assertions a thousand lines, of at least {ASSERTIONS}")
    print(f"{len(wrong) + 1 - failed} passed, {failed} failed")
    return failed > 0


if __name__ == "__main__":
    sys.exit(main())
