#!/usr/bin/python3
"""Measures how much faster two ranks are than one, and what data the ranks exchange.

  tests/bench/ranks.py --bin build/release/bin                 three runs of each, in turn
  tests/bench/ranks.py --bin ... --ranks 1 2 4 --repeats 5 --request requests/hi_tempered.toml
  tests/bench/ranks.py --bin ... --unrelated                   also as many runs of one rank

Each run directs the same request from beginning to end with `mpirun -n N sleight-batch`. All digests
must be equal. Times exclude the start of processes (about half a second). A speed-up is the ratio of
median simulations per second to the median for the first number of ranks. With --unrelated, N
independent runs of one rank run at once after each run of N ranks. They show the speed of the cores
without messages. Prints a table. With --json, prints the same for programs.
"""

import argparse
import concurrent.futures
import contextlib
import itertools
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile

MPIRUN = ["mpirun", "--oversubscribe", "--bind-to", "none", "--mca", "plm", "isolated",
          "--mca", "btl", "self,vader", "--mca", "oob_tcp_if_include", "lo"]


def run(arguments, ranks, folder):
    own = ["--mca", "orte_tmpdir_base", folder, "--mca", "btl_vader_backing_directory", folder]
    command = [*MPIRUN, *own, "-n", str(ranks), str(arguments.bin / "sleight-batch"),
               str(arguments.request), "-o", f"{folder}/a.h5", "--fresh", "--json", "-q"]
    environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1",
                   "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    result = subprocess.run(command, capture_output=True, text=True, env=environment)
    if result.returncode != 0:
        sys.exit(f"mpirun -n {ranks} ended with {result.returncode}:\n{result.stderr}")
    return json.loads(result.stdout)


def rate(summary):
    return summary["session_simulations"] / summary["session_seconds"]


def run_unrelated(arguments, count):
    """Runs `count` runs of one rank at once."""
    with contextlib.ExitStack() as folders, concurrent.futures.ThreadPoolExecutor(count) as pool:
        own = [folders.enter_context(tempfile.TemporaryDirectory(prefix="sleight-ranks-"))
               for _ in range(count)]
        return list(pool.map(lambda folder: run(arguments, 1, folder), own))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    parser.add_argument("--request", type=pathlib.Path,
                        default=pathlib.Path(__file__).parents[2] / "requests/hi_tempered.toml")
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--unrelated", action="store_true")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()

    runs = {ranks: [] for ranks in arguments.ranks}
    unrelated = {ranks: [] for ranks in arguments.ranks}
    with tempfile.TemporaryDirectory(prefix="sleight-ranks-") as folder:
        for _ in range(arguments.repeats):
            for ranks in arguments.ranks:
                runs[ranks].append(run(arguments, ranks, folder))
                if arguments.unrelated and ranks > 1:
                    unrelated[ranks].append(run_unrelated(arguments, ranks))
    beside = [summary for of_ranks in unrelated.values() for at_once in of_ranks for summary in at_once]
    digests = {summary["digest"] for summary in itertools.chain(*runs.values(), beside)}
    if len(digests) != 1:
        sys.exit(f"digests differ: {digests}")

    rows = []
    for ranks, all_runs in runs.items():
        rates = [rate(r) for r in all_runs]
        last = all_runs[-1]
        handling = last["handling"]
        simulations = last["session_simulations"]
        held = handling["states_held"]
        rows.append({
            "ranks": ranks,
            "simulations": simulations,
            "seconds": statistics.median(r["session_seconds"] for r in all_runs),
            "simulations_per_s": statistics.median(rates),
            "simulations_per_s_least": min(rates),
            "simulations_per_s_most": max(rates),
            "speed_up": statistics.median(rates),
            "messages_per_simulation": handling["messages"] / simulations,
            "bytes_per_simulation": handling["message_bytes"] / simulations,
            "states_held": held / max(1, held + handling["states_sent"]),
        })
    for row in rows[::-1]:
        row["speed_up"] /= rows[0]["speed_up"]
        sums = [sum(map(rate, at_once)) for at_once in unrelated[row["ranks"]]]
        if sums:
            row |= {"unrelated_simulations_per_s": statistics.median(sums),
                    "unrelated_simulations_per_s_least": min(sums),
                    "unrelated_simulations_per_s_most": max(sums)}
    if arguments.json:
        print(json.dumps({"request": arguments.request.name, "digest": digests.pop(),
                          "rows": rows}, indent=2))
        return
    print(f"{arguments.request.name}, {rows[0]['simulations']} simulations, median of "
          f"{arguments.repeats} runs each, digests equal")
    print("ranks  seconds  simulations/s (least to most)  speed-up  messages/sim.  bytes/sim.  "
          "states held")
    for row in rows:
        print(f"{row['ranks']:5}  {row['seconds']:7.1f}  {row['simulations_per_s']:8.0f} "
              f"({row['simulations_per_s_least']:.0f} to {row['simulations_per_s_most']:.0f})"
              f"{'':8}{row['speed_up']:9.2f}  {row['messages_per_simulation']:13.3f}  "
              f"{row['bytes_per_simulation']:10.0f}  {100 * row['states_held']:10.0f}%")
    for row in rows:
        if "unrelated_simulations_per_s" not in row:
            continue
        together = row["unrelated_simulations_per_s"]
        print(f"{row['ranks']} unrelated runs beside each other: {together:.0f} simulations/s "
              f"({row['unrelated_simulations_per_s_least']:.0f} to "
              f"{row['unrelated_simulations_per_s_most']:.0f}); {row['ranks']} ranks reach "
              f"{row['simulations_per_s'] / together:.3f} of that")


if __name__ == "__main__":
    main()
