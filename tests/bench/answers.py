#!/usr/bin/python3
"""Measures how long requests without settings take to deliver five animations, or the odds.

  tests/bench/answers.py --bin build/release/bin                    all rows, 20 seeds each
  tests/bench/answers.py --bin ... --only ACM --ways relaxed --yardstick 4.6
  tests/bench/answers.py --bin ... --only HI --ways "in proportion" --seeds 3 --limit 300
  tests/bench/answers.py --bin ... --only HI OK ACM SLEIGHT --ways odds --limit 600

Measures the time from the start to the first archive on disk, and to the end of the command. Rows for
dice have [world] and [constraint] of their file in requests/. Any other row is a word, whose [world] has
only the word. Odds are requested with an error of 0.3. Seeds are 1, 2, ... --yardstick divides by the
seconds of a program that measures the machine. A run that takes longer than --limit seconds is stopped
and shown as "over"; medians count it as the limit. If the first run of a row is over the limit, the row
is not run again. Prints a table. With --json, prints the same in seconds for programs.
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
WAYS = {"found": ["--found"], "relaxed": [], "in proportion": ["--in-proportion"], "odds": []}
STOP = {"odds": "[stop]\nodds = 0.3\n"}


def scene(row):
    """[world] and [constraint] of a row's request."""
    if row not in DICE:
        return f'[world]\nname = "spelling"\nword = "{row}"\n'
    text = (ROOT / f"requests/{row}.toml").read_text()
    return re.split(r"^\[(?:sampler|stop|output)\]", text, flags=re.MULTILINE)[0]


def seconds(arguments, row, way, seed, folder):
    """Time to the first archive and to the end. Nothing if the run is stopped."""
    request = pathlib.Path(folder) / "request.toml"
    request.write_text(scene(row) + STOP.get(way, ""))
    archive = pathlib.Path(folder) / f"{seed}.h5"
    command = [str(arguments.bin / "sleight"), "direct", str(request), "-o", str(archive), "-q",
               "--seed", str(seed), *WAYS[way]]
    begin = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    first = None
    while process.poll() is None:
        now = time.monotonic() - begin
        if first is None and archive.exists():
            first = now
        if now > arguments.limit:
            process.kill()
            process.communicate()
            return None
        time.sleep(0.002)
    end = time.monotonic() - begin
    if process.returncode != 0:
        sys.exit(f"{' '.join(command)} ended with {process.returncode}:\n"
                 f"{process.stderr.read().decode()}")
    return first or end, end


def statistics_of(times, limit):
    counted = [limit if taken is None else taken for taken in times]
    return {"median_s": statistics.median(counted), "least_s": min(counted), "most_s": max(counted)}


def measure(arguments, row, way):
    times = []
    with tempfile.TemporaryDirectory(prefix="sleight-answers-") as folder:
        for seed in range(1, arguments.seeds + 1):
            times.append(seconds(arguments, row, way, seed, folder))
            if times == [None]:
                break
    return {"row": row, "way": way, "seeds": len(times), "over": times.count(None),
            "first": statistics_of([taken and taken[0] for taken in times], arguments.limit),
            "end": statistics_of([taken and taken[1] for taken in times], arguments.limit)}


def in_words(result, unit_s):
    if result["over"] == result["seeds"]:
        return f"over {result['end']['median_s'] / unit_s:.0f}, {result['seeds']} seeds"

    def shown(times):
        median, least, most = (times[key] / unit_s for key in ("median_s", "least_s", "most_s"))
        return f"{median:.2g} ({least:.2g}, {most:.2g})"

    text = f"{shown(result['first'])}; {shown(result['end'])}"
    return text + (f", {result['over']} over" if result["over"] else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    parser.add_argument("--only", metavar="ROW", nargs="+", default=WORDS + DICE)
    parser.add_argument("--ways", choices=list(WAYS), nargs="+", default=["found", "relaxed"])
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--limit", type=float, default=120, help="seconds of one run")
    parser.add_argument("--yardstick", type=float, default=1, help="seconds that count as one")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()

    results = []
    for row in arguments.only:
        for way in arguments.ways:
            results.append(measure(arguments, row, way))
            print(f"{row}, {way}: {in_words(results[-1], arguments.yardstick)}", file=sys.stderr)
    if arguments.json:
        print(json.dumps(results))
        return
    titles = [f"{'' if way in STOP else 'five '}{way}: first archive; end" for way in arguments.ways]
    print(f"| request | {' | '.join(titles)} |")
    print("|---" * (1 + len(arguments.ways)) + "|")
    for row in arguments.only:
        cells = [in_words(result, arguments.yardstick) for result in results if result["row"] == row]
        print(f"| {row} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
