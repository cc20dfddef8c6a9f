"""Goal: if Slurm warns or pre-empts a job of deploy/slurm/direct.sbatch, or its time runs out, the job stops
cleanly, has stored everything that it computed, is queued again, resumes, and ends with the digest of an
undisturbed run. A cancelled job stops in the same way and isn't queued again. Method: start a real Slurm for
each test (private_slurm.py; needs root and `deploy/install-deps --slurm`). Compare what each start reports
(--json) with the run store; the next start must compute only the rest. Too long for CI: deploy/soak slurm."""

import json
import os
import pathlib
import re
import signal
import sqlite3
import subprocess
import sys
import time

import harness
import private_slurm
from harness import ProgramTest

CHAINS = 3
SHORT_S = 25
# Far longer than a job of 2 minutes waits for its warning, and than a grace: the machine may have been busier
# when the undisturbed run was measured.
LONG_S = 180
ENDED = ("COMPLETED", "FAILED", "CANCELLED", "TIMEOUT", "NODE_FAIL", "PREEMPTED", "BOOT_FAIL")


class Slurm(ProgramTest):
    wholes = {}  # by seconds: scans of a chain, digest

    def request_for(self, seconds):
        """A request for this much work, its total scans, and the digest of an undisturbed run."""
        request = {"chains": CHAINS, "iterations_per_scan": 1000, "thin": 50}
        if seconds not in self.wholes:
            self.direct(self.write_request("probe.toml", scans=100000000, **request),
                        self.path("probe.h5"), "--time-limit", "3s")
            scans = int(self.info(self.path("probe.h5"))["scans"] / 3 * seconds)
            whole = self.path("whole.h5")
            # The harness's time limit for one command is too short on a busy machine.
            subprocess.run([harness.program("sleight"), "direct",
                            self.write_request("whole.toml", scans=scans, **request), "-o", whole,
                            "-q"], check=True, env=harness.environment(), timeout=10 * seconds)
            self.wholes[seconds] = scans, self.digest(whole)
        scans, digest = self.wholes[seconds]
        return self.write_request(scans=scans, **request), CHAINS * scans, digest

    def slurm(self, extra=""):
        folder = self.path("slurm")
        folder.mkdir()
        environment = {
            **harness.environment(),
            "PATH": f"{pathlib.Path(harness.arguments.bin).resolve()}:{os.environ['PATH']}",
            # Open MPI's own files, so that leftovers of kills are deleted with the folder.
            "OMPI_MCA_orte_tmpdir_base": str(self.folder),
            "OMPI_MCA_btl_vader_backing_directory": str(self.folder),
            "OMPI_MCA_hwloc_base_binding_policy": "none", "OMPI_MCA_oob_tcp_if_include": "lo",
            "OMPI_MCA_btl": "self,vader,tcp", "OMPI_MCA_btl_tcp_if_include": "lo"}
        return private_slurm.PrivateSlurm(folder, environment, extra)

    def nodes(self, slurm, count):
        """Options for two ranks on one node or two."""
        names = slurm.host if count == 1 else f"{slurm.host},other"
        return "--ntasks=2", f"--nodes={count}", f"--nodelist={names}"

    def submit(self, slurm, request, nodes, *options):
        script = pathlib.Path(harness.arguments.source).resolve() / "deploy/slurm/direct.sbatch"
        self.output = self.path("job.h5")
        self.log = self.path("job.log")
        return slurm.submit(*self.nodes(slurm, nodes), f"--output={self.log}", *options, script,
                            request, self.output, "--json")

    def stored(self):
        store = sqlite3.connect(f"file:{self.output}.run/store.sqlite?mode=ro", uri=True)
        try:
            return store.execute("SELECT count(*) FROM scan").fetchone()[0]
        except sqlite3.OperationalError:
            return 0
        finally:
            store.close()

    def starts(self):
        """Reports of each start of the job that ended in order."""
        return [json.loads(text) for text in
                re.findall(r"^\{$.*?^\}$", self.log.read_text(), re.MULTILINE | re.DOTALL)]

    def wait_for(self, what, happened, seconds):
        deadline = time.monotonic() + seconds
        while not happened():
            if time.monotonic() > deadline:
                log = self.log.read_text() if self.log.exists() else "none"
                self.fail(f"{what}: not within {seconds} s; the job's log:\n{log}")
            time.sleep(0.2)

    def wait_for_scans(self, total):
        """Waits until a tenth is stored."""
        def computed():
            try:
                return self.stored() > total / 10
            except sqlite3.OperationalError:
                return False  # there is no store yet
        self.wait_for("a tenth of the scans", computed, 120)

    def check_stopped(self, total):
        """The first start has ended in order, and all that it computed is stored."""
        first, = self.starts()
        self.assertEqual(first["end"], "interrupted")
        self.assertTrue(self.output.exists())
        stored = self.stored()
        self.assertEqual(stored, first["session_scans"])
        self.assertLess(stored, total)
        return stored

    def check_resumed(self, slurm, job, total, digest):
        """The job resumes to its end, computes nothing twice, and has the same result."""
        self.wait_for("the end", lambda: slurm.job(job)["JobState"] in ENDED, 10 * LONG_S)
        self.assertEqual(slurm.job(job)["JobState"], "COMPLETED", self.log.read_text())
        starts = self.starts()
        print("\nscans of each start:", [start["session_scans"] for start in starts], "of", total)
        self.assertEqual([start["session"] for start in starts], list(range(1, len(starts) + 1)))
        self.assertEqual([start["end"] for start in starts],
                         ["interrupted"] * (len(starts) - 1) + ["finished"])
        self.assertEqual(int(slurm.job(job)["Restarts"]), len(starts) - 1)
        self.assertEqual(sum(start["session_scans"] for start in starts), total)
        self.assertEqual(self.stored(), total)
        self.assertEqual(self.digest(self.output), digest)
        return starts

    def check_nothing_left(self, slurm):
        self.assertEqual(slurm.processes(), [])
        shared = [path.name for path in self.folder.iterdir() if "vader" in path.name]
        self.assertEqual(shared, [], "shared memory left behind")

    def stopped_and_resumed(self, disturb, seconds, partition, nodes, extra=""):
        request, total, digest = self.request_for(seconds)
        with self.slurm(extra) as slurm:
            job = self.submit(slurm, request, nodes, f"--partition={partition}")
            self.wait_for_scans(total)
            begin = time.monotonic()
            disturb(slurm, job)
            self.wait_for("a new place in the queue",
                          lambda: slurm.job(job)["Restarts"] == "1" and
                          slurm.job(job)["JobState"] == "PENDING", 150)
            print(f"\nstopped and queued again in {time.monotonic() - begin:.1f} s")
            self.check_stopped(total)
            starts = self.check_resumed(slurm, job, total, digest)
            self.assertEqual(len(starts), 2)
        self.check_nothing_left(slurm)

    def warned(self, nodes):
        self.stopped_and_resumed(
            lambda slurm, job: slurm.call("scancel", "--signal=USR1", "--batch", job, check=True),
            SHORT_S, "grace", nodes)

    def preempted(self, seconds, partition, nodes, extra=""):
        def disturb(slurm, _):
            slurm.submit(*self.nodes(slurm, nodes), "--exclusive", "--partition=urgent",
                         "--output=/dev/null", "--wrap=sleep 5")
        self.stopped_and_resumed(disturb, seconds, partition, nodes, extra)

    # As with --signal=B:USR1@60: only to the script.
    def test_warned(self):
        self.warned(nodes=1)

    def test_warned_on_two_nodes(self):
        self.warned(nodes=2)

    # SIGCONT and SIGTERM to all processes, SIGKILL after KillWait. Slurm queues the job again.
    def test_preempted_at_once(self):
        self.preempted(SHORT_S, "no_grace", nodes=1)

    def test_preempted_at_once_on_two_nodes(self):
        self.preempted(SHORT_S, "no_grace", nodes=2)

    def test_preempted_with_a_warning(self):
        # The job's own signal begins the grace. The script queues the job again.
        self.preempted(SHORT_S, "grace", 1, "SlurmctldParameters=preempt_send_user_signal")

    def test_preempted_after_a_grace(self):
        # SIGTERM begins the grace, but only for processes started by srun: Open MPI's daemon and rank 1 on
        # the other node, which leave the decision to rank 0. After the grace, all happens as without a grace.
        self.preempted(LONG_S, "grace", nodes=2)

    def test_out_of_time(self):
        # Slurm warns up to half a minute early: 2 minutes give starts of 30 to 60 s.
        request, total, digest = self.request_for(LONG_S)
        with self.slurm() as slurm:
            job = self.submit(slurm, request, 1, "--time=2")
            starts = self.check_resumed(slurm, job, total, digest)
            self.assertGreaterEqual(len(starts), 2)
        self.check_nothing_left(slurm)

    def test_cancelled(self):
        request, total, digest = self.request_for(SHORT_S)
        with self.slurm() as slurm:
            job = self.submit(slurm, request, 2)
            self.wait_for_scans(total)
            slurm.call("scancel", job, check=True)
            self.wait_for("the end", lambda: slurm.job(job)["JobState"] == "CANCELLED", 60)
            stored = self.check_stopped(total)
            time.sleep(15)  # a job that was queued again would run by now
            self.assertEqual(slurm.job(job)["JobState"], "CANCELLED")
            self.assertEqual(slurm.job(job)["Restarts"], "0")
            self.assertEqual(self.stored(), stored)
            self.log.unlink()
            job = self.submit(slurm, request, 1)
            self.wait_for("the end", lambda: slurm.job(job)["JobState"] in ENDED, 10 * SHORT_S)
            second, = self.starts()
            self.assertEqual(second["end"], "finished")
            self.assertEqual(second["session_scans"], total - stored)
            self.assertEqual(self.digest(self.output), digest)
        self.check_nothing_left(slurm)


if __name__ == "__main__":
    if os.geteuid() != 0:
        sys.exit("test_slurm.py: a Slurm of one's own needs root")
    if private_slurm.missing_programs():
        sys.exit(f"test_slurm.py: {', '.join(private_slurm.missing_programs())} missing: run "
                 "deploy/install-deps --slurm")
    # Like Ctrl-C: an exception, so that the Slurm is closed.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    harness.main()
