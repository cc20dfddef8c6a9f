#!/usr/bin/python3
"""How long people wait: from start to written archive, of requests without settings.

  tests/bench/answers.py --bin build/release/bin                    all rows, 20 seeds each
  tests/bench/answers.py --bin ... --only ACM --seeds 3 --limit 300

Of each row five animations as wanted (`method = "search"`), and five independent solutions in the
model's proportions (no `method`). Words have [world] with the word alone; dice have [world] and
[constraint] of their file in requests/. Seeds are 1, 2, ... A run that takes longer than --limit
seconds is stopped and shown as "over"; medians count it as the limit. A row whose first run is over is
not run again. Prints a table and, with --json, the same for programs.
"""

import argparse
import json
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).parents[2]
WORDS = ["HI", "ACM", "SLEIGHT", "HELLO WORLD"]
DICE = ["die", "die_exact", "six_dice"]
WAYS = {
    "found": '[sampler]\nmethod = "search"\nseed = {seed}\n[stop]\nfound = 5\n',
    "in proportion": "[sampler]\nseed = {seed}\n[stop]\nindependent_solutions = 5\n",
}


def scene(row):
    """[world] and [constraint] of a row's request."""
    if row in WORDS:
        return f'[world]\nname = "spelling"\nword = "{row}"\n'
    text = (ROOT / f"requests/{row}.toml").read_text()
    return re.split(r"^\[(?:sampler|stop|output)\]", text, flags=re.MULTILINE)[0]


def seconds(arguments, row, way, seed, folder):
    """How long one run takes; nothing if it is stopped."""
    request = pathlib.Path(folder) / "request.toml"
    request.write_text(scene(row) + WAYS[way].format(seed=seed))
    command = [str(arguments.bin / "sleight"), "direct", str(request), "-o", f"{folder}/a.h5",
               "--fresh", "-q"]
    begin = time.monotonic()
    try:
        subprocess.run(command, check=True, capture_output=True, timeout=arguments.limit)
    except subprocess.TimeoutExpired:
        return None
    except subprocess.CalledProcessError as error:
        sys.exit(f"{' '.join(command)} ended with {error.returncode}:\n{error.stderr.decode()}")
    return time.monotonic() - begin


def measure(arguments, row, way):
    times = []
    with tempfile.TemporaryDirectory(prefix="sleight-answers-") as folder:
        for seed in range(1, arguments.seeds + 1):
            times.append(seconds(arguments, row, way, seed, folder))
            if times == [None]:
                break
    counted = [arguments.limit if taken is None else taken for taken in times]
    return {"row": row, "way": way, "seeds": len(times), "over": times.count(None),
            "median_s": statistics.median(counted), "least_s": min(counted), "most_s": max(counted)}


def in_words(result):
    if result["over"] == result["seeds"]:
        return f"over {result['median_s']:.0f} s, {result['seeds']} seeds"
    text = f"{result['median_s']:.2g} ({result['least_s']:.2g}, {result['most_s']:.2g})"
    return text + (f", {result['over']} over" if result["over"] else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    parser.add_argument("--only", choices=WORDS + DICE, nargs="+", default=WORDS + DICE)
    parser.add_argument("--ways", choices=list(WAYS), nargs="+", default=list(WAYS))
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--limit", type=float, default=120, help="seconds of one run")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()

    results = []
    for row in arguments.only:
        for way in arguments.ways:
            results.append(measure(arguments, row, way))
            print(f"{row}, {way}: {in_words(results[-1])}", file=sys.stderr)
    if arguments.json:
        print(json.dumps(results))
        return
    print(f"| request | {' | '.join(f'five {way}: median (least, most)' for way in arguments.ways)} |")
    print("|---" * (1 + len(arguments.ways)) + "|")
    for row in arguments.only:
        cells = [in_words(result) for result in results if result["row"] == row]
        print(f"| {row} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
