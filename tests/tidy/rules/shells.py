"""Shells: MPI, HDF5, Cap'n Proto, SQLite, OpenSSL, files and clocks stay where they belong.

Only certain folders may include or link each outside library. Folders that SLEIGHT_SHELLS=OFF
builds use none of these libraries, directly or through other libraries.
"""

import re

from .cmake import SIDES, Project
from .tree import Finding, includes, is_cpp, is_in

# Algorithms: no outside library, no clock, no file.
PURE = ("worker/physics", "worker/sampling", "worker/worlds", "service/core", "common/plan",
        "common/math", "common/random")
PURE_TESTS = (*("tests/unit/" + folder for folder in PURE), "tests/engines", "tests/tempering")
# Folders that SLEIGHT_SHELLS=OFF builds, and its exceptions.
BARE = PURE + ("worker/run", "common/base", "common/request", "common/archive", "common/schema")
SHELLS = ("worker/run/mpi", "common/archive/digest", "common/archive/hdf5",
          "common/archive/reader_program", "common/archive/remote", "common/schema/wire")

# Name, headers, link names, folders that may use it, and whether a program's main may too.
LIBRARIES = (
    ("MPI", r"mpi\.h", r"MPI::.*", ("worker/run/mpi", "service/coordinator/mpi"), True),
    ("HDF5", r"(hdf5\w*|H5\w+)\.h", r"sleight_hdf5|PkgConfig::HDF5\w*|hdf5.*",
     ("common/archive/hdf5",), False),
    ("SQLite", r"sqlite3(ext)?\.h", r"SQLite::.*|sqlite3", ("common/store",), False),
    ("xxHash", r"xxh(ash|3)\.h", r"PkgConfig::XXHASH|xxhash", ("common/store",), False),
    ("Cap'n Proto", r"(capnp|kj)/.*|.*\.capnp\.h",
     r"CapnProto::.*|capnp.*|kj.*|sleight_(schema|service)_generated",
     ("common/schema/wire", "common/rpc"), False),
    ("OpenSSL", r"openssl/.*", r"OpenSSL::.*|crypto|ssl", ("common/hash", "common/access"), False),
    ("the JSON library", r"nlohmann/.*", r"nlohmann_json.*", ("common/json",), False),
    ("spdlog", r"spdlog/.*", r"spdlog.*", ("common/logging",), False),
    ("librsvg", r"librsvg/.*|cairo.*|gdk-pixbuf/.*", r"PkgConfig::RSVG|rsvg.*", ("clients/plot",),
     False),
    ("libpng", r"libpng\d*/.*", r"PkgConfig::PNG|PNG::.*|png", ("clients/plot",), False),
    ("libseccomp", r"seccomp\.h", r"PkgConfig::SECCOMP|seccomp", ("common/archive/reader_program",),
     False),
    # common/archive/reader_program maps nothing; it uses the header to forbid executable memory.
    ("memory mapping", r"sys/mman\.h", r"(?!)", ("common/base", "common/archive/reader_program"),
     False),
)

# Also forbidden in pure code: the wall clock, files, sockets.
EFFECTS = (
    ("the clock", r"chrono|ctime|time\.h|sys/time\.h"),
    ("files", r"fstream|filesystem|fcntl\.h|unistd\.h|sys/stat\.h|cstdio|stdio\.h"),
    ("sockets", r"sys/socket\.h|sys/un\.h|netinet/.*|arpa/.*|netdb\.h|poll\.h|sys/epoll\.h"),
)


def check(tree):
    project = Project(tree)
    for path in tree.files:
        if is_cpp(path):
            yield from _includes(tree, project, path)
    for target in [*project.libraries.values(), *project.programs]:
        yield from _links(project, target)


def _includes(tree, project, path):
    shipped = path.split("/")[0] in SIDES
    for line, name, _ in includes(tree, path):
        for library, headers, _, folders, mains in LIBRARIES:
            if not re.fullmatch(headers, name):
                continue
            if is_in(path, PURE + PURE_TESTS):
                yield Finding(path, line, f"algorithms do without {library}: <{name}>")
            elif shipped and not is_in(path, folders) and not (mains and project.is_main(path)):
                yield Finding(path, line, f"{library} belongs to {' and '.join(folders)}: <{name}>")
        if is_in(path, PURE):
            for effect, headers in EFFECTS:
                if re.fullmatch(headers, name):
                    yield Finding(path, line, f"only shells touch {effect}: <{name}>")


def _links(project, target):
    bare = (target.kind == "library" and is_in(target.folder, BARE)
            and not is_in(target.folder, SHELLS))
    for name, line in target.links:
        linked = project.libraries.get(name)
        reached = {name} | (project.closure(linked) if linked and bare else set())
        for library, _, links, folders, mains in LIBRARIES:
            through = sorted(n for n in reached
                             if n not in project.libraries and re.fullmatch(links, n))
            if not through:
                continue
            if bare:
                way = through[0] if through[0] == name else f"{through[0]} through {name}"
                yield Finding(target.cmake, line,
                              f"{target.folder} is built without {library}: links {way}")
            elif not is_in(target.folder, folders) and not (mains and target.kind == "program"):
                yield Finding(target.cmake, line,
                              f"{library} belongs to {' and '.join(folders)}: links {name}")
