#!/bin/bash
# Checks words: comments and messages of C and the page's English contain no private words and elliptic phrases; every language of
# the page has all texts, and no others.
# usage: words.sh
# Leaves to others: the texts' checks (tests/web/words.mjs), whether a page shows bare keys (tests/web/test_language.mjs).
# Invariant: nothing is fetched or written.
set -u
cd "$(dirname "$0")/../.." || exit
/usr/bin/python3 - <<'END' || exit
import re, sys
from pathlib import Path

# Folders whose comments are still to be rewritten; remove one when its comments pass.
LATER = re.compile(r"core/(integrate|fit|control)/|api/(op|csv|clients|read)/")
COMMENT = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.S)
REFUSED = {  # a phrase, and the sample that must be found
    r"what\b[^.;:]*\bnone": "what the method is, is none",
    r"but for": "all but for the last",
    r"(?:is|are|was|were|be|not) (?:told|untold|foretold|looked for)": "it is told at the end",
    r"as it is(?! (?:stored|written|drawn))": "the value as it is",
    r"has beside": "what it has beside it",
    r"where (?:it|there) is (?:not|none)": "0 where there is none",
    r"hand(?:s|ed)? (?:it |them )?out": "handed out once",
    r"not wanted": "NULL = not wanted",
    r"whoever": "whoever asks",
    r"what is left": "what is left of it",
    r"(?:an?|one) (?:value|number|entry|row)s? an? (?:arm|lane|row|seat|mode|member|instant)": "one value an arm",
    r"whatever is returned": "must be freed whatever is returned",
    r"(?:courier|zygote|errand|dearer|deed)s?": "the courier",
}
SAID = {  # as above, in messages and in the page's English
    r"who runs": "ask who runs this server",
    r"(?:is|are|was) told": "it is told once",
    r"by (?:it|them)sel(?:f|ves)|as it is": "it ends by itself",
    r"here are|is there twice": "and here are 3",
    r"go(?:es)? (?:on|away)\b": "the motion goes on",
    r"(?:asked|looked|taken) for": "events are looked for",
    r"out of reach": "the store is out of reach",
    r"hand(?:s|ed)? out|whoever": "as it was handed out",
    r"has not\b": "a number that it has not",
    r"(?:is|are) wanted|wants": "--name is wanted",
    r"known here|any more|too far apart": "none that is known here",
    r"do(?:es)? not tell": "the data do not tell",
    r"where there": "null where there is none",
}
PHRASES = {re.compile(rf"\b{phrase}\b", re.I): sample for phrase, sample in REFUSED.items()}


SENTENCES = {re.compile(rf"\b(?:{phrase})", re.I): sample for phrase, sample in SAID.items()}


def said(text):
    """The refused phrases in string literals, of which parts stand one after the other."""
    for match in re.finditer(r'(?:"(?:\\.|[^"\\\n])*"\s*)+', re.sub(r"/\*.*?\*/|//[^\n]*", "", text, flags=re.S)):
        words = re.sub(r'"\s*"', "", match[0])
        yield from (hit[0] for phrase in SENTENCES for hit in phrase.finditer(words))


def found(text):
    """The refused phrases in the comments of C."""
    for match in COMMENT.finditer(text):
        if match[0].startswith("/"):
            words = re.sub(r"\s*\n\s*\*?\s*|\s+", " ", match[0])
            yield from (hit[0] for phrase in PHRASES for hit in phrase.finditer(words))


deaf = [sample for phrase, sample in PHRASES.items() if not list(found(f"/* {sample} */"))]
deaf += [sample for phrase, sample in SENTENCES.items() if not list(said(f'"{sample}"'))]
wrong = [f"the phrase that should find `{sample}` does not" for sample in deaf]
for path in sorted(path for room in ("core", "api", "server") for path in Path(room).rglob("*.[ch]")):
    if not LATER.match(str(path)):
        wrong += [f"{path}: write plainly: {phrase}" for phrase in found(path.read_text(encoding="utf-8"))]
for path in sorted([path for room in ("core", "api", "server") for path in Path(room).rglob("*.[ch]")] + [*Path("server/web/text/en").glob("*.js")]):
    wrong += [f"{path}: say plainly: {phrase}" for phrase in said(path.read_text(encoding="utf-8"))]
for line in wrong:
    print("FAIL", line)
if wrong:
    print(f"0 passed, {len(wrong)} failed")
sys.exit(bool(wrong))
END
command -v node >/dev/null || { echo 'skip words: node is not here'; echo '0 passed, 0 failed, 1 skipped'; exit 0; }
exec node tests/web/words.mjs
