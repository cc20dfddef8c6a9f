#!/usr/bin/env python3
"""The results version of a build: a hash of everything that determines the rows that runs store.

    deploy/version --results BUILD [--source FOLDER] [--list] [--cpp FILE]

BUILD is a preset's build folder. CMake has written `results_version.json` there, with the deciding
libraries, the folders left out, the compiler, and other linked libraries. For all objects of the deciding
libraries, the hash covers each file that the compiler opened: its content, and its path in the source tree
(outside the tree, the full path). It also covers each source's flags that can change results, the
compiler, and the library of elementary functions.

The hash leaves out generated files, files in the folders left out, flags that change only speed, checks,
warnings or paths (FLAGS_LEFT_OUT), and which sources were compiled together. So builds of all presets have
the same results version, and tests compare their digests.

The list of files comes from Ninja's record of the compiler's dependencies (`.ninja_deps`). Ninja writes an
object's record before it starts anything that depends on the object, so this program may run during a build.
--source hashes the files of another tree instead; a test uses this to plant changes.
"""
import argparse
import hashlib
import json
import os
import re
import shlex
import struct
import sys

MAGIC = b"# ninjadeps\n"
DEPS_RECORD = 0x80000000
# The hash covers -Ofast and all flags that begin with `-Wp,` or `-Wa,`.
FLAGS_LEFT_OUT = re.compile(
    r"-(O([0-3gs]|)$|g|W(?![pa],)|I|M|fsanitize|fno-sanitize|fno-omit-frame-pointer|fdiagnostics"
    r"|pthread$|DNDEBUG$|DSLEIGHT_SANITIZED)")
VALUES_LEFT_OUT = {"-I", "-isystem", "-include", "-o", "-c", "-MF", "-MT", "-MQ", "-x"}


class CannotTell(Exception):
    """The build's record of its files is missing or unreadable."""


def dependencies(build):
    """The files that the compiler opened for each output, from Ninja's record (format 3 or 4)."""
    path = os.path.join(build, ".ninja_deps")
    with open(path, "rb") as file:
        data = file.read()
    if not data.startswith(MAGIC):
        raise CannotTell(f"{path}: is no record of Ninja's")
    version, = struct.unpack_from("<i", data, len(MAGIC))
    if version not in (3, 4):
        raise CannotTell(f"{path}: expected format 3 or 4, found {version}")
    head = 4 + (8 if version == 4 else 4)  # output and its time
    names, found = [], {}
    place = len(MAGIC) + 4
    while place + 4 <= len(data):
        size, = struct.unpack_from("<I", data, place)
        is_deps = bool(size & DEPS_RECORD)
        size &= ~DEPS_RECORD
        place += 4
        if place + size > len(data):
            break  # Ninja is still writing this record
        if is_deps:
            output, = struct.unpack_from("<i", data, place)
            count = (size - head) // 4
            found[names[output]] = [
                names[i] for i in struct.unpack_from(f"<{count}i", data, place + head)]
        else:
            names.append(data[place:place + size - 4].rstrip(b"\0").decode())
        place += size
    return found


def sources_in(path):
    """The sources that a file includes if CMake generated it for a unity build, else the file itself."""
    if os.path.basename(os.path.dirname(path)) != "Unity":
        return [path]
    with open(path, encoding="utf-8") as file:
        return re.findall(r'^#include "(.+)"$', file.read(), re.MULTILINE)


def objects_of(build, libraries):
    """(object, source file, flags) of these libraries, and the build folder."""
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
        commands = json.load(file)
    folders = {f"CMakeFiles/{library}.dir/" for library in libraries}
    objects = []
    for command in commands:
        words = shlex.split(command["command"])
        output = words[words.index("-o") + 1]
        if any(f"/{folder}" in f"/{output}" for folder in folders):
            objects.append((output, command["file"], flags_of(words)))
    if not objects:
        raise CannotTell(f"{build}: found no object of {', '.join(libraries)}")
    return objects, commands[0]["directory"]


def flags_of(words):
    """The flags that can change results, in order."""
    flags, i = [], 0
    while i < len(words):
        word = words[i]
        if word in VALUES_LEFT_OUT:
            i += 2
            continue
        if word == "--param":  # ggc- parameters only affect the compiler's memory
            if not words[i + 1].startswith("ggc-"):
                flags += words[i:i + 2]
            i += 2
            continue
        if word.startswith("-") and not FLAGS_LEFT_OUT.match(word):
            flags.append(word)
        i += 1
    return tuple(flags)


def add_opened(name, found, folder, opened):
    """Adds a file, and for a precompiled header also the files in it."""
    path = os.path.normpath(os.path.join(folder, name))
    if path in opened:
        return
    opened.add(path)
    for inner in found.get(name, found.get(os.path.relpath(path, folder), [])):
        add_opened(inner, found, folder, opened)


class Deciding:
    """Everything that determines a build's results: files by their names in the hash, each object's flags,
    the compiler, and the linked libraries of elementary functions."""

    def __init__(self, build):
        with open(os.path.join(build, "results_version.json"), encoding="utf-8") as file:
            settings = json.load(file)
        self.compiler = settings["compiler"]
        source = settings["source"]
        found = dependencies(build)
        objects, folder = objects_of(build, settings["libraries"])
        opened, self.flags = set(), []
        for output, file, its_flags in objects:
            if output not in found:
                raise CannotTell(f"{build}: no record of {output}; build it first")
            for name in found[output]:
                add_opened(name, found, folder, opened)
            self.flags += [(self.name_of(path, source), its_flags) for path in sources_in(file)]
        self.flags.sort()
        left_out = set(settings["left_out"])
        self.files = {}
        for path in opened:
            if path.startswith(folder + os.sep) or os.path.dirname(path) in left_out:
                continue
            self.files[self.name_of(path, source)] = path
        for library in settings["linked"]:
            self.files[os.path.basename(library)] = library

    @staticmethod
    def name_of(path, source):
        """A file's path in the source tree, or its full path if it is elsewhere."""
        return os.path.relpath(path, source) if path.startswith(source + os.sep) else path

    def version(self, source=None):
        """The hash. With `source`, hashes the files of that tree instead of this one's."""
        total = hashlib.sha256()
        for name in sorted(self.files):
            path = self.files[name]
            if source and os.path.exists(os.path.join(source, name)):
                path = os.path.join(source, name)
            with open(path, "rb") as file:
                content = hashlib.sha256(file.read()).hexdigest()
            total.update(f"{name}\0{content}\n".encode())
        for name, its_flags in self.flags:
            total.update(f"{name} {' '.join(its_flags)}\n".encode())
        total.update(self.compiler.encode())
        return total.hexdigest()[:16]


def main():
    """Prints the version or its files, or writes the version as C++."""
    parser = argparse.ArgumentParser(prog="deploy/version --results", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--source", help="tree whose files are hashed instead of the build's")
    parser.add_argument("--list", action="store_true", help="list the hashed files")
    parser.add_argument("--cpp", metavar="FILE", help="write the version to FILE as C++, if it changed")
    arguments = parser.parse_args()

    deciding = Deciding(arguments.build)
    if arguments.list:
        print("\n".join(sorted(deciding.files)))
        return
    version = deciding.version(arguments.source)
    if not arguments.cpp:
        print(version)
        return
    text = ('#include "clients/cli/results_version.h"\n\nnamespace sleight::programs {\n'
            f'std::string_view results_version() {{ return "{version}"; }}\n'
            "}  // namespace sleight::programs\n")
    if not os.path.exists(arguments.cpp) or open(arguments.cpp, encoding="utf-8").read() != text:
        with open(arguments.cpp, "w", encoding="utf-8") as file:
            file.write(text)


if __name__ == "__main__":
    try:
        main()
    except (CannotTell, OSError, ValueError, KeyError) as failure:
        sys.exit(f"deploy/version --results: {failure}")
