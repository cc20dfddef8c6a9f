"""Goal: no input from peers harms the service. It stays the same process within its memory limit, its jobs
stay intact, and it keeps answering others. Method: run a daemon and `sleight-attack` (tests/attacks) on its
socket and its port. --attacks sets the number; deploy/soak's `attacks` uses 1,000,000."""

import json
import pathlib
import signal
import subprocess

import harness
from service_harness import TlsServiceTest

MEMORY_MAX = 256 << 20
LEFT_OPEN_MAX = 3  # descriptors and threads that may come and go by themselves
FETCHED_MAX = 16  # service/daemon/fetching.h, k_held_files_max
AUDIT_BYTES_MAX = 16 << 20  # of each of its two files


class Attacks(TlsServiceTest):
    def proc(self, name):
        return pathlib.Path(f"/proc/{self.daemon.pid}/{name}")

    def status_of_process(self):
        return dict(line.split(":\t", 1) for line in self.proc("status").read_text().splitlines())

    def held(self):
        return len(list(self.proc("fd").iterdir())), int(self.status_of_process()["Threads"])

    def jobs_now(self):
        return [self.ask_json("status", number, "--history") for number in (1, 2)]

    def files_now(self):
        """Files beside the daemon's own, and files that it holds for interrupted fetches. An attack must add
        nothing to them."""
        notes = ("state/audit.", "state/fetched/", "sleightd.log")
        found = sorted(str(path.relative_to(self.folder)) for path in self.folder.rglob("*"))
        # SQLite creates and removes its own files at any time.
        return [name for name in found
                if not name.startswith(notes) and not name.endswith(("-wal", "-shm", "-journal"))]

    def test_the_service_stands(self):
        # With sanitizers, the daemon reports leaks at its end.
        daemon = self.serve_over_tls(env={"ASAN_OPTIONS": "detect_leaks=1"})
        done = self.submit(self.write_request(chains=1, scans=10))
        self.wait(done)
        held = self.submit(self.write_request("long.toml", chains=1, scans=100_000_000))
        self.until_running(held)
        self.succeed(self.ask("hold", held))
        self.until(lambda: self.job(held)["state"] == "held")
        # A user who is neither the service's nor the jobs' owner attempts everything, including `stop`.
        token, _ = self.token("attacker", "--user", "nobody")
        self.succeed(self.log_in("honest", token))
        jobs, files, (descriptors, threads) = self.jobs_now(), self.files_now(), self.held()

        attacker = harness.arguments.attacker or pathlib.Path(harness.arguments.bin).parent / "tests/sleight-attack"
        attack = subprocess.Popen(
            [attacker, "--socket", self.state / "socket", "--address", self.address, "--token-file", token,
             "--certificate", self.state / "tls/certificate.pem", "--count", str(harness.arguments.attacks),
             "--seed", str(harness.arguments.seed)],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=harness.environment())
        self.addCleanup(attack.stdout.close)
        self.addCleanup(attack.kill)
        for line in attack.stdout:
            print(line, end="", flush=True)
        log = self.path("sleightd.log").read_text()
        self.assertEqual(attack.wait(), 0, log)

        self.assertIsNone(daemon.poll(), log)
        self.assertEqual(self.ask_json("server", "status")["pid"], daemon.pid)
        for word in ["bug", "failed in the server", "CHECK", "Sanitizer", "runtime error"]:
            self.assertNotIn(word, log)
        self.assertLess(len(log), 100_000, "the log grows with the attacks")
        peak = int(self.status_of_process()["VmHWM"].split()[0]) << 10
        print(f"peak memory {peak / 1e6:.0f} MB")
        # A sanitizer's memory (linked by GCC, built in by clang) doesn't count.
        if b"__asan_init" not in pathlib.Path(harness.program("sleightd")).read_bytes():
            self.assertLess(peak, MEMORY_MAX)
        self.until(lambda: self.held()[0] <= descriptors + LEFT_OPEN_MAX and
                   self.held()[1] <= threads + LEFT_OPEN_MAX, 15)
        self.assertEqual(self.jobs_now(), jobs)
        self.assertEqual(len(self.ask_json("list")["jobs"]), len(jobs))
        self.assertEqual(self.files_now(), files)
        self.left_fetched = {path.name for path in (self.state / "fetched").iterdir()}
        self.assertLessEqual(len(self.left_fetched), FETCHED_MAX)
        self.judge_audit_log()
        self.stop_amid_calls(held)
        self.assertEqual(daemon.returncode, 0, self.path("sleightd.log").read_text())

    def stop_amid_calls(self, job):
        """The daemon also ends in order while it owes answers, here archives that it is writing."""
        for i in range(3):
            fetch = subprocess.Popen(
                [harness.program("sleight"), "fetch", str(job), "--so-far", "-o", self.path(f"{i}.h5")],
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                env={**harness.environment(), **self.environment()})
            self.addCleanup(fetch.wait)
            self.addCleanup(fetch.kill)
        # Archives are here while they are written.
        self.until(lambda: any(path.name not in self.left_fetched for path in (self.state / "fetched").iterdir()))
        self.kill_daemon(signal.SIGTERM)

    def judge_audit_log(self):
        """Each line of the audit log is complete and within the limit, for any request."""
        calls = set()
        for path in self.state.glob("audit*.log"):
            self.assertLessEqual(path.stat().st_size, AUDIT_BYTES_MAX)
            for line in path.read_bytes().split(b"\n")[:-1]:
                self.assertLess(len(line), 2000)
                calls.add(json.loads(line)["call"])
        # The log contains the attacks.
        for call in ["submit", "cancel", "fetch", "login", "stop", "create_token", "revoke_token"]:
            self.assertIn(call, calls)


if __name__ == "__main__":
    harness.main()
