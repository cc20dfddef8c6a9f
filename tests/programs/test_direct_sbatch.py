"""Goal: after a clean stop, deploy/slurm/direct.sbatch queues its job again, unless the stop was by SIGTERM,
after which Slurm or a person decides. This holds whenever a warning comes. After an error, the job isn't
queued again. Method: run the script with a fake `mpirun`, which each test scripts, and a fake `scontrol`,
which records its calls. test_slurm.py uses a real Slurm."""

import os
import pathlib
import signal
import subprocess
import time

import harness
from harness import ProgramTest


class DirectSbatch(ProgramTest):
    def setUp(self):
        super().setUp()
        self.command("scontrol", f'echo "$*" >> {self.path("asked")}')

    def command(self, name, text):
        self.path(name).write_text(f"#!/bin/bash\n{text}\n")
        self.path(name).chmod(0o755)

    def start(self, *arguments):
        script = pathlib.Path(harness.arguments.source).resolve() / "deploy/slurm/direct.sbatch"
        return subprocess.Popen(
            [script, *(arguments or ("r.toml", "o.h5"))], text=True, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, start_new_session=True,
            env={**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}", "SLURM_JOB_ID": "17"})

    def ended(self, process):
        """The exit code, and how often the job was queued again."""
        said, _ = process.communicate(timeout=60)
        asked = self.path("asked").read_text() if self.path("asked").exists() else ""
        self.assertEqual(asked.replace("requeue 17\n", ""), "", said)
        return process.returncode, asked.count("requeue 17\n")

    def signalled(self, number):
        """`mpirun` reports that it waits for signals, so that no signal arrives before."""
        process = self.start()
        deadline = time.monotonic() + 30
        while not self.path("waits").exists():
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)
        process.send_signal(number)
        return self.ended(process)

    def waiting_mpirun(self, on_warning):
        self.command("mpirun", f"""trap '{on_warning}' USR1
touch {self.path("waits")}
for ((i = 0; i < 600; i++)); do sleep 0.05; done""")

    def test_what_mpirun_is_asked(self):
        self.command("mpirun", f'printf "%s\\n" "$@" > {self.path("arguments")}')
        self.assertEqual(self.ended(self.start("a b.toml", "o.h5", "--json")), (0, 0))
        self.assertEqual(self.path("arguments").read_text(),
                         "--mca\norte_launch_agent\nenv --block-signal=TERM orted\n"
                         "sleight-batch\na b.toml\n-o\no.h5\n--json\n")

    def test_the_warning_is_passed_on_and_the_job_queued_again(self):
        self.waiting_mpirun("sleep 0.3; exit 130")
        self.assertEqual(self.signalled(signal.SIGUSR1), (130, 1))

    def test_a_warning_that_comes_as_the_job_ends(self):
        for _ in range(50):
            for code, ends in [(130, [(130, 1)]), (0, [(0, 0)]), (5, [(5, 0)])]:
                self.path("asked").unlink(missing_ok=True)
                self.command("mpirun", f"trap '' USR1; kill -USR1 $PPID; exit {code}")
                # bash sometimes loses the exit code. Then the next start detects the end.
                self.assertIn(self.ended(self.start()), [*ends, (255, 1)])

    def test_a_warning_before_mpirun_listens(self):
        self.command("mpirun", "kill -USR1 $PPID; sleep 10")
        self.assertEqual(self.ended(self.start()), (138, 1))

    def test_several_warnings(self):
        self.waiting_mpirun("trap : USR1; for i in 1 2 3; do kill -USR1 $PPID; sleep 0.1; done; "
                            "exit 130")
        self.assertEqual(self.signalled(signal.SIGUSR1), (130, 1))

    def test_after_sigterm_another_decides(self):
        self.waiting_mpirun("exit 130")
        self.assertEqual(self.signalled(signal.SIGTERM), (130, 0))

    def test_ranks_that_were_asked_on_their_own(self):
        self.command("mpirun", "exit 130")
        self.assertEqual(self.ended(self.start()), (130, 1))

    def test_out_of_time_while_it_stops(self):
        self.waiting_mpirun("trap : USR1; kill -TERM $PPID; sleep 0.3; exit 130")
        self.assertEqual(self.signalled(signal.SIGUSR1), (130, 1))

    def test_sigterm_does_not_reach_mpirun(self):
        self.command("mpirun", "trap '' USR1; kill -TERM $$; kill -TERM $PPID; "
                               f"grep SigBlk /proc/$$/status > {self.path('blocked')}; exit 130")
        self.assertEqual(self.ended(self.start()), (130, 0))
        blocked = int(self.path("blocked").read_text().split()[1], 16)
        self.assertTrue(blocked >> (signal.SIGTERM - 1) & 1)

    def test_without_an_env_that_blocks_signals(self):
        self.command("env", "exit 125")
        self.waiting_mpirun("exit 130")
        self.assertEqual(self.signalled(signal.SIGUSR1), (130, 1))

    def test_other_ends_stay(self):
        for code in (0, 3, 5, 137):
            self.command("mpirun", f"exit {code}")
            self.assertEqual(self.ended(self.start()), (code, 0))

    def attempt(self):
        """Runs the service's form of the script, with a keeper that records its arguments. Returns the launch
        agent, the blocked signals and how the script ended."""
        self.command("keeper", f"""printf '%s\\n' "$@" > {self.path("arguments")}
echo "${{OMPI_MCA_orte_launch_agent:-}}" > {self.path("agent")}
grep SigBlk /proc/$$/status > {self.path("blocked")}; exit 4""")
        ended = self.ended(self.start("--attempt", self.path("keeper"), "--folder", "a b", "--", "it's"))
        self.assertEqual(self.path("arguments").read_text(), "--folder\na b\n--\nit's\n")
        blocked = int(self.path("blocked").read_text().split()[1], 16)
        return (self.path("agent").read_text().strip(),
                [bool(blocked >> (number - 1) & 1) for number in (signal.SIGUSR1, signal.SIGTERM)], ended)

    def test_an_attempt_of_the_service_is_queued_by_the_service_alone(self):
        self.assertEqual(self.attempt(), ("env --block-signal=TERM orted", [True, True], (4, 0)))

    def test_an_attempt_without_an_env_that_blocks_signals(self):
        self.command("env", "exit 125")
        self.assertEqual(self.attempt(), ("", [False, False], (4, 0)))

    def test_signals_before_the_keeper_listens_wait_for_it(self):
        # The keeper accepts signals late and receives both.
        self.command("keeper", f"""touch {self.path("waits")}
exec /usr/bin/python3 -c '
import signal, time
time.sleep(1)
heard = [signal.sigtimedwait({{signal.SIGUSR1, signal.SIGTERM}}, 5).si_signo for _ in range(2)]
raise SystemExit(sorted(heard) != [signal.SIGUSR1, signal.SIGTERM])'""")
        process = self.start("--attempt", self.path("keeper"))
        deadline = time.monotonic() + 30
        while not self.path("waits").exists():
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.01)
        process.send_signal(signal.SIGUSR1)
        process.send_signal(signal.SIGTERM)
        self.assertEqual(self.ended(process), (0, 0))

    def test_wrong_usage(self):
        self.command("mpirun", f"touch {self.path('ran')}")
        self.assertEqual(self.ended(self.start("r.toml")), (2, 0))
        self.assertEqual(self.ended(self.start("r.toml", "o.h5", "--fresh")), (2, 0))
        self.assertFalse(self.path("ran").exists())


if __name__ == "__main__":
    harness.main()
