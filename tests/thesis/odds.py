#!/usr/bin/python3
"""Checks that islands, tempering and blind throws give the same estimates of log P(satisfied).

  tests/thesis/odds.py --bin build/release/bin                      ten words, and two to four dice
  tests/thesis/odds.py --bin ... --only I T dice2 --limit 60 --throws 100000

Islands run with `odds = 0.1`, and tempering (for words, from searches) runs in rounds. A run that takes
longer than --limit seconds is stopped, and its estimate so far counts. --throws makes blind throws of words
(sleight-proportions). If the program prints an estimate without an interval, the table shows the reason and
compares nothing. Exits with 1 if two estimates differ by more than three combined errors.
"""

import argparse
import itertools
import json
import math
import pathlib
import subprocess
import sys
import tempfile

WORDS = ["I", "T", "L", "IT", "LO", "HI", "ILL", "LIT", "TIL", "LILI"]
DICE = {"dice2": 2, "dice3": 3, "dice4": 4}
PROPOSALS = """change_all = 0.01
change_vertices = 0.25
change_ball = 0.14
disable_balls = 0.02
enable_balls = 0.02
aim_ball = 0.28
scatter_ball = 0.28
vertex_redraw = 1.0
ball_move_sd_mm = 2.0
"""
TEMPERING = {
    "words": '[constraint]\nlog_lambda = 4\n[sampler]\nmethod = "parallel_tempering"\n'
             f'start = "search"\nchains = 4\niterations_per_scan = 20\nround_scans = 100\n{PROPOSALS}',
    "dice": '[sampler]\nmethod = "parallel_tempering"\nchains = 4\niterations_per_scan = 5\n'
            "round_scans = 100\n",
}


def world(row):
    if row not in DICE:
        return f'[world]\nname = "spelling"\nword = "{row}"\n'
    dice = range(DICE[row])
    starts = "".join(f"[[world.die]]\ny_mm = {-100 + 40 * die}\ny_sd_mm = 2\n" for die in dice)
    places = "".join(f"[[constraint.place]]\ndie = {die + 1}\nx_mm = 30\ny_mm = {-150 + 60 * die}\n"
                     "sigma_mm = 20\ntolerance_mm = 40\n" for die in dice)
    return f'[world]\nname = "dice"\n{starts}{places}'


def directed(arguments, name, text, folder):
    """log P of a throw and its error. None and the reason if there is no interval."""
    request = pathlib.Path(folder) / f"{name}.toml"
    request.write_text(text)
    archive = request.with_suffix(".h5")
    sleight = str(arguments.bin / "sleight")
    subprocess.run([sleight, "direct", str(request), "-o", str(archive), "-q", "--time-limit",
                    f"{arguments.limit}s"], check=True, capture_output=True)
    if not archive.exists():
        return None, "no archive"
    info = json.loads(subprocess.run([sleight, "archive", "info", str(archive), "--json"],
                                     check=True, capture_output=True).stdout)
    odds = info.get("tempering")
    if not odds:
        return None, "no odds"
    value, error = odds["log_p_throw"]["value"], odds["log_p_throw"]["error"]
    if not odds["known"]:
        doubts = odds["log_p_throw"]["doubts"]
        return None, f"{value:.2f} without interval: {doubts[0] if doubts else 'not known'}"
    return (value, error), ""


def thrown(arguments, row):
    if row in DICE or arguments.throws == 0:
        return None, ""
    output = subprocess.run([str(arguments.bin / "sleight-proportions"), "--word", row, "--throws",
                             str(arguments.throws)], check=True, capture_output=True, text=True).stdout
    satisfied = int(output.split()[0])
    if satisfied < 20:
        return None, f"{satisfied} of {arguments.throws} throws"
    return (math.log(satisfied / arguments.throws), 1 / math.sqrt(satisfied)), ""


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    parser.add_argument("--only", choices=WORDS + list(DICE), nargs="+", default=WORDS + list(DICE))
    parser.add_argument("--limit", type=int, default=300, help="seconds of one run")
    parser.add_argument("--throws", type=int, default=0)
    arguments = parser.parse_args()

    worst = 0.0
    print("| | islands | tempering | blind throws | apart, in combined errors |\n|---|---|---|---|--:|")
    for row in arguments.only:
        with tempfile.TemporaryDirectory(prefix="sleight-odds-") as folder:
            tempering = TEMPERING["dice" if row in DICE else "words"]
            found = [directed(arguments, "islands", world(row) + "[stop]\nodds = 0.1\n", folder),
                     directed(arguments, "tempering", f"{world(row)}{tempering}[stop]\nrounds = 8\n",
                              folder),
                     thrown(arguments, row)]
        known = [estimate for estimate, _ in found if estimate]
        apart = [abs(a[0] - b[0]) / math.hypot(a[1], b[1])
                 for a, b in itertools.combinations(known, 2)]
        worst = max([worst, *apart])
        cells = [f"{estimate[0]:.2f} +- {estimate[1]:.2f}" if estimate else why
                 for estimate, why in found]
        print(f"| {row} | {' | '.join(cells)} | {max(apart):.1f} |" if apart else
              f"| {row} | {' | '.join(cells)} | - |", flush=True)
    sys.exit(1 if worst > 3 else 0)


if __name__ == "__main__":
    main()
