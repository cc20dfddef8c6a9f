"""Goal: an MPI job ends in order when requested, its idle ranks use no processor time, and unusable ranks
report why. Method: run real jobs under mpirun and send them the signals of batch systems. The kernel counts
the processor time of idle ranks."""

import json
import os
import pathlib
import signal
import sqlite3
import subprocess
import time
import unittest

import harness
from harness import ProgramTest

TICKS_PER_S = os.sysconf("SC_CLK_TCK")


class Batch(ProgramTest):
    def start_batch(self, ranks, request, output, *args):
        process = harness.start(harness.batch(ranks, request, output, *args, folder=self.folder))
        self.addCleanup(harness.kill_group, process)
        return process

    def ranks_of(self, process):
        """Process ids of a job's ranks by number, once all have started."""
        children = subprocess.run(["pgrep", "-P", str(process.pid), "sleight-batch"],
                                  capture_output=True, text=True).stdout.split()
        ranks = {}
        for child in children:
            try:
                environment = pathlib.Path(f"/proc/{child}/environ").read_bytes().split(b"\0")
            except (FileNotFoundError, ProcessLookupError):
                continue
            for entry in environment:
                if entry.startswith(b"OMPI_COMM_WORLD_RANK="):
                    ranks[int(entry.split(b"=")[1])] = int(child)
        return ranks

    def wait_for_scans(self, output):
        """Waits until the run store contains some scans."""
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline:
            try:
                store = sqlite3.connect(f"file:{output}.run/store.sqlite?mode=ro", uri=True)
                count, = store.execute("SELECT count(*) FROM scan").fetchone()
                store.close()
                if count > 50:
                    return
            except sqlite3.OperationalError:
                pass
            time.sleep(0.05)
        self.fail("nothing is stored within a minute")

    def stopped_by(self, number, code):
        """A job stopped by a signal ends with its work stored, and resumes to the same result."""
        request = self.write_request(scans=2000, chains=3, iterations_per_scan=1000)
        whole = self.path("whole.h5")
        self.direct(request, whole)
        output = self.path("stopped.h5")
        process = self.start_batch(3, request, output)
        self.wait_for_scans(output)
        process.send_signal(number)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, code, errors)
        result = self.succeed(harness.run(harness.batch(2, request, output, "--json", "-q",
                                                        folder=self.folder)))
        summary = json.loads(result.stdout)
        self.assertEqual(summary["session"], 2)
        self.assertLess(summary["session_scans"], 6000)
        self.assertEqual(self.digest(output), self.digest(whole))
        return errors

    def test_a_batch_systems_warning_ends_it_in_order(self):
        # mpirun forwards SIGUSR1: rank 0 stops, stores, writes the archive and reports how it ended.
        self.stopped_by(signal.SIGUSR1, 130)

    def test_sigterm_loses_nothing(self):
        # mpirun ends its ranks about a second after it has forwarded SIGTERM, and exits with 1 or 130,
        # whichever process ended first.
        request = self.write_request(scans=2000, chains=3, iterations_per_scan=1000)
        output = self.path("terminated.h5")
        process = self.start_batch(3, request, output)
        self.wait_for_scans(output)
        process.terminate()
        process.communicate(timeout=60)
        self.assertIn(process.returncode, (1, 130, 143))
        store = sqlite3.connect(f"{output}.run/store.sqlite")
        # Draws from the prior have their own chain ids.
        stored, = store.execute("SELECT count(*) FROM scan WHERE chain < 3").fetchone()
        store.close()
        result = self.succeed(harness.run(harness.batch(2, request, output, "--json", "-q",
                                                        folder=self.folder)))
        self.assertEqual(json.loads(result.stdout)["session_scans"], 6000 - stored)
        whole = self.path("whole.h5")
        self.direct(request, whole)
        self.assertEqual(self.digest(output), self.digest(whole))

    def test_signals_to_all_ranks_at_once(self):
        # A batch system may signal every process of a job. Only rank 0 decides, and a signal that mpirun
        # forwards again doesn't count twice.
        request = self.write_request(scans=2000, chains=3, iterations_per_scan=1000)
        output = self.path("all.h5")
        process = self.start_batch(3, request, output)
        self.wait_for_scans(output)
        ranks = self.ranks_of(process)
        self.assertEqual(sorted(ranks), [0, 1, 2])
        for rank in sorted(ranks, reverse=True):
            os.kill(ranks[rank], signal.SIGUSR1)
        process.send_signal(signal.SIGUSR1)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, errors)
        self.assertTrue(output.exists())

    def test_idle_ranks_take_no_processor(self):
        # One chain keeps one rank busy. The other ranks only look for messages.
        request = self.write_request(scans=1000000, chains=1, iterations_per_scan=100000)
        process = self.start_batch(4, request, self.path("idle.h5"))
        deadline = time.monotonic() + 120
        while len(self.ranks_of(process)) < 4:
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.05)
        ranks = self.ranks_of(process).values()

        def seconds(pid):
            fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(") ", 1)[1].split()
            return (int(fields[11]) + int(fields[12])) / TICKS_PER_S

        def until_one_has_used(more_s):
            before = [seconds(pid) for pid in ranks]
            while True:
                used = sorted(seconds(pid) - at for pid, at in zip(ranks, before))
                if used[-1] >= more_s:
                    return used
                self.assertLess(time.monotonic(), deadline, used)
                time.sleep(0.05)

        until_one_has_used(2)
        begin = time.monotonic()
        used = until_one_has_used(4)
        took = time.monotonic() - begin
        process.send_signal(signal.SIGUSR1)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130)
        print("\nseconds of each rank:", used)
        self.assertLess(used[-2], 0.02 * took)

    def test_a_rank_with_another_request_is_refused(self):
        # Rank 0 sends the text; each rank applies its own options to it.
        one = self.write_request("one.toml")
        command = harness.batch(1, one, self.path("a.h5"), "--seed", "1", folder=self.folder)
        command += [":", "-n", "1", harness.program("sleight-batch"), str(one), "-o",
                    str(self.path("a.h5")), "--seed", "2"]
        result = harness.run(command)
        self.assertNotEqual(result.returncode, 0)
        self.assertRegex(result.stderr, r"\brank 1\b.*\brequest\b")

    def test_a_rank_that_makes_other_results_is_refused(self):
        # The same program with another version string, as another host may have installed.
        program = pathlib.Path(harness.program("sleight-batch"))
        version = harness.run([program, "--version"]).stdout.split("results ")[1].strip()
        other = self.path("sleight-batch")
        changed = program.read_bytes().replace(version.encode(), version[::-1].encode())
        other.write_bytes(changed)
        other.chmod(0o755)
        self.assertIn(f"results {version[::-1]}", harness.run([other, "--version"]).stdout)
        request = self.write_request()
        command = harness.batch(1, request, self.path("a.h5"), folder=self.folder)
        command += [":", "-n", "1", other, str(request), "-o", str(self.path("a.h5"))]
        result = harness.run(command)
        self.assertNotEqual(result.returncode, 0)
        self.assertRegex(result.stderr, rf"\brank 1 .*{version[::-1]}.*\brank 0 .*{version}")
        self.assertFalse(self.path("a.h5").exists())

    @unittest.skipUnless(os.environ.get("SLEIGHT_SOAK"), "takes a lease's 30 s")
    def test_a_rank_that_hangs_holds_up_nothing(self):
        # Goal: a rank that stops responding delays a run by at most a lease, and its end by a bounded wait.
        # The archive equals the undisturbed run's. Method: send SIGSTOP without SIGCONT in the middle of the
        # run.
        request = self.write_request(scans=2000, chains=3, iterations_per_scan=1000)
        output = self.path("hung.h5")
        process = self.start_batch(3, request, output, "-q")
        self.wait_for_scans(output)
        os.kill(self.ranks_of(process)[1], signal.SIGSTOP)
        begin = time.monotonic()
        errors = process.communicate(timeout=150)[1]
        print(f"\nended {time.monotonic() - begin:.0f} s after a rank did")
        self.assertEqual(process.returncode, 0, errors)
        self.assertIn("ranks do not answer", errors)
        whole = self.path("whole.h5")
        self.direct(request, whole)
        self.assertEqual(self.digest(output), self.digest(whole))


if __name__ == "__main__":
    harness.main()
