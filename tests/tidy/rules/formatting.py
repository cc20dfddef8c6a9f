"""Formatting: clang-format finds nothing to change in any .h or .cpp."""

import concurrent.futures
import os
import re
import shutil
import subprocess

from .tree import CannotCheck, Finding, is_cpp

BATCH = 20
_COMPLAINT = re.compile(r"(.+?):(\d+):\d+: (?:error|warning): code should be clang-formatted")


def check(tree):
    files = [path for path in tree.files if is_cpp(path)]
    if not files:
        return
    if shutil.which("clang-format") is None:
        raise CannotCheck("clang-format is not installed; run deploy/install-deps")
    batches = [files[i:i + BATCH] for i in range(0, len(files), BATCH)]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        for out in pool.map(lambda batch: _complaints(tree.root, batch), batches):
            yield from out


def _complaints(root, files):
    run = subprocess.run(["clang-format", "--dry-run", "-Werror", "--style=file", *files],
                         cwd=root, capture_output=True, text=True, check=False)
    first = {}
    for line in run.stderr.splitlines():
        match = _COMPLAINT.match(line)
        if match:
            first.setdefault(match.group(1), int(match.group(2)))
    if run.returncode != 0 and not first:
        raise CannotCheck(f"clang-format failed: {run.stderr.strip()[:400]}")
    return [Finding(path, line, f"not formatted from here on; run: clang-format -i {path}")
            for path, line in first.items()]
