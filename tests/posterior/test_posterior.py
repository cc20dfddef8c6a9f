#!/usr/bin/python3
"""Compares our diagnostics of Markov chains with R's package posterior.

    test_posterior.py --writer PROGRAM [--seed N]

Goal: every measure equals posterior's within 1e-10 relative, and is NaN where posterior's is NA, for
chains of all kinds and shapes. Method: PROGRAM writes seeded arrays and our measures of them, one R
process writes posterior's measures, and this program compares the two. Then corrupt a value, a NaN and a
line in turn; the comparison must fail each time. Prints the greatest relative difference of each measure.

If the sign of a sum that is 0 determines an effective sample size (see measure.R), posterior's value is
rounding error. Such a value may differ, but only a few may.
"""

import argparse
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

TOLERANCE = 1e-10
MARGIN = 1e-11          # below it, rounding decided
UNDECIDED_MAX = 0.001   # the share of all numbers that may differ for that reason
ARRAYS_MIN = 200


def number(text):
    if text.upper() in ("NA", "NAN", "-NAN"):
        return math.nan
    return float(text) if "inf" in text.lower() else float.fromhex(text)


def read(path):
    """(array, measure) -> [numbers], in the order of the file."""
    found = {}
    for line in path.read_text().splitlines():
        name, measure, *numbers = line.split()
        found[name, measure] = [number(text) for text in numbers]
    return found


def difference(ours, theirs):
    """Relative; 0 for equal ones, infinities and NaNs included."""
    if ours == theirs or (math.isnan(ours) and math.isnan(theirs)):
        return 0.0
    if not math.isfinite(ours) or not math.isfinite(theirs):
        return math.inf
    return abs(ours - theirs) / max(abs(ours), abs(theirs))


def compare(ours, theirs):
    """(failures, greatest difference by measure, the keys that rounding decided)"""
    failures = [f"{' '.join(key)}: on one side only" for key in ours.keys() ^ theirs.keys()]
    greatest, undecided = {}, []
    for key in ours.keys() & theirs.keys():
        (our_value,), (their_value, margin) = ours[key], theirs[key]
        apart = difference(our_value, their_value)
        if apart > TOLERANCE and margin < MARGIN:
            undecided.append(key)
            continue
        greatest[key[1]] = max(greatest.get(key[1], 0.0), apart)
        if apart > TOLERANCE:
            failures.append(f"{' '.join(key)}: {our_value!r}, posterior {their_value!r}, "
                            f"relative {apart:.2g}, margin {margin:.2g}")
    if len(undecided) > UNDECIDED_MAX * len(ours):
        failures.append(f"{len(undecided)} of {len(ours)} undecided")
    return sorted(failures), greatest, undecided


def check_comparer(ours, theirs):
    """It must fail: for a value that is 3e-10 off, a NaN in its place, and a line that lacks."""
    key = next(key for key, (value, margin) in theirs.items()
               if math.isfinite(value) and value != 0 and margin > MARGIN)
    for spoilt in (ours[key][0] * (1 + 3 * TOLERANCE), math.nan, None):
        changed = dict(ours)
        if spoilt is None:
            del changed[key]
        else:
            changed[key] = [spoilt]
        if not compare(changed, theirs)[0]:
            raise AssertionError(f"{key} spoilt to {spoilt} went unnoticed")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--writer", required=True)
    parser.add_argument("--seed", default="1")
    options = parser.parse_args()
    rscript = shutil.which("Rscript")
    if rscript is None:
        sys.exit("there is no Rscript: run deploy/install-deps (r-base-core, r-cran-posterior)")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        our_seconds = subprocess.run([options.writer, folder, options.seed], check=True,
                                     capture_output=True, text=True).stdout.strip()
        start = time.monotonic()
        script = pathlib.Path(__file__).with_name("measure.R")
        version = subprocess.run([rscript, "--vanilla", script, folder], check=True,
                                 stdout=subprocess.PIPE, text=True).stdout.strip()
        their_seconds = time.monotonic() - start
        ours, theirs = read(folder / "ours.txt"), read(folder / "theirs.txt")

    arrays = len({name for name, _ in ours})
    if arrays < ARRAYS_MIN:
        sys.exit(f"{arrays} arrays; at least {ARRAYS_MIN} are wanted")
    failures, greatest, undecided = compare(ours, theirs)
    print(f"{arrays} arrays, seed {options.seed}, posterior {version}: "
          f"we {our_seconds} s, R {their_seconds:.1f} s")
    for measure, apart in sorted(greatest.items()):
        print(f"  {measure:20s} {apart:.1e}")
    print(f"  decided by posterior's rounding: {len(undecided)} of {len(ours)}")
    if failures:
        print("\n".join(failures[:40]), file=sys.stderr)
        sys.exit(f"{len(failures)} failures; again: {' '.join(sys.argv)}")
    check_comparer(ours, theirs)


if __name__ == "__main__":
    main()
