"""The files of a tree, read once, and C++ taken apart into code and comments."""

import bisect
import dataclasses
import os
import pathlib
import re
import subprocess

SKIPPED_FOLDERS = {"build", ".git", "node_modules", "__pycache__", "demo-out"}


class CannotCheck(Exception):
    """A requirement of the checks is missing."""


@dataclasses.dataclass(frozen=True, order=True)
class Finding:
    path: str
    line: int
    message: str
    check: str = ""

    def __str__(self):
        return f"{self.path}:{self.line}: {self.message} [{self.check}]"


def without_git(environment):
    """Environment in which git looks at the tree, not at a hook's index."""
    return {name: value for name, value in environment.items() if not name.startswith("GIT_")}


class Tree:
    """All files known to git (including new files, without ignored ones), or all files without git."""

    def __init__(self, root):
        self.root = pathlib.Path(root).resolve()
        self.files = sorted(path for path in self._listed() if (self.root / path).is_file())
        self._texts = {}
        self._sources = {}

    def _git(self, *arguments):
        return subprocess.run(["git", "-C", self.root, *arguments], capture_output=True, text=True,
                              check=True, env=without_git(os.environ)).stdout

    def _listed(self):
        try:
            top = self._git("rev-parse", "--show-toplevel").strip()
            if pathlib.Path(top).resolve() == self.root:
                names = self._git("ls-files", "-co", "--exclude-standard", "-z").split("\0")
                return {name for name in names if name}
        except (OSError, subprocess.CalledProcessError):
            pass
        return self._walked()

    def _walked(self):
        for folder, names, files in os.walk(self.root):
            names[:] = [name for name in names if name not in SKIPPED_FOLDERS]
            for name in files:
                yield (pathlib.Path(folder) / name).relative_to(self.root).as_posix()

    def text(self, path):
        """A file's text. Empty if it isn't UTF-8."""
        if path not in self._texts:
            try:
                self._texts[path] = (self.root / path).read_bytes().decode("utf-8")
            except UnicodeDecodeError:
                self._texts[path] = ""
        return self._texts[path]

    def is_program(self, path):
        with open(self.root / path, "rb") as file:
            return file.read(4) == b"\x7fELF"

    def lines(self, path):
        return self.text(path).split("\n")

    def source(self, path):
        if path not in self._sources:
            self._sources[path] = Source(self.text(path))
        return self._sources[path]

    def is_executable(self, path):
        return os.access(self.root / path, os.X_OK)


class Source:
    """C++ by lines: `code` without comments and with empty strings, `comments` with nothing else.

    Three lists of equal length: raw, code, comments.
    """

    _TOKEN = re.compile(
        r'R"(?P<mark>[^()\\\s]{0,16})\(.*?\)(?P=mark)"'
        r'|"(?:\\.|[^"\\\n])*"'
        r"|(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])*'"
        r"|//[^\n]*"
        r"|/\*.*?\*/", re.DOTALL)

    def __init__(self, text):
        self.raw = text.split("\n")
        self.comments = [""] * len(self.raw)
        starts = [0]
        for line in self.raw:
            starts.append(starts[-1] + len(line) + 1)

        def replaced(match):
            token = match.group(0)
            ends = "\n" * token.count("\n")
            if not token.startswith(("//", "/*")):
                return '""' + ends
            first = bisect.bisect_right(starts, match.start()) - 1
            for offset, part in enumerate(token.split("\n")):
                self.comments[first + offset] += part
            return " " + ends

        self.code = self._TOKEN.sub(replaced, text).split("\n")


_INCLUDE = re.compile(r'\s*#\s*include\s*([<"])([^>"]+)[>"]')


def includes(tree, path):
    """(line, name, quoted) of each #include outside comments."""
    source = tree.source(path)
    for number, (raw, code) in enumerate(zip(source.raw, source.code), 1):
        if "include" in code:
            match = _INCLUDE.match(raw)
            if match:
                yield number, match.group(2), match.group(1) == '"'


def is_header(path):
    return path.endswith(".h")


def is_cpp(path):
    return path.endswith((".h", ".cpp"))


def is_cmake(path):
    return path.endswith((".cmake", "CMakeLists.txt", "CMakePresets.json"))


def is_shell(tree, path):
    """Returns whether a file is a shell script, by its first line or its name."""
    first = tree.text(path)[:80].split("\n", 1)[0]
    return path.endswith(".sh") or bool(re.match(r"#!.*\b(ba|da)?sh\b", first))


def is_in(path, folders):
    """Returns whether a path is in one of the folders or below."""
    return any(path == folder or path.startswith(folder + "/") for folder in folders)
