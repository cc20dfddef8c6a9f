#!/usr/bin/env python3
"""Checks that objects compiled without the outside libraries include none of their headers.

  tests/tidy/built_bare.py BUILD_FOLDER        a build by Ninja, of any preset

Ninja records for each object all headers that the compiler opened. Objects of the folders that
SLEIGHT_SHELLS=OFF builds must not include a header that rules/shells.py assigns to another folder. Prints
each object that does, and exits with 1. Exits with 2 if the build has no such objects.
"""

import pathlib
import re
import subprocess
import sys

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from rules.shells import BARE, LIBRARIES, SHELLS  # noqa: E402
from rules.tree import is_in  # noqa: E402

# The C library's own headers may include each other.
_LIBRARIES = [(name, re.compile(r"(?:.*/)?(?:" + headers + ")"))
              for name, headers, *_ in LIBRARIES if name != "memory mapping"]


def headers_by_object(deps):
    """Output of `ninja -t deps`, as object -> headers."""
    found = {}
    headers = []
    for line in deps.splitlines():
        if line.startswith(" "):
            headers.append(line.strip())
        elif ": #deps" in line:
            headers = found.setdefault(line.split(": #deps")[0], [])
    return found


def is_bare(name):
    """Returns whether an object belongs to a folder that is built without the outside libraries."""
    folder = name.split("/CMakeFiles/")[0]
    return is_in(folder, BARE) and not is_in(folder, SHELLS)


def strangers(found):
    """(object, library, header) of each forbidden header."""
    for name, headers in sorted(found.items()):
        if not is_bare(name):
            continue
        for header in headers:
            for library, pattern in _LIBRARIES:
                if pattern.fullmatch(header):
                    yield name, library, header


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    run = subprocess.run(["ninja", "-C", sys.argv[1], "-t", "deps"], capture_output=True, text=True,
                         check=False)
    found = headers_by_object(run.stdout)
    objects = sum(is_bare(name) for name in found)
    if run.returncode != 0 or objects == 0:
        print(f"built_bare: {sys.argv[1]}: no object to look at {run.stderr}", file=sys.stderr)
        return 2
    bad = list(strangers(found))
    for name, library, header in bad:
        print(f"{name}: {library}: {header}")
    print(f"built_bare: {objects} objects, {len(bad)} headers that they should not know",
          file=sys.stderr)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
