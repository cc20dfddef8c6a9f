"""Goal: Slurm as a backend does what every backend must do (backend_conformance.py). An attempt that a real
Slurm loses, warns, pre-empts, cancels or starts twice leaves what the service needs to judge it: its state in
Slurm, and its keeper's record. The next attempt resumes to the digest of an undisturbed run. Method: use a
real Slurm (private_slurm.py; needs root and `deploy/install-deps --slurm`), the backend of service/backend
through tests/backends, and real keepers and runs. Too long for CI: deploy/soak slurm."""

import json
import os
import pathlib
import shutil
import signal
import sys
import tempfile
import time

import backend_conformance
import harness
import private_slurm
from harness import ProgramTest
from service_harness import ServiceTest

# Lost nodes and ended jobs are detected sooner than usual.
EXTRA = """SlurmdTimeout=10
MinJobAge=300
KillWait=5
"""
CHAINS = 2
CONTROLLER_SAVES_S = 10
RUN_S = 12
WORK = {"chains": CHAINS, "iterations_per_scan": 1000, "thin": 50}


def start_slurm(extra=EXTRA):
    folder = pathlib.Path(tempfile.mkdtemp(prefix="sleight-slurm-"))
    environment = {
        **harness.environment(), "OMPI_MCA_orte_tmpdir_base": str(folder),
        "OMPI_MCA_btl_vader_backing_directory": str(folder), "OMPI_MCA_hwloc_base_binding_policy": "none",
        "OMPI_MCA_oob_tcp_if_include": "lo", "OMPI_MCA_btl": "self,vader,tcp",
        "OMPI_MCA_btl_tcp_if_include": "lo"}
    slurm = private_slurm.PrivateSlurm(folder, environment, extra)
    slurm.__enter__()
    return slurm


def end_slurm(slurm):
    slurm.close()
    shutil.rmtree(slurm.folder, ignore_errors=True)


class Slurm(backend_conformance.Conformance, ProgramTest):
    speed = 5

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.slurm = start_slurm()
        cls.addClassCleanup(lambda: end_slurm(cls.slurm))

    def command(self):
        tests = pathlib.Path(harness.arguments.bin).parent / "tests"
        script = pathlib.Path(harness.arguments.source).resolve() / "deploy/slurm/direct.sbatch"
        return [tests / "sleight-backend", "--kind", "slurm", "--script", script, "--option",
                f"more=--nodelist={self.slurm.host}"]

    def environment(self):
        return self.slurm.environment

    def wait_options(self):
        return {"more": "--begin=now+1000"}

    def make_away(self):
        # On return, the daemon would end an attempt whose start it hasn't saved yet.
        time.sleep(CONTROLLER_SAVES_S)
        self.slurm.kill("slurmctld")

    def come_back(self):
        self.slurm.start_controller()


class Disturbed(ProgramTest):
    """Attempts of a real run, each with its own Slurm."""

    whole = None  # scans of a chain, digest

    @staticmethod
    def whole_run(test):
        """Digest of an undisturbed run of some RUN_S."""
        if Disturbed.whole is None:
            test.direct(test.write_request("probe.toml", scans=100000000, **WORK), test.path("probe.h5"),
                        "--time-limit", "3s")
            scans = int(test.info(test.path("probe.h5"))["scans"] / CHAINS / 3 * RUN_S)
            test.direct(test.write_request("whole.toml", scans=scans, **WORK), test.path("whole.h5"))
            Disturbed.whole = scans, test.digest(test.path("whole.h5"))
        return Disturbed.whole

    def setUp(self):
        super().setUp()
        self.attempts = 0
        self.daemon = "abcdefgh"
        self.folder_of_job = self.path("job 17")
        self.folder_of_job.mkdir()
        self.write_request(self.folder_of_job / "request.toml", scans=self.whole_run(self)[0], **WORK)
        self.slurm = start_slurm()
        self.addCleanup(lambda: end_slurm(self.slurm))

    def question(self, verb, **question):
        tests = pathlib.Path(harness.arguments.bin).parent / "tests"
        script = pathlib.Path(harness.arguments.source).resolve() / "deploy/slurm/direct.sbatch"
        return harness.run([tests / "sleight-backend", "--kind", "slurm", "--script", script, verb],
                           input=json.dumps({"version": 1, **question}), env=self.slurm.environment)

    def ask(self, verb, **question):
        return json.loads(self.succeed(self.question(verb, **question)).stdout)

    def name(self):
        return {"daemon": self.daemon, "job": 17, "epoch": self.attempts}

    def order(self, ranks=0, **options):
        bin_folder = pathlib.Path(harness.arguments.bin).resolve()
        run = (["mpirun", "-n", str(ranks), str(bin_folder / "sleight-batch")] if ranks else
               [str(bin_folder / "sleight"), "direct"])
        command = [str(bin_folder / "sleight-keeper"), "--folder", str(self.folder_of_job), "--attempt",
                   str(self.attempts), "--grace", "30", *(["--ranks"] if ranks else []), "--batch", "--", *run,
                   "request.toml", "-o", "out.h5", *([] if ranks else ["-j", "1"]), "--cache", "64",
                   "--end-report", "end.pipe", "--quiet"]
        if script := options.pop("script", None):
            (self.folder_of_job / "script").write_text(script)
            command[command.index("--") + 1:] = ["/bin/bash", "script"]
        return {"attempt": self.name(), "folder": str(self.folder_of_job), "command": command,
                "label": "sleight-17", "ranks": ranks, "options": options}

    def launch(self, ranks=0, **options):
        """Launches the next attempt. Returns the number of its Slurm job."""
        self.attempts += 1
        return self.ask("launch", **self.order(ranks, **options))["id"]

    def state(self):
        return self.ask("state", attempt=self.name())

    def record(self):
        path = self.folder_of_job / "attempt.json"
        record = json.loads(path.read_text()) if path.exists() else {}
        return record if record.get("attempt") == self.attempts else {}

    def log(self):
        return "".join(path.read_text(errors="replace") for path in
                       (self.folder_of_job / "log", self.folder_of_job / "keeper.err") if path.exists())

    def until(self, what, holds, seconds=60):
        deadline = time.monotonic() + seconds
        while not holds():
            if time.monotonic() > deadline:
                self.fail(f"{what}: not within {seconds} s; {self.question('state', attempt=self.name()).stdout}"
                          f"\n{self.slurm.call('squeue', '--states=all').stdout}\n{self.record()}\n{self.log()}")
            time.sleep(0.2)

    def until_it_computes(self):
        store = self.folder_of_job / "out.h5.run/store.sqlite"
        self.until("a store", lambda: self.record() and store.exists())
        time.sleep(2)

    def until_gone(self, seconds=90):
        self.until("the end", lambda: self.state()["state"] == "gone", seconds)
        return self.state()

    def check_stopped_in_order(self):
        end = self.record()["end"]
        self.assertEqual(end["stop_asked"], "in_order")
        self.assertIn("stop_requested", end["run_end"])
        self.assertTrue((self.folder_of_job / "out.h5").exists())

    def check_ended(self):
        self.until("its record", lambda: self.record().get("end"), 10 * RUN_S)
        self.assertIn("finished", self.record()["end"]["run_end"] or "", f"{self.record()}\n{self.log()}")
        self.until("Slurm's end", lambda: self.state()["state"] in ("gone", "absent"))
        self.assertEqual(self.digest(self.folder_of_job / "out.h5"), self.whole[1])

    def check_goes_on(self, ranks=0, **options):
        self.launch(ranks, **options)
        self.check_ended()

    def starts(self):
        return self.log().count(f"=== attempt {self.attempts}: ") - \
            self.log().count(f"=== attempt {self.attempts}: ended")

    def test_the_controller_killed_as_the_attempt_starts(self):
        # The saved state may be older than the start: then Slurm starts the job again, beside the first, or
        # doesn't know it.
        self.launch()
        self.until("its start", lambda: (self.folder_of_job / "keeper.lock").exists())
        self.slurm.kill("slurmctld")
        time.sleep(1)
        self.slurm.start_controller()
        self.until("an end", lambda: self.record().get("end") or self.state()["state"] in ("gone", "absent"),
                   10 * RUN_S)
        self.until("Slurm's end", lambda: self.state()["state"] in ("gone", "absent"))
        print("\nsecond start:", "has already begun" in self.log(), "state:", self.state()["words"], end=" ")
        self.assertEqual(self.starts(), 1, self.log())
        if "finished" not in ((self.record()["end"] or {}).get("run_end") or ""):
            self.launch()
            self.assertEqual(self.starts(), 0)
        self.check_ended()

    def test_warned_before_its_time_is_over(self):
        self.launch(time="1", script="trap 'echo told; exit 130' USR1\nwhile true; do sleep 0.1; done")
        self.until("its end", lambda: self.record().get("end"), 120)
        end = self.record()["end"]
        self.assertEqual((end["stop_asked"], end["exit_code"], end["log_tail"]), ("in_order", 130, ["told"]))
        self.assertLess(end["wall_s"], 60)
        self.until_gone()
        self.check_goes_on()

    def preempt(self, ranks=0, **options):
        self.launch(ranks, partition="no_grace", **options)
        self.until_it_computes()
        self.slurm.submit("--ntasks=4", "--nodes=2", "--exclusive", "--partition=urgent", "--output=/dev/null",
                          "--wrap=sleep 5")
        seen = self.until_gone()
        self.assertEqual((seen["cause"], seen["words"].split()[0]), ("taken", "PREEMPTED"))
        self.check_stopped_in_order()
        self.check_goes_on(ranks, **options)

    def test_pre_empted_with_ranks_on_two_nodes(self):
        self.preempt(2, more="--nodes=2")

    def test_refusals(self):
        self.attempts += 1
        refused = self.question("launch", **self.order(partition="nowhere"))
        self.assertNotIn(refused.returncode, (0, backend_conformance.AWAY))
        self.assertIn("nvalid partition", refused.stderr)


class Service(ServiceTest):
    """The same through the daemon, which decides what comes next."""

    def setUp(self):
        super().setUp()
        self.slurm = start_slurm()
        self.addCleanup(lambda: end_slurm(self.slurm))
        self.request = self.write_request(scans=Disturbed.whole_run(self)[0], **WORK)
        self.path("config/sleight").mkdir(parents=True)
        script = pathlib.Path(harness.arguments.source).resolve() / "deploy/slurm/direct.sbatch"
        self.path("config/sleight/config.toml").write_text(
            f'backend = "slurm"\ncores = 4\n[slurm]\nscript = "{script}"\nmore = "--mem=0"\n')
        self.serve()

    def environment(self):
        return {**self.slurm.environment, **super().environment()}

    def submit_one(self, *options):
        arguments = [word for option in options for word in ("--option", option)]
        return self.submit(self.request, "--cores", "1", *arguments)

    def slurm_jobs(self):
        """Numbers and states of all submitted jobs, oldest first."""
        rows = self.slurm.call("squeue", "--states=all", "--noheader", "-o", "%i %T", check=True).stdout.split("\n")
        return sorted((int(row.split()[0]), row.split()[1]) for row in rows if row)

    def until_state(self, job, state, seconds=90):
        self.until(lambda: self.job(job)["state"] == state, seconds)
        return self.job(job)["reason"]

    def until_computing(self, job):
        self.until(lambda: self.job(job)["state"] == "running" and self.job(job)["scans_done"] > 0, 60)

    def check_done(self, job, starts):
        self.until_state(job, "done", 20 * RUN_S)
        seen = self.job(job)
        self.assertEqual(seen["digest"], self.whole[1])
        self.assertEqual(seen["starts"], starts, self.path("sleightd.log").read_text())
        self.assertEqual(self.slurm_jobs()[-1][0], starts)

    def reasons(self, job):
        return " | ".join(change["reason"] for change in self.ask_json("status", job, "--history")["history"])

    @property
    def whole(self):
        return Disturbed.whole

    def test_waits_and_runs_beside_a_daemon_that_is_killed(self):
        job = self.submit_one("more=--begin=now+12")
        self.until(lambda: self.job(job)["reason"] == "Slurm job 1 waits: BeginTime", 30)
        self.assertEqual(self.job(job)["state"], "starting")
        self.kill_daemon()
        self.serve()
        self.until_computing(job)
        # Waiting time is not charged, except for a second or two before the first list.
        self.assertLess(self.job(job)["core_seconds"], 10)
        self.kill_daemon()
        self.serve()
        self.check_done(job, 1)

    def test_the_controller_killed_after_a_submit(self):
        job = self.submit_one()
        self.until(lambda: self.slurm_jobs(), 30)
        self.slurm.kill("slurmctld")
        later = self.submit_one()
        time.sleep(30)
        for number in (job, later):
            self.assertNotIn(self.job(number)["state"], ("failed", "done", "cancelled"), self.reasons(number))
        self.slurm.start_controller()
        self.until_state(job, "done", 20 * RUN_S)
        self.until_state(later, "done", 20 * RUN_S)
        for number in (job, later):
            self.assertEqual(self.job(number)["digest"], self.whole[1])
            self.assertNotIn("died", self.reasons(number))

    def test_cancelled_by_hand(self):
        job = self.submit_one()
        self.until_computing(job)
        self.slurm.call("scancel", "1", check=True)
        words = self.until_state(job, "held")
        self.assertRegex(words, r"cancelled.*Slurm job 1: CANCELLED")
        self.assertIn(f"`sleight resume {job}`", words)
        time.sleep(15)
        self.assertEqual(self.job(job)["state"], "held")
        self.succeed(self.ask("resume", job))
        self.check_done(job, 2)

    def test_pre_empted(self):
        job = self.submit_one("partition=no_grace")
        self.until_computing(job)
        self.slurm.submit("--ntasks=4", "--nodes=2", "--exclusive", "--partition=urgent", "--output=/dev/null",
                          "--wrap=sleep 5")
        self.until(lambda: "Slurm job 1: PREEMPTED" in self.reasons(job), 60)
        self.until_state(job, "done", 20 * RUN_S)
        self.assertEqual((self.job(job)["starts"], self.job(job)["digest"]), (2, self.whole[1]))

    def test_a_lost_node(self):
        job = self.submit_one("more=--nodelist=other")
        self.until_computing(job)
        keeper = self.keeper(job)
        self.slurm.kill("other")
        self.slurm.kill_steps()
        os.kill(keeper, signal.SIGKILL)
        self.until(lambda: "took the job's cores" in self.reasons(job), 180)
        self.slurm.start("other", "slurmd", "-D", "-N", "other")
        self.check_done(job, 2)

    def test_one_job_started_twice(self):
        job = self.submit_one()
        self.until_computing(job)
        self.slurm.call("scontrol", "update", "jobid=1", "requeue=1", check=True)
        self.slurm.call("scontrol", "requeue", "1", check=True)
        self.check_done(job, 2)
        log = (self.folder_of(job) / "log").read_text()
        self.assertEqual(log.count("=== attempt 1: /"), 1, log)

    def test_out_of_time(self):
        job = self.submit_one("time=1")
        self.until_state(job, "done", 40 * RUN_S)
        self.assertEqual(self.job(job)["digest"], self.whole[1])

    def test_cancelled_and_held_while_it_waits(self):
        jobs = [self.submit_one("more=--begin=now+1000") for _ in range(2)]
        for number, job in enumerate(jobs, 1):
            self.until(lambda: "waiting: " in self.job(job)["reason"], 30)
        self.succeed(self.ask("cancel", jobs[0]))
        self.succeed(self.ask("hold", jobs[1]))
        self.until_state(jobs[0], "cancelled", 60)
        self.until_state(jobs[1], "held", 60)
        self.assertEqual({state for _, state in self.slurm_jobs()}, {"CANCELLED"})

    def test_ranks_on_two_nodes(self):
        job = self.submit(self.request, "--ranks", "2", "--option", "more=--nodes=2")
        self.check_done(job, 1)

    def test_options_that_are_refused(self):
        for option, words in (("more=--comment=x", "--comment"), ("colour=red", "colour")):
            refused = self.ask("submit", self.request, "--option", option)
            self.assertNotEqual(refused.returncode, 0)
            self.assertIn(words, refused.stderr)
        job = self.submit_one("partition=nowhere")
        self.until(lambda: "nvalid partition" in self.reasons(job), 30)


if __name__ == "__main__":
    if os.geteuid() != 0:
        sys.exit("test_slurm_backend.py: a Slurm of one's own needs root")
    if private_slurm.missing_programs():
        sys.exit(f"test_slurm_backend.py: {', '.join(private_slurm.missing_programs())} missing: run "
                 "deploy/install-deps --slurm")
    # Like Ctrl-C: an exception, so that the Slurm is closed.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    harness.main()
