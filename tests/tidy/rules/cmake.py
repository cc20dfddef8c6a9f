"""The libraries and programs that the folders' CMakeLists.txt declare (deploy/cmake/SleightTargets)."""

import dataclasses
import posixpath
import re

SIDES = ("common", "worker", "service", "clients")
_KEYWORDS = {"SOURCES", "LINKS", "LABELS", "TIMEOUT", "NO_INSTALL", "COMPUTES",
             "DECIDES_NOTHING", "ALL_SOURCES", "ALL_TESTS"}
_DECLARATION = re.compile(r"\bsleight_(library|program_parts|program)\s*\(")


@dataclasses.dataclass
class Target:
    """A library (its name is its folder, '/' as '_'), a program, or parts that programs share."""
    kind: str
    name: str
    folder: str
    cmake: str   # path of the CMakeLists.txt
    line: int
    sources: list = dataclasses.field(default_factory=list)  # paths from the root
    links: list = dataclasses.field(default_factory=list)    # (name, line)


def without_comments(text):
    """The same lines without comments (after '#' outside quotes)."""
    return "\n".join(re.match(r'(?:"(?:\\.|[^"\\])*"|[^#"]|")*', line).group(0)
                     for line in text.split("\n"))


def library_name(folder):
    return folder.replace("/", "_")


class Project:
    """All targets of the four sides. Tests may link anything that they test."""

    def __init__(self, tree):
        self.libraries = {}  # by name
        self.programs = []   # and their parts
        self.parts = {}      # by name
        for path in tree.files:
            if posixpath.basename(path) == "CMakeLists.txt" and path.split("/")[0] in SIDES:
                for target in _targets(tree.text(path), path):
                    if target.kind == "library":
                        self.libraries[target.name] = target
                    else:
                        self.programs.append(target)
                    if target.kind == "program_parts":
                        self.parts[target.name] = target
        self.by_folder = {library.folder: library for library in self.libraries.values()}
        self.programs_by_source = {}
        for program in self.programs:
            for source in program.sources:
                self.programs_by_source.setdefault(source, []).append(program)

    def library_of(self, path):
        """Library of the nearest folder above a path that has one. None if none."""
        folder = posixpath.dirname(path)
        while folder:
            if folder in self.by_folder:
                return self.by_folder[folder]
            folder = posixpath.dirname(folder)
        return None

    def is_main(self, path):
        """Returns whether a file is a main: a program's source named main*.cpp, or its own header."""
        name = posixpath.basename(path)
        return bool(self.programs_of(path)) and re.fullmatch(r"main\w*\.(cpp|h)", name) is not None

    def programs_of(self, path):
        """The programs that a source, or a header with a source beside it, belongs to."""
        return self.programs_by_source.get(re.sub(r"\.h$", ".cpp", path), [])

    def closure(self, target):
        """Names of all targets linked directly or indirectly, without the target itself."""
        seen = set()
        waiting = [name for name, _ in target.links]
        while waiting:
            name = waiting.pop()
            if name in seen:
                continue
            seen.add(name)
            linked = self.libraries.get(name) or self.parts.get(name)
            if linked:
                waiting.extend(link for link, _ in linked.links)
        return seen


def _targets(text, path):
    text = without_comments(text)
    folder = posixpath.dirname(path)
    for match in _DECLARATION.finditer(text):
        end = text.find(")", match.end())
        line = text.count("\n", 0, match.start()) + 1
        target = Target(match.group(1), library_name(folder), folder, path, line)
        section = None
        for token in re.finditer(r"[^\s\"]+", text[match.end():end]):
            word = token.group(0)
            word_line = text.count("\n", 0, match.end() + token.start()) + 1
            if word in _KEYWORDS:
                section = word
            elif section is None and target.kind != "library":
                target.name = word
            elif section == "SOURCES":
                target.sources.append(posixpath.join(folder, word))
            elif section == "LINKS":
                target.links.append((word, word_line))
        yield target
