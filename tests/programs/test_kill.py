"""Goal: kill -9 of any process at any moment loses nothing that was reported, and the resumed run has the
same digest. It leaves no process and no shared memory. Method: kill a run of at least 6 seconds of work
(--seconds) at random moments, and start it again by the same command until it is done. Then kill each of
several short runs once while it starts. The moments come from a printed seed. In an MPI job, kill mpirun,
rank 0 and another rank in turn."""

import os
import pathlib
import random
import re
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import time

import harness
from harness import abandoned_memory, ProgramTest

CHAINS = 3
ITERATIONS_PER_SCAN = 200


class Kill(ProgramTest):
    def scans_for(self, seconds):
        """Number of scans that take so long here, measured by a short run."""
        probe = self.write_request("probe.toml", chains=CHAINS, scans=100000000,
                                   iterations_per_scan=ITERATIONS_PER_SCAN, thin=50)
        probe_s = min(3, harness.arguments.seconds)
        self.direct(probe, self.path("probe.h5"), "--time-limit", f"{probe_s}s")
        return int(self.info(self.path("probe.h5"))["scans"] / probe_s * seconds)

    def reported(self, errors):
        """Last number of completed scans in a dead run's progress lines."""
        found = re.findall(r"^ball_2d  ([\d,]+) of", errors, re.MULTILINE)
        return int(found[-1].replace(",", "")) if found else 0

    def stored(self, output):
        """Number of scans in a dead run's store, which has no tables if the run was killed before its first
        commit. Looks at a copy, because opening the store repairs it."""
        with tempfile.TemporaryDirectory(prefix="sleight-test-") as folder:
            copy = pathlib.Path(folder) / "run"
            shutil.copytree(f"{output}.run", copy)
            store = sqlite3.connect(copy / "store.sqlite")
            count = 0
            if store.execute("SELECT 1 FROM sqlite_master WHERE name='scan'").fetchone():
                count, = store.execute("SELECT count(*) FROM scan").fetchone()
            store.close()
        return count

    def victim(self, process, which):
        """The process to kill: mpirun or `sleight`, or a rank of the job by its number."""
        if which is None:
            return process.pid
        for child in subprocess.run(["pgrep", "-P", str(process.pid), "sleight-batch"],
                                    capture_output=True, text=True).stdout.split():
            environment = pathlib.Path(f"/proc/{child}/environ").read_bytes().split(b"\0")
            if f"OMPI_COMM_WORLD_RANK={which}".encode() in environment:
                return int(child)
        return process.pid  # not started yet

    def run_with_kills(self, command, output, moments, total_s, victims):
        """Runs to the end, killing when the computing time passes each moment. Returns the number of kills
        that hit a running program, and the computing time in seconds."""
        spent = 0.0
        kills = 0
        for moment in [*moments, None]:
            process = harness.start(command)
            begin = time.monotonic()
            try:
                wait = None if moment is None else max(0.02, moment * total_s - spent)
                _, errors = process.communicate(timeout=wait)
                self.assertEqual(process.returncode, 0, errors)
                spent += time.monotonic() - begin
                break
            except subprocess.TimeoutExpired:
                hit = self.kill(process, victims[kills % len(victims)], output)
                spent += time.monotonic() - begin
                if not hit:
                    break
                kills += 1
        return kills, spent

    def kill(self, process, which, output):
        """Kills the run and examines what it leaves. False if it had ended by itself just before."""
        try:
            os.kill(self.victim(process, which), signal.SIGKILL)
        except (ProcessLookupError, FileNotFoundError):
            pass  # it ended just now
        errors = harness.await_job_without_a_rank(process)
        harness.kill_group(process)
        if process.returncode == 0:
            self.assertTrue(output.exists(), "it ended well, without its archive")
        if (self.folder / f"{output.name}.run/store.sqlite").exists():
            self.assertGreaterEqual(self.stored(output), self.reported(errors))
        return process.returncode != 0

    def check_nothing_left(self, output):
        leftover = subprocess.run(["pgrep", "-f", str(output)], capture_output=True, text=True)
        self.assertEqual(leftover.stdout, "", "processes left behind")
        self.assertEqual(abandoned_memory(), [], "shared memory left behind")

    def check(self, commands_of):
        seed = harness.arguments.seed
        print(f"\nmoments from --seed {seed}, --kills {harness.arguments.kills}")
        scans = self.scans_for(1.3 * harness.arguments.seconds)
        whole_s = 0.0
        while whole_s < harness.arguments.seconds:
            request = self.write_request(chains=CHAINS, scans=scans,
                                         iterations_per_scan=ITERATIONS_PER_SCAN, thin=50)
            begin = time.monotonic()
            self.direct(request, self.path("whole.h5"), "--fresh")
            whole_s = time.monotonic() - begin
            # The machine is faster than during the probe: request more scans.
            scans = int(scans * 1.3 * harness.arguments.seconds / whole_s)
        digest = self.digest(self.path("whole.h5"))
        for name, command_of, share, victims in commands_of:
            if harness.arguments.only not in (None, name):
                continue
            kills_left = max(1, int(harness.arguments.kills * share))
            generator = random.Random(f"{seed} {name}")
            # One run takes all kills, unless the machine is faster now and the run ended before the last.
            while kills_left > 0:
                moments = sorted(0.9 * generator.random() for _ in range(kills_left))
                output = self.path(f"{name}{kills_left}.h5")
                kills, spent = self.run_with_kills(command_of(request, output), output, moments,
                                                   whole_s, victims)
                print(f"{name}: {kills} kills in {spent:.0f} s of work, whole run {whole_s:.0f} s")
                self.assertGreater(kills, 0)
                kills_left -= kills
                self.assertEqual(self.digest(output), digest, name)
                self.same_events(output, self.path("whole.h5"))
                self.check_nothing_left(output)

    def ways(self):
        """Name, command for a request and an output, share of the kills, and whom to kill in turns."""
        direct = harness.program("sleight")
        return [
            ("direct", lambda request, output: [direct, "direct", request, "-o", output], 1.0,
             [None]),
            ("batch", lambda request, output: harness.batch(3, request, output,
                                                            files=self.folder), 0.45,
             [None, 0, 2]),
        ]

    def test_killed_and_resumed(self):
        self.check(self.ways())

    def test_killed_while_it_starts(self):
        """Each kill hits a new run before its first results or soon after, while its folder, store and tables
        appear one after the other. `sleight direct` finishes all runs."""
        request = self.write_request(chains=CHAINS, scans=1000,
                                     iterations_per_scan=ITERATIONS_PER_SCAN, thin=50)
        self.direct(request, self.path("whole.h5"))
        digest = self.digest(self.path("whole.h5"))
        seed = harness.arguments.seed
        print(f"\nmoments from --seed {seed}")
        for name, command_of, share, victims in self.ways():
            if harness.arguments.only not in (None, name):
                continue
            generator = random.Random(f"{seed} start {name}")
            store_s = self.seconds_to_a_store(command_of(request, self.path(f"{name}.h5")))
            hits = 0
            without_a_scan = 0
            for turn in range(max(1, int(harness.arguments.kills * share))):
                output = self.path(f"{name}{turn}.h5")
                process = harness.start(command_of(request, output))
                try:
                    _, errors = process.communicate(timeout=2 * store_s * generator.random())
                    self.assertEqual(process.returncode, 0, errors)
                except subprocess.TimeoutExpired:
                    hit = self.kill(process, victims[turn % len(victims)], output)
                    hits += hit
                    if hit and (self.folder / f"{output.name}.run/store.sqlite").exists():
                        without_a_scan += self.stored(output) == 0
                self.direct(request, output)
                self.assertEqual(self.digest(output), digest, f"{name} {turn}")
                self.same_events(output, self.path("whole.h5"))
                self.check_nothing_left(output)
            print(f"{name}: a store after {store_s:.3f} s; {hits} kills hit, "
                  f"{without_a_scan} of them left a store without a scan")
            self.assertGreater(hits, 0)

    def seconds_to_a_store(self, command):
        """Time that a run takes here until it begins its store."""
        process = harness.start(command)
        begin = time.monotonic()
        store = pathlib.Path(f"{command[command.index('-o') + 1]}.run/store.sqlite")
        while not store.exists() and process.poll() is None:
            time.sleep(0.001)
        taken = time.monotonic() - begin
        _, errors = process.communicate()
        self.assertEqual(process.returncode, 0, errors)
        return taken


if __name__ == "__main__":
    harness.main()
