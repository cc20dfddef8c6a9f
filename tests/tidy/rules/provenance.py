"""Provenance: each picture and each table of measured numbers in docs says how it was made.

A picture (SVG) has metadata with the lines `command: deploy/figures NAME`, `commit: HASH` and
`seed: N`. Above a table of numbers (one with a column to the right, and any in docs/MEASUREMENTS.md
and docs/notebook) is the line

    <!-- table NAME: commit HASH; deploy/figures NAME -->

or, if no program remakes the table, `not remade: the reason in at least three words` in place of the command.
deploy/figures must contain each NAME, in quotes.
"""

import posixpath
import re

from .tree import Finding

COMMAND = "deploy/figures"
WORDS_MIN = 3
_METADATA = re.compile(r"<metadata>\n(.*?)</metadata>", re.DOTALL)
_COMMIT = re.compile(r"[0-9a-f]{7,40}")
_BY_COMMAND = re.compile(re.escape(COMMAND) + r" (\w+)")
_MARK = re.compile(r"\s*<!--\s*table\b(.*?)(?:-->)?\s*$")
_GOOD_MARK = re.compile(r" (\w+): commit (\S+); (.+) ")
_NOT_REMADE = re.compile(r"not remade: (.*)")
_UNDERLINE = re.compile(r"\s*\|(?:\s*:?-+:?\s*\|)+\s*$")
_TO_THE_RIGHT = re.compile(r"-:\s*\|")
_CODE = re.compile(r"\s*```")


def check(tree):
    remade = set(re.findall(r'"(\w+)"', tree.text(COMMAND))) if COMMAND in tree.files else set()
    seen = {}
    for path in tree.files:
        if not path.startswith("docs/"):
            continue
        if path.endswith(".svg"):
            yield from _picture(tree, path, remade)
        elif path.endswith(".md"):
            yield from _tables(tree, path, remade, seen)


def _commit(path, line, commit):
    if not _COMMIT.fullmatch(commit):
        yield Finding(path, line, f"'{commit}' is no commit; make it with programs of a commit")


def _picture(tree, path, remade):
    metadata = _METADATA.search(tree.text(path))
    if not metadata:
        yield Finding(path, 1, f"a picture without metadata of how it was made; see {COMMAND}")
        return
    notes = dict(line.split(": ", 1) for line in metadata.group(1).splitlines() if ": " in line)
    for name in ("command", "commit", "seed"):
        if name not in notes:
            yield Finding(path, 1, f"its metadata has no {name}")
    command = _BY_COMMAND.fullmatch(notes.get("command", f"{COMMAND} {_stem(path)}"))
    if not command:
        yield Finding(path, 1, f"its command is not {COMMAND} NAME")
    elif command.group(1) not in remade:
        yield Finding(path, 1, f"{COMMAND} has no {command.group(1)}")
    elif not (_stem(path) + "_").startswith(command.group(1) + "_"):
        yield Finding(path, 1, f"{COMMAND} {command.group(1)} makes another picture")
    if "commit" in notes:
        yield from _commit(path, 1, notes["commit"])
    if not notes.get("seed", "0").isdigit():
        yield Finding(path, 1, "its seed is no number")


def _stem(path):
    return posixpath.splitext(posixpath.basename(path))[0]


def _tables(tree, path, remade, seen):
    """Marks, each followed by its table, and tables, each after its mark if it needs one."""
    lines = tree.lines(path)
    always = path == "docs/MEASUREMENTS.md" or path.startswith("docs/notebook/")
    fenced = False
    for number, line in enumerate(lines, 1):
        fenced ^= bool(_CODE.match(line))
        if fenced:
            continue
        if _MARK.match(line):
            yield from _mark(path, number, line, remade, seen)
            if not _UNDERLINE.match("".join(lines[number + 1:number + 2])):
                yield Finding(path, number, "no table stands below this mark")
        elif _UNDERLINE.match(line) and (always or _TO_THE_RIGHT.search(line)):
            if not _MARK.match("".join(lines[max(number - 3, 0):max(number - 2, 0)])):
                yield Finding(path, number - 1, "a table of numbers without a line <!-- table NAME: "
                                                "commit HASH; command --> above it")


def _mark(path, number, line, remade, seen):
    mark = _GOOD_MARK.fullmatch(_MARK.match(line).group(1)) if line.rstrip().endswith("-->") else None
    if not mark:
        yield Finding(path, number, "not <!-- table NAME: commit HASH; command -->")
        return
    name, commit, command = mark.groups()
    yield from _commit(path, number, commit)
    if name in seen:
        yield Finding(path, number, f"{seen[name]} has a table {name} too")
    seen[name] = path
    reason = _NOT_REMADE.fullmatch(command)
    if reason:
        if len(reason.group(1).split()) < WORDS_MIN:
            yield Finding(path, number, f"a reason needs at least {WORDS_MIN} words")
    elif command != f"{COMMAND} {name}":
        yield Finding(path, number, f"its command is neither '{COMMAND} {name}' nor 'not remade: ...'")
    elif name not in remade:
        yield Finding(path, number, f"{COMMAND} has no {name}")
