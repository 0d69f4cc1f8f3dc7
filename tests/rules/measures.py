"""Checks the C code against the limits of CONTRIBUTING.md: columns, lengths, branches, comments, assertions; the
page's style sheets against the limit of columns; and special forms against the rows of core/forms.md.

usage: measures.py [--list]     --list also prints every fault, and the longest and the most branched functions
Leaves to others: layout and one statement per line (layout.sh), the order of includes (layers.sh).
Invariant: reads text only; nothing is compiled. KNOWN limits how often a rule may be broken.
"""
import pathlib
import re
import sys

TOP = pathlib.Path(__file__).resolve().parents[2]
ROOMS = ("core", "api", "server")
COLUMNS, FILE_LINES, FUNCTION_LINES, BRANCHES, ASSERTIONS = 100, 500, 60, 15, 10

# What a special form gains a whole request at least, and the files of core that are such forms.
GAIN = 1.25
FORM = re.compile(r"taylor/(?:small|large|lanes)/|dynamics/dynamics_\w*template$|derivatives/(?:kernel_)?ideal|integrate/methods/kernel_exchange$")

# How often each measure is broken today. A number may only fall; assertions, for a thousand lines, may only rise.
KNOWN = {"columns": 0, "files": 0, "functions": 0, "branches": 0, "comments": 0, "assertions": 9.6}

# Lines that there may be: of C, of the page, of tests. A number may only fall; a commit that raises one raises nothing else and says for what.
BUDGET = {
    "C": (ROOMS, (".c", ".h", ".cpp"), 102200),
    "the page": (("server/web",), (".js", ".ts", ".css", ".html", ".json", ".md", ".txt"), 38000),
    "tests": (("tests",), (".c", ".h", ".mjs", ".js", ".py", ".sh"), 88000),
}

RULES = {
    "columns": f"lines have at most {COLUMNS} columns",
    "files": f"files have at most {FILE_LINES} lines",
    "functions": f"functions have at most {FUNCTION_LINES} lines",
    "branches": f"functions branch at most {BRANCHES} times",
    "comments": "every public function has a comment",
}
HIDDEN = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.S)
BRANCH = re.compile(r"\b(?:if|for|while|case)\b|&&|\|\||\?")
ASSERTION = re.compile(r"\b(?:assert|static_assert|_Static_assert)\(")
PUBLIC = re.compile(r"(?m)^(?!typedef|static|return)(?:[A-Za-z_]\w*[ \t\n*]+)+(\w+)\([^;{}]*\)\s*;")
NAME = re.compile(r"([A-Za-z_]\w*)(?:\([^()]*\))?\s*\((?:[^()]|\([^()]*\))*\)(?:\s*(?:__asm__.*|const|noexcept))?$")


def blank(text):
    """The code alone: comments, strings and preprocessor lines become spaces, lines stay where they are."""
    text = HIDDEN.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), text)
    return re.sub(r"(?m)^[ \t]*#(?:[^\n\\]|\\\n|\\.)*", lambda m: re.sub(r"[^\n]", " ", m[0]), text)


def blocks(code):
    """Every outermost pair of braces, those of namespaces left aside: where it begins and ends, and where its head begins."""
    depth, begin, head = 0, 0, 0
    for match in re.finditer(r"[{};]", code):
        at = match.start()
        if match[0] == "{":
            if not depth and re.search(r"\b(?:namespace\s*[\w:]*|extern)\s*$", code[head:at]):
                head = at + 1
                continue
            if not depth:
                begin = at
            depth += 1
        elif match[0] == "}" and depth:
            depth -= 1
            if not depth:
                yield begin, at, head
                head = at + 1
        elif not depth:
            head = at + 1


def functions(code):
    """Name, first line, number of lines and number of branches of each function."""
    for begin, end, start in blocks(code):
        head = code[start:begin]
        name = NAME.search(head.strip())
        if not name or re.match(r"(?:typedef|struct|union|enum)\b[^()]*$", head.strip()):
            continue
        first = code.count("\n", 0, start + len(head) - len(head.lstrip())) + 1
        yield name[1], first, code.count("\n", 0, end) + 2 - first, 1 + len(BRANCH.findall(code[begin:end]))


def uncommented(text, code):
    """The public functions of a header that no comment stands above; functions without an empty line between share one."""
    lines = text.split("\n")
    for match in PUBLIC.finditer(code):
        above = code.count("\n", 0, match.start()) - 1
        while above >= 0 and lines[above].strip() and not lines[above].rstrip().endswith("*/"):
            above -= 1
        if above < 0 or not lines[above].strip():
            yield match[1]


def measure(sources):
    """Complaints by measure, all functions, lines and assertions of sources, which are given as text by path."""
    wrong = {key: [] for key in RULES}
    every, total, assertions = [], 0, 0
    for path, text in sources.items():
        lines, code = text.split("\n"), blank(text)
        total += len(lines)
        assertions += len(ASSERTION.findall(text))
        wrong["columns"] += [f"{path}:{i}: {len(line)} columns" for i, line in enumerate(lines, 1) if len(line) > COLUMNS]
        if len(lines) > FILE_LINES + 1:
            wrong["files"].append(f"{path}: {len(lines) - 1} lines")
        for name, first, length, branches in functions(code):
            every.append((length, branches, f"{path}:{first}: {name}"))
            if length > FUNCTION_LINES:
                wrong["functions"].append(f"{path}:{first}: {name} has {length} lines")
            if branches > BRANCHES:
                wrong["branches"].append(f"{path}:{first}: {name} branches {branches} times")
        if path.endswith(".h") and not path.endswith("_template.h"):
            wrong["comments"] += [f"{path}: {name} has no comment" for name in uncommented(text, code)]
    return wrong, every, total, assertions


def forms(text, sources):
    """What is wrong with core/forms.md, of sources by path: a form without a row, a row without its files, a gain or lines that are not so."""
    lines = {path: len(source.splitlines()) for path, source in sources.items()}
    of_stem = {}
    for path in lines:
        of_stem.setdefault(path.rpartition(".")[0].removeprefix("core/"), []).append(path)
    named = set(re.findall(r"`(\w+(?:/\w+)+)`", text))
    for stem in sorted(named - set(of_stem)):
        yield f"core/forms.md names {stem}, which is not there"
    for stem in sorted(set(filter(FORM.match, of_stem)) - named):
        yield f"core/{stem} is a special form without a row in core/forms.md"
    for row in (line.split("|") for line in text.splitlines() if re.match(r"\| .*`\w+/", line)):
        told, is_so = int(row[4]), sum(lines[path] for stem in re.findall(r"`([\w/]+)`", row[2]) for path in of_stem.get(stem, ()))
        if abs(told - is_so) > is_so / 10:
            yield f"core/forms.md: the form {row[1].strip()} has {is_so} lines, not {told}"
        if max(map(float, re.findall(r"\d\.\d+", row[8]))) < GAIN:
            yield f"core/forms.md: the form {row[1].strip()} gains less than {GAIN} times"


def sample(excess):
    """A source and a header that are at every limit, or over each limit by `excess`."""
    long_line = "/* " + "x" * (COLUMNS - 6 + excess) + " */"
    long_function = ["", "static int long_one(int i) {"] + ["    i++; // } if"] * (FUNCTION_LINES - 3 + excess) + ["    return i;", "}"]
    branched = ["", "namespace pend {", "int branched(int i) {", "    if (i) i--;"] + ["    i = i ? 1 : 2;"] * (BRANCHES - 2 + excess) + ["}", "}"]
    lines = [long_line] + long_function + branched
    lines += ["int i;"] * (FILE_LINES - len(lines) + excess)
    header = ["/* Adds one. */", "int pend_add(int i);"] + [""] * excess + ["PEND_MUST_CHECK enum pend_status", "pend_try(const char *s);"]
    return {"sample.cpp": "\n".join(lines) + "\n", "sample.h": "\n".join(header) + "\n"}


def lines_of(places, kinds):
    """How many lines the files of these kinds have, those of npm left out."""
    paths = (p for place in places for p in (TOP / place).rglob("*.*") if p.suffix in kinds)
    return sum(p.read_bytes().count(b"\n") for p in paths if "node_modules" not in p.parts and p.name != "package-lock.json")


def over(counted):
    """What has more lines than it may have; room of more than a hundredth is to be given back."""
    for name, (_, _, most) in BUDGET.items():
        if not 0.99 * most <= counted[name] <= most:
            yield f"{name} has {counted[name]} lines, the budget is {most}"


def main():
    found = sorted(p for room in ROOMS for p in (TOP / room).rglob("*.*") if p.suffix in (".c", ".h", ".cpp") and "node_modules" not in p.parts)
    wrong, every, total, assertions = measure({str(p.relative_to(TOP)): p.read_text(encoding="utf-8") for p in found})
    failures = []
    if len(found) < 100:
        failures.append(f"only {len(found)} sources were found")
    for excess in (0, 1):
        seen = {key: len(complaints) for key, complaints in measure(sample(excess))[0].items()}
        if seen != {key: excess for key in RULES}:
            failures.append(f"of a sample that breaks each measure {excess} times the rule noticed {seen}")
    wrong_forms = list(forms((TOP / "core/forms.md").read_text(encoding="utf-8"), {str(p.relative_to(TOP)): p.read_text(encoding="utf-8") for p in found}))
    sample_forms = "| a | `taylor/a`, `taylor/b` | | 3 | | | | 1.20, 1.24 |"
    if len(list(forms(sample_forms, {"core/taylor/a.c": "", "core/taylor/large/c.h": ""}))) != 4:
        failures.append("the four faults of a sample of core/forms.md are not noticed")
    failures += wrong_forms
    if len(list(over({name: most + 1 for name, (_, _, most) in BUDGET.items()}))) != len(BUDGET):
        failures.append("a line too many is not noticed")
    failures += over({name: lines_of(places, kinds) for name, (places, kinds, _) in BUDGET.items()})
    styles = [p for p in (TOP / "server/web").rglob("*.css") if "node_modules" not in p.parts]
    for p in styles:
        lines = enumerate(p.read_text(encoding="utf-8").split("\n"), 1)
        wrong["columns"] += [f"{p.relative_to(TOP)}:{i}: {len(line)} columns" for i, line in lines if len(line) > COLUMNS]
    if len(styles) < 3:
        failures.append(f"only {len(styles)} sheets of style were found")
    density = 1000 * assertions / max(total, 1)
    for key, complaints in wrong.items():
        count, known = len(complaints), KNOWN[key]
        if count > known or "--list" in sys.argv:
            print(*(f"  {complaint}" for complaint in complaints), sep="\n", end="\n" if complaints else "")
        if count > known:
            failures.append(f"{RULES[key]}: {count} do not" + f", of {known} that are known" * (known > 0))
        elif known:
            print(f"known: {RULES[key]}: {count} do not, {known} may")
    if density < KNOWN["assertions"]:
        failures.append(f"there are {density:.1f} assertions a thousand lines, of at least {KNOWN['assertions']}")
    elif KNOWN["assertions"] < ASSERTIONS:
        print(f"known: {density:.1f} assertions a thousand lines; {ASSERTIONS} are the aim")
    if "--list" in sys.argv:
        print(f"{len(found)} files, {total} lines, {len(every)} functions, {density:.1f} assertions a thousand lines")
        print("longest:", *(f"  {length} {where}" for length, _, where in sorted(every, reverse=True)[:12]), sep="\n")
        print("most branches:", *(f"  {branches} {where}" for _, branches, where in sorted(every, key=lambda f: -f[1])[:12]), sep="\n")
    print(*(f"FAIL {failure}" for failure in failures), sep="\n", end="\n" if failures else "")
    print(f"{6 + len(RULES) - len(failures)} passed, {len(failures)} failed")
    return len(failures) > 0


if __name__ == "__main__":
    sys.exit(main())
