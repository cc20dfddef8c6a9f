"""Documents: links and citations resolve, the glossary's names exist, each library has a row.

A name in backticks in docs/GLOSSARY.md must be a file or folder if it has a slash, else a word of
the code. Each library's folder must be in the first cell of a table row in docs/ARCHITECTURE.md.
"""

import posixpath
import re

from .tree import Finding, is_cpp, is_in

ARCHITECTURE = "docs/ARCHITECTURE.md"
GLOSSARY = "docs/GLOSSARY.md"
CODE_FOLDERS = ("common", "worker", "service", "clients")
_CODE_SPAN = re.compile(r"`([^`\n]+)`")
_HEADING = re.compile(r"#{1,6}\s+(.*?)\s*#*$")
_LINK = re.compile(r"\[[^\]\n]*\]\(([^()\s]+)\)")
_ELSEWHERE = re.compile(r"[a-z]+:")
# Citations of documents in comments and scripts: the name, perhaps with a section's title, which may continue
# on the comment's next line.
_CITED = re.compile(r'(?<![(\w/])docs/([A-Z][A-Z_]+|notebook/\w+)\b(?:\.md(?:,[\s/#]*"([^"]{1,100})")?)?')
_WORD = re.compile(r"[A-Za-z_]\w*")
_LIBRARY = re.compile(r"^\s*sleight_library\b", re.MULTILINE)


def check(tree):
    files = set(tree.files)
    places = files | {folder for path in tree.files for folder in _folders(path)}
    anchors = {path: _anchors(tree, path) for path in tree.files if path.endswith(".md")}
    for path in tree.files:
        if path.endswith(".md"):
            yield from _links(tree, path, places, anchors)
        yield from _cited(tree, path, anchors)
    if GLOSSARY in files:
        yield from _glossary(tree, places)
    if ARCHITECTURE in files:
        yield from _folder_rows(tree)


def _folders(path):
    """The folders that contain a file, up to the root."""
    while path:
        path = posixpath.dirname(path)
        yield path or "."


def _lines_outside_fences(tree, path):
    fenced = False
    for number, line in enumerate(tree.lines(path), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif not fenced:
            yield number, line


def _titles(tree, path):
    for _, line in _lines_outside_fences(tree, path):
        match = _HEADING.match(line)
        if match:
            yield _LINK.sub(lambda link: link.group(0)[1:].split("]")[0], match.group(1))


def _anchors(tree, path):
    """Anchors as code hosts derive them from headings: letters, digits, hyphens. Repeated anchors are
    numbered."""
    found = set()
    for title in _titles(tree, path):
        anchor = re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-")
        name, count = anchor, 0
        while name in found:
            count += 1
            name = f"{anchor}-{count}"
        found.add(name)
    return found


def _links(tree, path, places, anchors):
    for number, line in _lines_outside_fences(tree, path):
        for match in _LINK.finditer(_CODE_SPAN.sub("", line)):
            if _ELSEWHERE.match(match.group(1)):
                continue
            name, _, anchor = match.group(1).partition("#")
            target = path
            if name:
                target = posixpath.normpath(posixpath.join(posixpath.dirname(path), name))
            if target not in places:
                yield Finding(path, number, f"a dead link: {match.group(1)}; there is no {target}")
            elif anchor and anchor not in anchors.get(target, ()):
                yield Finding(path, number,
                              f"a dead link: {match.group(1)}; {target} has no such heading")


def _cited(tree, path, anchors):
    text = tree.text(path)
    for match in _CITED.finditer(text):
        line = text.count("\n", 0, match.start()) + 1
        target = f"docs/{match.group(1)}.md"
        if target not in anchors:
            yield Finding(path, line, f"cites {target}, which there is not")
        elif match.group(2):
            title = re.sub(r"\s*\n[\s/#]*", " ", match.group(2))
            if title not in set(_titles(tree, target)):
                yield Finding(path, line, f'cites "{title}", which {target} has no heading for')


def _glossary(tree, places):
    words = {word for path in tree.files if is_in(path, CODE_FOLDERS)
             for word in _code_words(tree, path)}
    for number, line in _lines_outside_fences(tree, GLOSSARY):
        for match in _CODE_SPAN.finditer(line):
            name = match.group(1)
            if "/" in name.strip("/"):
                if name.rstrip("/") not in places:
                    yield Finding(GLOSSARY, number, f"there is no {name}")
                continue
            for word in _WORD.findall(name):
                if word not in words:
                    yield Finding(GLOSSARY, number, f"no code has the name {word}")


def _folder_rows(tree):
    rows = {match.group(1) for _, line in _lines_outside_fences(tree, ARCHITECTURE)
            if line.startswith("|") for match in _CODE_SPAN.finditer(line.split("|")[1])}
    for path in tree.files:
        folder = posixpath.dirname(path)
        if (is_in(path, CODE_FOLDERS) and path.endswith("/CMakeLists.txt") and
                folder not in rows and _LIBRARY.search(tree.text(path))):
            yield Finding(path, 1, f"{ARCHITECTURE} has no table row for {folder}: add what it is for")


def _code_words(tree, path):
    if is_cpp(path):
        for code in tree.source(path).code:
            yield from _WORD.findall(code)
    elif path.endswith(".capnp"):
        yield from _WORD.findall(tree.text(path))
