"""Text: no path of one machine, no registry host, no unfinished business, no compiled program,
scripts that parse.
"""

import re
import subprocess

from .tree import Finding, is_in, is_shell

BYTES_MAX = 2_000_000  # larger files are data
SCRIPT_FOLDERS = ("deploy", "tests", ".ci")


def _either(*alternatives):
    return "(?:" + "|".join(alternatives) + ")"


# The words are assembled here so that this file doesn't find itself.
_PATHS = re.compile(r"(?<![\w.})])/" + _either("work" + "/", "tmp" + r"/w\w*", "home" + r"/\w+/",
                                                "root" + "/"))
_HOSTS = re.compile(_either(
    r"\b(?:deb|security|ftp|snapshot)\." + r"debian\.org",
    r"\b(?:archive|security)\." + r"ubuntu\.com",
    r"\bregistry\." + r"[a-z][\w-]*\.(?:org|com|io|net|dev)\b",
    r"\b(?:pypi|pythonhosted)\." + r"org\b",
    r"\b(?:ghcr|docker|quay|gcr)\." + r"io\b",
    r"\b(?:artifactory|nexus|verdaccio)[\w-]*\." + r"[a-z]"))
_UNFINISHED = re.compile(r"\b" + _either("TO" + "DO", "FIX" + "ME", "X" + "XX") + r"\b")
_RESOLVED = re.compile(r'"resolved"\s*:')

_LINE_RULES = (
    (_PATHS, "the path of one machine: {}"),
    (_HOSTS, "the host of a registry: {}; name packages, not where they come from"),
    (_UNFINISHED, "{}: finish it, or open an issue"),
)


def check(tree):
    for path in tree.files:
        if tree.is_program(path):
            yield Finding(path, 1, "a compiled program; keep what is built out of the project")
        text = tree.text(path)
        if len(text) <= BYTES_MAX:
            yield from _lines(path, text)
        if is_in(path, SCRIPT_FOLDERS) and is_shell(tree, path):
            yield from _script(tree, path)


def _lines(path, text):
    is_lock = path.endswith(("package-lock.json", "npm-shrinkwrap.json"))
    for pattern, message in _LINE_RULES:
        for match in pattern.finditer(text):
            yield Finding(path, text.count("\n", 0, match.start()) + 1,
                          message.format(match.group(0)))
    if is_lock:
        for match in _RESOLVED.finditer(text):
            yield Finding(path, text.count("\n", 0, match.start()) + 1,
                          "a lock file without addresses: npm install "
                          "--omit-lockfile-registry-resolved")


def _script(tree, path):
    if not tree.is_executable(path):
        yield Finding(path, 1, f"a script that can't be run; chmod +x {path}")
    shell = "bash" if "bash" in tree.lines(path)[0] else "sh"
    run = subprocess.run([shell, "-n", tree.root / path], capture_output=True, text=True,
                         check=False)
    if run.returncode != 0:
        said = run.stderr.strip().splitlines() or ["no reason given"]
        line = re.search(r": (?:line )?(\d+): ", said[0])
        reason = re.sub(r"^.*?: (?:line )?\d+: ", "", said[0])
        yield Finding(path, int(line.group(1)) if line else 1, f"{shell} -n: {reason}")
