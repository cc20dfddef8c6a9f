"""The checks by name, and the waivers that a line may have.

A check is a module with `check(tree)`, which yields findings, and its docstring's first line is for `--list`.
"""

import dataclasses
import re

from . import constructs, dependencies, documents, formatting, provenance, shells, sizes, text
from .tree import Finding, is_cmake, is_cpp, is_shell

CHECKS = {
    "dependencies": dependencies,
    "shells": shells,
    "formatting": formatting,
    "constructs": constructs,
    "sizes": sizes,
    "text": text,
    "documents": documents,
    "provenance": provenance,
}

WORDS_MIN = 3
_WAIVER = re.compile(r"(?://|#)\s*tidy:\s*(.*?)\s*(?:\*/)?$")


@dataclasses.dataclass(frozen=True)
class Waiver:
    path: str
    line: int
    reason: str


def waivers(tree):
    """Every waiver in the tree, in order of file and line, valid or not."""
    found = []
    for path in tree.files:
        if is_cpp(path):
            lines = tree.source(path).comments
        elif is_cmake(path) or is_shell(tree, path):
            lines = tree.lines(path)
        else:
            continue
        for number, line in enumerate(lines, 1):
            match = _WAIVER.search(line) if "tidy:" in line else None
            if match:
                found.append(Waiver(path, number, match.group(1)))
    return found


def run(tree, only=None):
    """The sorted findings of the checks, without those that a valid waiver covers."""
    names = only or list(CHECKS)
    raw = {finding for name in names for finding in
           (dataclasses.replace(f, check=name) for f in CHECKS[name].check(tree))}
    excused = set()
    findings = []
    for waiver in waivers(tree):
        covered = {f for f in raw if (f.path, f.line) == (waiver.path, waiver.line)}
        if len(waiver.reason.split()) < WORDS_MIN:
            findings.append(Finding(waiver.path, waiver.line,
                                    f"an excuse needs a reason of at least {WORDS_MIN} words",
                                    "waivers"))
        elif covered:
            excused |= covered
        elif not only:
            findings.append(Finding(waiver.path, waiver.line,
                                    "this excuse excuses nothing; remove it", "waivers"))
    return sorted(findings + list(raw - excused))
