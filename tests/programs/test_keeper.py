"""Goal: a job whose processes are killed anywhere, at any moment, ends with the digest of an undisturbed run.
It leaves no process, no shared memory, and no file of Open MPI outside its folder. Method: run real keepers
of real runs, direct and by mpirun. Each call of tests/keepers acts like a new daemon. Send kill -9 to the
keeper, mpirun and its ranks at random moments from a printed seed (--seed, --kills)."""

import itertools
import json
import os
import pathlib
import random
import shutil
import signal
import sqlite3
import time
import unittest

import harness
from harness import ProgramTest

# A run of at most a second, so that random moments hit its start and end too.
SCANS = 3000
# Two ranks, also if mpirun counts one core.
os.environ["OMPI_MCA_rmaps_base_oversubscribe"] = "1"
# Time that a killed process may need to exit. Only the best time of a test must be so short, because other
# processes share the machine.
GONE_S = 0.1


def programs():
    """Absolute paths, because the programs run in a job's folder."""
    return pathlib.Path(harness.arguments.bin).resolve()


def attempts_command():
    return [str(programs().parent / "tests/sleight-attempts"), "--bin", str(programs())]


def alive(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except (FileNotFoundError, ProcessLookupError):
        return False


def descendants(pid):
    """All descendants of a process: [(pid, name, rank or None)]."""
    parents = {}
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            parents[int(stat.parent.name)] = int(stat.read_text().rpartition(")")[2].split()[1])
        except (FileNotFoundError, ProcessLookupError):
            continue
    found, below = [], {pid}
    while below:
        below = {child for child, parent in parents.items() if parent in below}
        found += below
    return [described(pid) for pid in sorted(found)]


def described(pid):
    try:
        name = pathlib.Path(f"/proc/{pid}/comm").read_text().strip()
        variables = pathlib.Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
    except (FileNotFoundError, ProcessLookupError):
        return pid, "", None
    ranks = [v.partition(b"=")[2] for v in variables if v.startswith(b"OMPI_COMM_WORLD_RANK=")]
    return pid, name, int(ranks[0]) if ranks else None


class Keeper(ProgramTest):
    def setUp(self):
        super().setUp()
        self.job = self.folder / "jobs" / "17 with a space"
        self.job.mkdir(parents=True)
        self.sessions_before = harness.abandoned_sessions()
        self.addCleanup(self.stop_what_is_left)

    def stop_what_is_left(self):
        for pid in self.left():
            os.kill(pid, signal.SIGKILL)

    def left(self):
        """Running processes in the job's folder."""
        pids = []
        for cwd in pathlib.Path("/proc").glob("[0-9]*/cwd"):
            try:
                if os.readlink(cwd).startswith(str(self.job)) and alive(cwd.parent.name):
                    pids.append(int(cwd.parent.name))
            except (FileNotFoundError, ProcessLookupError, PermissionError):
                continue
        return pids

    def attempts(self, *args, **options):
        result = self.succeed(harness.run([*attempts_command(), *args], **options))
        return json.loads(result.stdout)

    def launch(self, attempt, *options, first=()):
        return self.attempts(*first, "launch", self.job, attempt, *options)["pid"]

    def look(self, attempt):
        return self.attempts("look", self.job, attempt)

    def await_end(self, attempt):
        """The record of the end, whose run_end is a record too."""
        look = self.attempts("await", self.job, attempt)
        self.assertEqual(look["state"], "ended", look)
        end = look["record"]["end"]
        end["run_end"] = json.loads(end["run_end"]) if end["run_end"] else None
        return end

    def request_is(self, **changes):
        path = self.write_request(**{"chains": 2, "thin": 50, **changes})
        shutil.copy(path, self.job / "request.toml")
        return self.job / "request.toml"

    def quiet_digest(self, request):
        self.direct(request, self.path("quiet.h5"))
        return self.digest(self.path("quiet.h5"))

    def check_nothing_left(self):
        deadline = time.monotonic() + 10
        while self.left():
            self.assertLess(time.monotonic(), deadline, self.left())
            time.sleep(0.002)
        self.assertEqual(harness.abandoned_memory(), [])
        self.assertEqual(harness.abandoned_sessions(self.sessions_before), set())

    def test_a_run_and_its_end(self):
        """Runs directly, over ranks, and with a store that reports the end if the pipe has none."""
        request = self.request_is(scans=50)
        digest = self.quiet_digest(request)
        self.launch(1, "-j", "1")
        end = self.await_end(1)
        self.assertEqual((end["exit_code"], end["run_end"]["end"], end["run_end"]["digest"]),
                         (0, "finished", digest))
        self.assertIn(digest, (self.job / "log").read_text())
        self.launch(2, "--ranks", "2")
        end = self.await_end(2)
        self.assertEqual((end["exit_code"], end["run_end"]["epoch"], end["run_end"]["digest"]),
                         (0, 2, digest))
        silent = self.path("silent")
        silent.write_text(f'#!/bin/bash\nexec {programs()}/sleight "${{@/end.pipe/heard}}"\n')
        silent.chmod(0o755)
        os.mkfifo(self.job / "heard")
        heard = os.open(self.job / "heard", os.O_RDONLY | os.O_NONBLOCK)
        self.addCleanup(os.close, heard)
        self.launch(3, "-j", "1", first=["--sleight", silent])
        end = self.await_end(3)
        self.assertEqual((end["exit_code"], end["run_end"]["epoch"]), (0, 3))
        self.assertEqual(json.loads(os.read(heard, 1 << 16)), end["run_end"])
        self.check_nothing_left()

    def test_ends_that_no_store_has(self):
        """A refused request, and a file that isn't a program."""
        self.request_is(scans=0)
        self.launch(1)
        end = self.await_end(1)
        self.assertEqual((end["exit_code"], end["run_end"]["exit_code"]), (3, 3))
        self.launch(2, first=["--sleight", self.path("none")])
        self.assertIn("No such file", self.await_end(2)["not_started"])

    @unittest.skipUnless(os.geteuid() == 0, "mounts a small disk")
    def test_a_full_disk(self):
        """The program fills the disk. The record of its end is written anyway."""
        command = " ".join(attempts_command())
        script = f"""
            mount -t tmpfs -o size=3m none {self.folder}/jobs && mkdir -p "$0" &&
            cp {self.request_is(scans=3_000_000, thin=1).rename(self.path('r.toml'))} "$0/request.toml" &&
            {command} launch "$0" 1 -j 1 > /dev/null &&
            {command} await "$0" 1; df "$0" | tail -1 >&2"""
        result = self.succeed(harness.run(["unshare", "-m", "bash", "-c", script, self.job]))
        look = json.loads(result.stdout)
        self.assertEqual((look["state"], look["record"]["end"]["exit_code"]), ("ended", 5), look)
        self.assertEqual(json.loads(look["record"]["end"]["run_end"])["exit_code"], 5)
        # Only the space reserved for the end is free again.
        self.assertLessEqual(int(result.stderr.split()[3]), 64, result.stderr)

    def test_stopped_in_order_and_gone_on_with(self):
        request = self.request_is(scans=200_000_000)
        for attempt, options in [(1, ["-j", "2"]), (2, ["--ranks", "2"])]:
            before = self.stored_scans()
            self.launch(attempt, *options)
            deadline = time.monotonic() + 60
            while self.stored_scans() <= before + 1000:
                self.assertLess(time.monotonic(), deadline, self.look(attempt))
                time.sleep(0.01)
            self.assertTrue(self.attempts("stop", self.job, attempt, "in_order")["stopped"])
            end = self.await_end(attempt)
            self.assertEqual((end["exit_code"], end["run_end"]["end"], end["stop_asked"]),
                             (130, "stop_requested", "in_order"))
            scans = end["run_end"]["scans"]
        request = self.request_is(scans=scans)
        self.launch(3, "-j", "2")
        self.assertEqual(self.await_end(3)["run_end"]["digest"], self.quiet_digest(request))
        self.check_nothing_left()

    def stored_scans(self):
        try:
            store = sqlite3.connect(f"file:{self.job}/out.h5.run/store.sqlite?mode=ro", uri=True)
            scans, = store.execute("SELECT SUM(next_scan) FROM replica").fetchone()
            store.close()
            return scans or 0
        except sqlite3.Error:
            return 0

    def test_killed_at_random_moments(self):
        seed = harness.arguments.seed
        kills = max(2, harness.arguments.kills // 2)
        print(f"\nmoments from --seed {seed}, --kills {harness.arguments.kills}")
        request = self.request_is(scans=SCANS)
        digest = self.quiet_digest(request)
        ways = [("direct", ["-j", "2"], ["keeper", "program"]),
                ("ranks", ["--ranks", "2"], ["keeper", "program", 0, 1])]
        for name, options, victims in ways:
            generator = random.Random(f"{seed} {name}")
            # Use the shortest of several times, so that moments are within a run even if the machine was busy
            # before.
            whole_s, hits, gone = min(self.whole_run(options) for _ in range(3)), 0, []
            turns = itertools.takewhile(lambda turn: turn < kills or (not hits and turn < 10 * kills),
                                        itertools.count())
            for turn in turns:
                victim = victims[turn % len(victims)]
                self.new_job()
                keeper = self.launch(1, *options)
                time.sleep(whole_s * generator.random())
                gone_s = self.kill(keeper, victim)
                hits += gone_s is not None
                if victim == "keeper" and gone_s is not None:
                    gone.append(gone_s)
                self.finish(options, digest, f"{name} {turn} {victim}")
            print(f"{name}: {hits} of {turn + 1} kills hit a run of {whole_s:.2f} s; with the keeper all were "
                  f"gone after {min(gone, default=0):.3f} to {max(gone, default=0):.3f} s")
            self.assertGreater(hits, 0)
            # Busy machines take longer, so the time is tested only with many kills.
            if kills >= 100:
                self.assertLess(min(gone, default=0), GONE_S)

    def new_job(self):
        shutil.rmtree(self.job)
        self.job.mkdir()
        self.request_is(scans=SCANS)

    def whole_run(self, options):
        self.new_job()
        self.launch(1, *options)
        begin = time.monotonic()
        self.await_end(1)
        return time.monotonic() - begin

    def kill(self, keeper, victim):
        """Kills one process of the attempt. Returns how long all dependent processes took to exit, or None if
        the process didn't exist."""
        below = descendants(keeper)
        if victim == "keeper":
            chosen = [keeper] if alive(keeper) else []
        elif victim == "program":
            chosen = [pid for pid, name, rank in below if rank is None and name in ("mpirun", "sleight")]
        else:
            chosen = [pid for pid, name, rank in below if rank == victim and name == "sleight-batch"]
        if not chosen:
            return None
        hung_on = [pid for pid, _, _ in below]
        os.kill(chosen[0], signal.SIGKILL)
        begin = time.monotonic()
        while victim == "keeper" and (any(map(alive, hung_on)) or self.left()):
            self.assertLess(time.monotonic() - begin, 10)
        return time.monotonic() - begin

    def finish(self, options, digest, what):
        """Acts like a daemon: looks, and starts the same attempt or the next until the run is done."""
        attempt = 1
        for _ in range(5):
            look = self.attempts("await", self.job, attempt)
            if look["state"] == "ended":
                end = look["record"]["end"]
                if end["run_end"] and json.loads(end["run_end"])["end"] == "finished":
                    self.assertEqual(json.loads(end["run_end"])["digest"], digest, what)
                    break
            if look["state"] != "never_began":
                attempt += 1
            self.launch(attempt, *options)
        else:
            self.fail(f"{what}: not done after five starts: {look}")
        self.check_nothing_left()
        self.assertFalse((self.job / "mpi").exists())


if __name__ == "__main__":
    harness.main()
