"""Goal: whatever is killed, full or replaced, every submitted job ends once, with the digest of an
undisturbed run, and a watcher gets every numbered event once. Method: use real processes. Kill each kind of
process with kill -9 at random moments (printed seed; --kills of each kind, 100 in deploy/soak). Use a disk of
20 MB, replace programs while jobs run, and set back a clock."""

import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import time
import unittest

import harness
from service_harness import ServiceTest, processes_of

KINDS = ["daemon", "keeper", "client", "mpirun", "rank 0", "rank"]


def numbered(lines):
    """Numbers of a watch's events, in order of arrival."""
    events = map(json.loads, lines)
    return [event["number"] for event in events if event["kind"] != "state" and event["number"] > 0]


class Faults(ServiceTest):
    def watch(self, number, first=1):
        return subprocess.Popen(
            [harness.program("sleight"), "watch", str(number), "--json", "--from", str(first)],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
            env={**harness.environment(), **self.environment()})

    def victim(self, kind, number):
        """Process to kill. None if there is none just now."""
        if kind == "keeper":
            return self.keeper(number)
        programs = {"mpirun": "mpirun", "rank 0": "sleight-batch", "rank": "sleight-batch"}
        found = sorted(pid for pid, name in processes_of(self.folder_of(number))
                       if name == programs[kind])
        if not found:
            return None
        return found[-1] if kind == "rank" else found[0]

    def strike(self, kind, number, watcher, seen):
        """Kills a process of the kind. Returns the watcher, which may be a new one that continues, and what
        the first one saw."""
        if kind == "daemon":
            self.kill_daemon()
            self.serve()
        elif kind == "client":
            watcher.kill()
            lines = watcher.communicate()[0].splitlines()
            # A line that was being written is incomplete.
            whole = [line for line in lines if line.startswith("{") and line.endswith("}")]
            last = max(numbered(seen + whole), default=0)
            return self.watch(number, last + 1), whole
        else:
            try:
                pid = self.victim(kind, number)
                if pid:
                    os.kill(pid, signal.SIGKILL)
                    self.hits += 1
            except (OSError, ValueError, KeyError):
                pass
        return watcher, []

    def test_kills(self):
        seed, kills = harness.arguments.seed, harness.arguments.kills
        chance = random.Random(seed)
        kills_of = {kind: max(2, kills // 4) for kind in KINDS}
        print(f"seed {seed}, kills of each kind {kills_of}")
        self.hits = 0
        self.serve()
        work = {"chains": 2, "scans": 6000, "iterations_per_scan": 250}
        request = self.write_request(**work)
        expected = self.quiet_digest(request)
        for with_ranks, kinds in [(False, KINDS[:3]), (True, KINDS[3:])]:
            left = [kind for kind in kinds for _ in range(kills_of[kind])]
            chance.shuffle(left)
            while left:
                options = ["--ranks", 2] if with_ranks else []
                number = self.submit(request, *options)
                watcher, seen = self.watch(number), []
                for kind in left[:2]:
                    self.until(lambda: self.job(number)["state"] == "running"
                               or self.job(number)["state"] == "done")
                    time.sleep(chance.uniform(0, 0.6))
                    watcher, more = self.strike(kind, number, watcher, seen)
                    seen += more
                left = left[2:]
                self.wait(number)
                job = self.job(number)
                self.assertEqual((job["state"], job["digest"]), ("done", expected))
                seen += watcher.communicate(timeout=60)[0].splitlines()
                numbers = numbered(seen)
                self.assertEqual(numbers, list(range(1, len(numbers) + 1)))
                history = self.ask_json("status", number, "--history")["history"]
                self.assertEqual([c["state"] for c in history].count("done"), 1)
                self.assertEqual(processes_of(self.folder_of(number)), [])
        print(f"{self.hits} of {sum(kills_of.values()) - kills_of['daemon'] - kills_of['client']} kills of "
              "keepers, mpiruns and ranks hit one")
        self.assertGreater(self.hits, 0)
        self.assertEqual(harness.abandoned_memory(), [])  # other tests' jobs may have some in use

    @unittest.skipUnless(os.geteuid() == 0, "mounting a small disk takes root")
    def test_a_disk_that_is_full_and_freed(self):
        self.state.mkdir()
        self.succeed(harness.run(["mount", "-t", "tmpfs", "-o", "size=20m", "tmpfs", self.state]))
        self.addCleanup(lambda: (self.end_everything(), time.sleep(0.3),
                                 harness.run(["umount", "-l", self.state])))
        request = self.write_request(chains=2, scans=40_000, iterations_per_scan=1)
        expected = self.quiet_digest(request)
        filler = self.state / "filler"
        filler.write_bytes(bytes(17_500_000))
        self.serve("--disk-reserve", "0B")
        number = self.submit(request)
        # Both values come from one answer, because the daemon may retry as soon as a few bytes are free.
        def is_held_by_the_disk():
            job = self.job(number)
            return job["state"] == "held" and "disk" in job["reason"].lower()
        self.until(is_held_by_the_disk, 90)
        # The daemon loses nothing that it has answered.
        self.kill_daemon()
        filler.unlink()
        self.serve("--disk-reserve", "0B")
        self.until(lambda: self.job(number)["state"] == "done", 120)
        self.assertEqual(self.job(number)["digest"], expected)

    def test_a_reserve_holds_and_lets_go(self):
        self.serve("--disk-reserve", "8000TB")
        number = self.submit(self.write_request(chains=1, scans=300))
        self.until(lambda: "disk" in self.job(number)["not_yet"].lower())
        self.assertEqual(self.job(number)["starts"], 0)
        self.kill_daemon(signal.SIGTERM)
        self.serve()
        self.wait(number)

    def test_programs_that_are_replaced(self):
        own = self.path("bin")
        own.mkdir()
        for name in ["sleight", "sleightd", "sleight-keeper", "sleight-batch", "sleight-reader"]:
            shutil.copy(harness.program(name), own / name)
        real, harness.arguments.bin = harness.arguments.bin, str(own)
        self.addCleanup(setattr, harness.arguments, "bin", real)
        self.serve()
        request = self.write_request(chains=2, scans=8000, iterations_per_scan=600)
        number = self.submit(request)
        self.until_running(number)
        # A later build with the same results resumes the run.
        self.replace(own / "sleight", lambda path: shutil.copy(pathlib.Path(real) / "sleight", path))
        first = self.kill_keeper(number)
        self.until(lambda: self.job(number)["starts"] >= 2)
        self.until_running(number)

        # A build with other results must not: the job is held until the old one is back.
        def other(path):
            path.write_text(f"""#!/bin/sh
[ "$1" = --version ] && printf 'sleight 9\\nresults 0000000000000000\\n' && exit 0
exec {real}/sleight "$@"
""")
            path.chmod(0o755)
        self.replace(own / "sleight", other)
        self.kill_keeper(number, after=first)
        harness.arguments.bin = real
        self.until(lambda: self.job(number)["state"] == "held")
        self.assertIn("results", self.job(number)["reason"])
        self.replace(own / "sleight", lambda path: shutil.copy(pathlib.Path(real) / "sleight", path))
        self.wait(number)
        self.assertEqual(self.job(number)["digest"], self.quiet_digest(request))

    def kill_keeper(self, number, after=None):
        """Kills the keeper of the job's attempt, and waits for it if `after` was killed before."""
        def comes():
            try:
                return self.keeper(number) != after
            except (OSError, ValueError, KeyError):
                return False
        self.until(comes)
        pid = self.keeper(number)
        os.kill(pid, signal.SIGKILL)
        return pid

    def replace(self, path, make):
        beside = path.with_name(path.name + ".new")
        make(beside)
        beside.rename(path)

    @unittest.skipUnless(shutil.which("faketime"), "needs faketime")
    def test_a_clock_that_is_set_back(self):
        self.serve()
        request = self.write_request(chains=2, scans=6000, iterations_per_scan=400)
        number = self.submit(request)
        later = self.submit(self.write_request("later.toml", chains=1, scans=300))
        self.until_running(number)
        self.kill_daemon()
        self.serve(wrapper=["faketime", "-f", "-1d"])
        self.wait(number)
        self.wait(later)
        self.assertEqual(self.job(number)["starts"], 1)
        self.assertEqual(self.job(number)["digest"], self.quiet_digest(request))
        self.assertEqual(self.job(number)["deleted_at"], None)


if __name__ == "__main__":
    harness.main()
