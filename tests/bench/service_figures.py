"""Measures the service for docs/MEASUREMENTS.md: calls per second with many jobs, the resources of an idle
daemon, the time until a submitted job commits, the latency of its events for 100 watchers, and the cost of
a job compared with the same run by hand.

    tests/bench/service_figures.py --bin build/release/bin [--jobs 10000] [--pairs 15]
"""

import argparse
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import tempfile
import time

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
parser.add_argument("--bin", type=pathlib.Path, required=True)
parser.add_argument("--jobs", type=int, default=10_000)
parser.add_argument("--seconds", type=float, default=5)
parser.add_argument("--pairs", type=int, default=15)
parser.add_argument("--only-cost", action="store_true", help="the last one alone")
arguments = parser.parse_args()

REQUEST = """
[world]
name = "ball_2d"
[sampler]
method = "metropolis_hastings"
chains = 2
seed = {seed}
iterations_per_scan = 40
[stop]
scans = {scans}
"""

# About fifty events a second.
WATCHED = """
[world]
name = "ball_2d"
[sampler]
method = "parallel_tempering"
chains = 2
seed = 1
iterations_per_scan = 400
[stop]
independent_solutions = 500
"""


class Daemon:
    def __init__(self, *options):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="sleight-figures-"))
        self.environment = {**os.environ, "SLEIGHT_ALLOW_ROOT": "1", "SLEIGHT_STATE": str(self.folder / "state"),
                            "XDG_CONFIG_HOME": str(self.folder), "OMPI_ALLOW_RUN_AS_ROOT": "1",
                            "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
        self.process = subprocess.Popen([arguments.bin / "sleightd", *options], env=self.environment,
                                        stderr=subprocess.DEVNULL)
        while self.ask("server", "status", check=False).returncode != 0:
            time.sleep(0.05)

    def ask(self, *args, check=True):
        return subprocess.run([arguments.bin / "sleight", *map(str, args)], env=self.environment,
                              capture_output=True, text=True, check=check)

    def processor_s(self):
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def resident_mb(self):
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return int(status.partition("VmRSS:")[2].split()[0]) / 1024

    def end(self):
        self.process.terminate()
        self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


def write_request(folder, seed, scans):
    path = folder / f"request-{seed}-{scans}.toml"
    path.write_text(REQUEST.format(seed=seed, scans=scans))
    return path


def many_jobs():
    # No job starts below the reserve, so that only calls are measured.
    daemon = Daemon("--disk-reserve", "8000TB")
    subprocess.run([arguments.bin / "sleight-service-bench", daemon.folder / "state/socket",
                    str(arguments.jobs), str(arguments.seconds)], check=True)
    time.sleep(1)
    before, begin = daemon.processor_s(), time.monotonic()
    time.sleep(10)
    share = (daemon.processor_s() - before) / (time.monotonic() - begin)
    print(f"idle: {daemon.resident_mb():.0f} MB, {100 * share:.2f}% of a core")
    daemon.end()


def first_commits():
    daemon = Daemon()
    for name, options in [("submit to first commit", []), ("with mpirun", ["--ranks", "2"])]:
        times = []
        for seed in range(1, 6):
            request = write_request(daemon.folder, seed, 3000)
            begin = time.monotonic()
            number = json.loads(daemon.ask("submit", request, "--json", *options).stdout)["id"]
            log = daemon.folder / f"state/jobs/{number}/out.h5.run/store.sqlite"
            while not (log.exists() and committed(log)):
                time.sleep(0.01)
            times.append(time.monotonic() - begin)
            daemon.ask("wait", number)
        print(f"{name}: median {statistics.median(times):.2f} s, longest {max(times):.2f} s")
    daemon.end()


def watched():
    daemon = Daemon("--cores", "1")
    request = daemon.folder / "watched.toml"
    request.write_text(WATCHED)
    number = json.loads(daemon.ask("submit", request, "--json").stdout)["id"]
    log = daemon.folder / f"state/jobs/{number}/out.h5.run/events.log"
    while not log.exists():
        time.sleep(0.01)
    subprocess.run([arguments.bin / "sleight-watch-bench", daemon.folder / "state/socket", str(number), log],
                   check=True)
    daemon.end()


def committed(store):
    import sqlite3
    try:
        with sqlite3.connect(f"file:{store}?mode=ro", uri=True) as database:
            return database.execute("SELECT 1 FROM scan LIMIT 1").fetchone() is not None
    except sqlite3.Error:
        return False


def cost():
    """Compares a job with the same command by hand, alternating which comes first: processor time of all
    processes, daemon included."""
    daemon = Daemon("--cores", "1")

    def by_hand(request, seed):
        before = os.times()
        subprocess.run([arguments.bin / "sleight", "direct", request, "-o",
                        daemon.folder / f"{seed}.h5", "-q", "-j", "1"], check=True,
                       env=daemon.environment, stdout=subprocess.DEVNULL)
        after = os.times()
        return (after.children_user + after.children_system
                - before.children_user - before.children_system)

    def as_job(request, _):
        before = daemon.processor_s()
        number = json.loads(daemon.ask("submit", request, "--json").stdout)["id"]
        daemon.ask("wait", number)
        record = json.loads((daemon.folder / f"state/jobs/{number}/attempt.json").read_text())
        return record["end"]["processor_s"] + daemon.processor_s() - before

    shares = []
    for seed in range(1, arguments.pairs + 1):
        request = write_request(daemon.folder, seed, 60_000)
        ways = [by_hand, as_job] if seed % 2 else [as_job, by_hand]
        took = {way: way(request, seed) for way in ways}
        shares.append(took[as_job] / took[by_hand])
    print(f"a job's processor time beside that by hand, {arguments.pairs} pairs of about "
          f"{took[by_hand]:.1f} s: median {statistics.median(shares):.4f}, quartiles "
          f"{statistics.quantiles(shares)[0]:.4f} and {statistics.quantiles(shares)[2]:.4f}")
    daemon.end()


if not arguments.only_cost:
    many_jobs()
    first_commits()
    watched()
cost()
