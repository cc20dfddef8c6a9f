#!/usr/bin/env python3
"""The results version of a build: a hash of what decides the rows that runs store.

    deploy/version --results BUILD [--source FOLDER] [--list] [--cpp FILE]

BUILD is a preset's build folder, in which CMake has put `results_version.json`: the libraries that
decide, the folders left out, the compiler, and what else is linked. Hashed are, for all objects of
these libraries: each file that the compiler opened, by its place in the source tree (others by their
whole path) and content; for each source the flags that can change what is computed; the compiler; and
the library of elementary functions. Not hashed: generated files, files that lie in a folder left out,
flags that change only speed, checks, warnings or places (FLAGS_LEFT_OUT), and which sources were
compiled together. So builds of all presets have one results version, and tests compare their digests.

The files come from Ninja's record of what the compiler said (`.ninja_deps`). Ninja writes it object
by object, before it starts what depends on the object; so it may be read while a build goes on.
--source hashes another tree's files in place of the build's, which is how a test plants changes.
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
# -Ofast and what -Wp, and -Wa, hand on are not among them.
FLAGS_LEFT_OUT = re.compile(
    r"-(O([0-3gs]|)$|g|W(?![pa],)|I|M|fsanitize|fno-sanitize|fno-omit-frame-pointer|fdiagnostics"
    r"|pthread$|DNDEBUG$|DSLEIGHT_SANITIZED)")
VALUES_LEFT_OUT = {"-I", "-isystem", "-include", "-o", "-c", "-MF", "-MT", "-MQ", "-x"}


class CannotTell(Exception):
    """The build doesn't say which files it was made of."""


def dependencies(build):
    """Of each output the files that its compiler opened, from Ninja's record (format 3 or 4)."""
    path = os.path.join(build, ".ninja_deps")
    with open(path, "rb") as file:
        data = file.read()
    if not data.startswith(MAGIC):
        raise CannotTell(f"{path}: is no record of Ninja's")
    version, = struct.unpack_from("<i", data, len(MAGIC))
    if version not in (3, 4):
        raise CannotTell(f"{path}: format {version}; 3 and 4 are known")
    head = 4 + (8 if version == 4 else 4)  # output, then its time
    names, found = [], {}
    place = len(MAGIC) + 4
    while place + 4 <= len(data):
        size, = struct.unpack_from("<I", data, place)
        is_deps = bool(size & DEPS_RECORD)
        size &= ~DEPS_RECORD
        place += 4
        if place + size > len(data):
            break  # being written
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
    """The sources that one file stands for: those that CMake put together in it, or itself."""
    if os.path.basename(os.path.dirname(path)) != "Unity":
        return [path]
    with open(path, encoding="utf-8") as file:
        return re.findall(r'^#include "(.+)"$', file.read(), re.MULTILINE)


def objects_of(build, libraries):
    """(object, source file, flags) of these libraries, and the folder that they are built in."""
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
        raise CannotTell(f"{build}: no object of {', '.join(libraries)}")
    return objects, commands[0]["directory"]


def flags_of(words):
    """The flags that can change what is computed, in their order."""
    flags, i = [], 0
    while i < len(words):
        word = words[i]
        if word in VALUES_LEFT_OUT:
            i += 2
            continue
        if word == "--param":  # ggc-: how much memory the compiler takes
            if not words[i + 1].startswith("ggc-"):
                flags += words[i:i + 2]
            i += 2
            continue
        if word.startswith("-") and not FLAGS_LEFT_OUT.match(word):
            flags.append(word)
        i += 1
    return tuple(flags)


def add_opened(name, found, folder, opened):
    """Adds a file, and of a precompiled header what that was made of."""
    path = os.path.normpath(os.path.join(folder, name))
    if path in opened:
        return
    opened.add(path)
    for inner in found.get(name, found.get(os.path.relpath(path, folder), [])):
        add_opened(inner, found, folder, opened)


class Deciding:
    """What decides the results of a build: files, by their names in the hash; each object's flags;
    the compiler; and the libraries of elementary functions that it is linked with."""

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
                raise CannotTell(f"{build}: nothing is known of {output}; build it first")
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
        """A file's place in the source tree, or its whole path where it lies elsewhere."""
        return os.path.relpath(path, source) if path.startswith(source + os.sep) else path

    def version(self, source=None):
        """The hash; with another tree's files in place of this one's, where one is given."""
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
    """Prints the version, or its files, or writes it as C++."""
    parser = argparse.ArgumentParser(prog="deploy/version --results", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--source", help="a tree whose files are hashed in place of the build's")
    parser.add_argument("--list", action="store_true", help="the files, one a line")
    parser.add_argument("--cpp", metavar="FILE", help="writes C++, where that differs from FILE")
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
