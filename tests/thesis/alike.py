#!/usr/bin/python3
"""Do the chain's own falls, or lineages, mark visually distinct sets of animations (thesis 2.5)?

Divides the kept animations of HI into groups that look alike (`sleight groups`), as many as there are sets
between falls or of lineages. Prints how far the two divisions agree, as the adjusted Rand index: 1 for equal
divisions, and 0 on average for independent divisions.

    tests/thesis/alike.py --bin build/release/bin --source .

There is a fall between two kept animations of a chain if, in between, the number of balls in their bins was
sufficiently far below the maximum (figure 2.8). For comparison, prints the greatest index of 199 shuffles of
the labels."""

import argparse
import json
import pathlib
import random
import subprocess
import tempfile
from collections import Counter

import h5py

SHUFFLES = 199


def pairs(counts):
    return sum(count * (count - 1) / 2 for count in counts)


def adjusted_rand_index(a, b):
    """L. Hubert and P. Arabie, Journal of Classification 2, 1985, equation 5."""
    together = pairs(Counter(zip(a, b)).values())
    of_a, of_b, of_all = pairs(Counter(a).values()), pairs(Counter(b).values()), pairs([len(a)])
    expected = of_a * of_b / of_all
    most = (of_a + of_b) / 2
    return 1.0 if most == expected else (together - expected) / (most - expected)


def falls(archive, chains, draws, by):
    """For each kept animation, its chain and the number of falls before it."""
    filled = archive["sample_stats/filled"][:]
    whole = filled.max()
    labels, count = [], 0
    for i, (chain, draw) in enumerate(zip(chains, draws)):
        if i > 0 and chain == chains[i - 1] and filled[chain, draws[i - 1]:draw].min() <= whole - by:
            count += 1
        labels.append((chain, count))
    return labels


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bin", required=True)
    parser.add_argument("--source", required=True)
    arguments = parser.parse_args()
    program = str(pathlib.Path(arguments.bin) / "sleight")
    requests = pathlib.Path(arguments.source) / "requests"
    keep = ["output.thin=1", "output.keep_per_lineage=1000", "output.min_distance=0.01"]
    runs = {"hi": (requests / "hi.toml", ["sampler.chains=8", "stop.scans=12001", *keep]),
            "hi_tempered": (requests / "hi_tempered.toml", ["output.keep_per_lineage=20",
                                                            "output.min_distance=0.01"])}
    generator = random.Random(2000)
    print("| run | divided by | animations | sets | medoids | hierarchy | shuffled, at most |")
    print("|---|---|--:|--:|--:|--:|--:|")
    with tempfile.TemporaryDirectory() as folder:
        for name, (request, keys) in runs.items():
            path = f"{folder}/{name}.h5"
            settings = [part for key in keys for part in ("--set", key)]
            subprocess.run([program, "direct", request, "-o", path, "-q", *settings], check=True,
                           stdout=subprocess.DEVNULL)
            with h5py.File(path) as archive:
                kept = archive["animations"]
                chains, draws = kept["chain"][:].tolist(), kept["draw"][:].tolist()
                ways = {"lineages": list(zip(chains, kept["lineage"][:].tolist()))}
                if name == "hi":
                    ways["chains"] = chains
                    for by in [2, 3, 4, 5, 6]:
                        ways[f"falls by {by} or more"] = falls(archive, chains, draws, by)
            ids = [f"c{chain}.{draw}" for chain, draw in zip(chains, draws)]
            for way, labels in ways.items():
                sets = len(set(labels))
                indices, shuffled = [], []
                for by in ["medoids", "hierarchy"]:
                    told = subprocess.run([program, "groups", path, "-k", str(sets), "--by", by, "--json"],
                                          check=True, capture_output=True, text=True).stdout
                    group_of = {member: i for i, group in enumerate(json.loads(told)["groups"])
                                for member in group["members"]}
                    groups = [group_of[one] for one in ids]
                    indices.append(adjusted_rand_index(labels, groups))
                    for _ in range(SHUFFLES):
                        mixed = labels[:]
                        generator.shuffle(mixed)
                        shuffled.append(adjusted_rand_index(mixed, groups))
                print(f"| {name} | {way} | {len(ids)} | {sets} | {indices[0]:.2f} | {indices[1]:.2f} "
                      f"| {max(shuffled):.2f} |", flush=True)


if __name__ == "__main__":
    main()
