"""Shared by the tests of programs: where the programs are, and how to run and kill them."""

import argparse
import atexit
import json
import os
import pathlib
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest

arguments = None

# On one machine, as root, with more ranks than cores, over loopback only.
MPIRUN = ["mpirun", "--oversubscribe", "--bind-to", "none", "--mca", "plm", "isolated",
          "--mca", "btl", "self,vader", "--mca", "oob_tcp_if_include", "lo"]


def program(name):
    return str(pathlib.Path(arguments.bin) / name)


def sleight(*args, **options):
    """Runs `sleight` to its end. Returns text output and the exit code; a failure is no exception."""
    return run([program("sleight"), *args], **options)


def run(command, env=None, **options):
    return subprocess.run([str(part) for part in command], capture_output=True, text=True,
                          env={**environment(), **(env or {})}, timeout=300, **options)


def environment():
    return {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
            "SLEIGHT_ALLOW_ROOT": "1",
            # Open MPI and pango leak at exit. The unit tests detect our own leaks.
            "ASAN_OPTIONS": "detect_leaks=0"}


def batch(ranks, request, output, *args, folder=None, files=None):
    """Command line of a batch job. Open MPI's files are in `folder`, including those behind its memory, or in
    `files` without those."""
    own = [] if folder is None else ["--mca", "btl_vader_backing_directory", str(folder)]
    if folder or files:
        own += ["--mca", "orte_tmpdir_base", str(folder or files)]
    return [*MPIRUN, *own, "-n", str(ranks), program("sleight-batch"), str(request), "-o",
            str(output), *args]


def request_text(**changes):
    """The thesis's request with other sampler and stop values."""
    values = {"chains": 4, "seed": 1, "scans": 1000, "iterations_per_scan": 1, "thin": 1,
              **changes}
    return f"""
[world]
name = "ball_2d"
[sampler]
method = "metropolis_hastings"
chains = {values["chains"]}
seed = {values["seed"]}
iterations_per_scan = {values["iterations_per_scan"]}
[stop]
scans = {values["scans"]}
[output]
thin = {values["thin"]}
"""


def mapped(path):
    """Returns whether some process maps the file."""
    for maps in pathlib.Path("/proc").glob("[0-9]*/maps"):
        try:
            if path in maps.read_text():
                return True
        except (FileNotFoundError, ProcessLookupError, PermissionError):
            continue
    return False


def abandoned(find):
    """Returns what find() returns once that stays the same: a process that begins or ends just now leaves
    nothing abandoned."""
    for _ in range(20):
        found = find()
        if not found:
            break
        time.sleep(0.1)
    return found


def abandoned_memory():
    """Files of shared memory, from any of our jobs, that no process uses and that stay."""
    return abandoned(lambda: [
        str(path) for path in pathlib.Path("/dev/shm").iterdir()
        if any(word in path.name for word in ("sleight", "vader", "sm_segment")) and not mapped(str(path))])


def abandoned_sessions(before=frozenset()):
    """New folders of Open MPI's runs in /tmp whose mpirun has exited. Other tests and runs have such folders
    there while they run."""
    return abandoned(lambda: {
        str(path) for path in pathlib.Path("/tmp").glob("ompi*/*")
        if not path.name.startswith("pid.") or not pathlib.Path(f"/proc/{path.name[4:]}").exists()}
        - before)


class ProgramTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="sleight-test-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, name):
        return self.folder / name

    def write_request(self, name="request.toml", **changes):
        path = self.path(name)
        path.write_text(request_text(**changes))
        return path

    def succeed(self, result):
        self.assertEqual(result.returncode, 0, result.stderr + result.stdout)
        return result

    def direct(self, request, output, *args, **options):
        return self.succeed(sleight("direct", request, "-o", output, "-q", *args, **options))

    def digest(self, archive):
        return self.succeed(sleight("archive", "digest", archive)).stdout.strip()

    def events(self, archive):
        """The numbered events of an archive's run, from its store, without their numbers."""
        store = sqlite3.connect(f"file:{archive}.run/store.sqlite?mode=ro", uri=True)
        events = [json.loads(line) for line, in
                  store.execute("SELECT line FROM event ORDER BY number")]
        store.close()
        self.assertEqual([event.pop("number") for event in events],
                         list(range(1, len(events) + 1)))
        return events

    def same_events(self, output, reference):
        """Expects that two runs report the same events in the same order, except for the ends of sessions and
        which of many failures have a file. Returns the events."""
        told = []
        for archive in [output, reference]:
            told.append([{key: value for key, value in event.items() if key != "file"}
                         for event in self.events(archive) if event["kind"] != "ended"])
        self.assertEqual(*told)
        return told[0]

    def info(self, archive):
        return json.loads(self.succeed(sleight("archive", "info", archive, "--json")).stdout)


def start(command, **options):
    """Starts a program in its own process group, which is killed with the tests."""
    process = subprocess.Popen([str(part) for part in command], stdout=subprocess.DEVNULL,
                               stderr=subprocess.PIPE, text=True, env=environment(),
                               start_new_session=True, **options)
    atexit.register(lambda: process.poll() is None and kill_group(process))
    return process


def has_living_children(process):
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            state, parent = stat.read_text().rpartition(")")[2].split()[:2]
        except (FileNotFoundError, ProcessLookupError):
            continue
        if int(parent) == process.pid and state != "Z":
            return True
    return False


def await_job_without_a_rank(process, timeout_s=60):
    """Waits for a job that lost a rank or its mpirun, and returns its stderr. mpirun ends the other ranks
    within some seconds. Debian 12's mpirun may then wait for a lock forever (PMIx_server_finalize; 6 of 210
    kills in the first second on a busy machine). This function kills such an mpirun, as any supervisor of
    jobs must; the ranks have ended by themselves."""
    deadline = time.monotonic() + timeout_s
    while True:
        try:
            return process.communicate(timeout=10)[1]
        except subprocess.TimeoutExpired:
            if not has_living_children(process):
                print("mpirun had no rank left and did not end: killed")
                kill_group(process)
            elif time.monotonic() > deadline:
                processes = subprocess.run(["ps", "-o", "pid,ppid,stat,wchan:20,time,args", "-g",
                                            str(process.pid)], capture_output=True, text=True)
                kill_group(process)
                raise AssertionError(f"the job goes on after {timeout_s} s:\n{processes.stdout}")


def kill_group(process, number=signal.SIGKILL):
    try:
        os.killpg(process.pid, number)
    except ProcessLookupError:
        pass
    process.communicate()


class Timed(unittest.TextTestResult):
    """Prints at the end how long each test took, the longest first. Shorten those if deploy/test exceeds its
    budget."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.took = []

    def startTest(self, test):
        super().startTest(test)
        self.begun = time.monotonic()

    def stopTest(self, test):
        super().stopTest(test)
        self.took.append((time.monotonic() - self.begun, test))

    def printErrors(self):
        for seconds, test in sorted(self.took, key=lambda one: -one[0]):
            if seconds >= 1:
                self.stream.writeln(f"{seconds:6.1f} s {test.id()}")
        super().printErrors()


def main():
    global arguments
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", required=True, help="folder of the built programs")
    parser.add_argument("--source", required=True, help="folder of the sources")
    parser.add_argument("--kills", type=int, default=6, help="for test_kill")
    parser.add_argument("--only", choices=["direct", "batch"], help="of test_kill")
    parser.add_argument("--attacks", type=int, default=15_000, help="for test_attacks")
    parser.add_argument("--attacker", help="for test_attacks: the program, if not that of the same build")
    parser.add_argument("--seconds", type=float, default=6, help="of work in a run of test_kill")
    parser.add_argument("--seed", type=int, default=1, help="for random moments")
    arguments, rest = parser.parse_known_args()
    # The tests import this file as a module of their own, so they look there.
    sys.modules["harness"].arguments = arguments
    unittest.main(module="__main__", argv=[sys.argv[0], *rest],
                  testRunner=unittest.TextTestRunner(verbosity=2, resultclass=Timed))
