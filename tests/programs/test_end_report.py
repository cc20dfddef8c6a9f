"""Goal: the program that starts a run always gets a report of how the session ended: from the run store, or
through the pipe if the store can't be written. Method: run both programs to every kind of end, with a pipe
that the test reads."""

import json
import os
import pathlib
import signal
import sqlite3
import subprocess
import time

import harness
from harness import ProgramTest

KEYS = ["epoch", "end", "exit_code", "scans", "found", "solutions", "digest", "words", "place"]


class EndReport(ProgramTest):
    def setUp(self):
        super().setUp()
        self.pipe = self.path("pipe")
        os.mkfifo(self.pipe)
        self.reader = os.open(self.pipe, os.O_RDONLY | os.O_NONBLOCK)
        self.addCleanup(lambda: os.close(self.reader))

    def told(self):
        """The single line in the pipe. None if there was none."""
        try:
            data = os.read(self.reader, 1 << 16)
        except BlockingIOError:
            return None
        if not data:
            return None
        self.assertEqual(data.count(b"\n"), 1, data)
        self.assertTrue(data.endswith(b"\n"))
        record = json.loads(data)
        self.assertEqual(list(record), KEYS)
        return record

    def stored(self, output):
        """The end of each session in the store."""
        store = sqlite3.connect(f"file:{output}.run/store.sqlite?mode=ro", uri=True)
        ends = [json.loads(text) if text else None
                for text, in store.execute("SELECT ended FROM session ORDER BY epoch")]
        store.close()
        return ends

    def run_direct(self, request, output, *args, **options):
        return harness.sleight("direct", request, "-o", output, "-q", "--end-report", self.pipe, *args,
                               **options)

    def await_session(self, output, number):
        """Waits until a number of sessions have begun and the last has stored something."""
        deadline = time.monotonic() + 60
        before = None
        while time.monotonic() < deadline:
            try:
                store = sqlite3.connect(f"file:{output}.run/store.sqlite?mode=ro", uri=True)
                begun, = store.execute("SELECT COUNT(*) FROM session").fetchone()
                scans, = store.execute("SELECT SUM(next_scan) FROM replica").fetchone()
                store.close()
            except sqlite3.Error:
                begun, scans = 0, None
            if begun == number and scans is not None:
                if before is not None and scans > before:
                    return
                before = scans if before is None else before
            time.sleep(0.02)
        self.fail("no session has stored anything")

    def test_finished_and_stopped(self):
        output = self.path("a.h5")
        request = self.write_request(chains=2, scans=200_000_000)
        self.succeed(self.run_direct(request, output, "--time-limit", "0.3s"))
        stopped = self.told()
        self.assertEqual((stopped["epoch"], stopped["end"], stopped["exit_code"]), (1, "time_limit", 0))
        self.assertGreater(stopped["scans"], 0)
        self.assertEqual(stopped["digest"], self.digest(output))
        request = self.write_request(chains=2, scans=50)
        self.succeed(self.run_direct(request, output))
        finished = self.told()
        self.assertEqual((finished["epoch"], finished["end"], finished["scans"]), (2, "finished", 50))
        self.assertEqual(self.stored(output), [stopped, finished])

    def test_an_ordinary_file_is_refused_and_kept(self):
        request = self.write_request(chains=2, scans=50)
        kept = pathlib.Path(request).read_text()
        result = harness.sleight("direct", request, "-o", self.path("a.h5"), "--end-report", request)
        self.assertEqual(result.returncode, 2)
        self.assertIn("not a named pipe", result.stderr)
        self.assertEqual(pathlib.Path(request).read_text(), kept)

    def test_a_signal_and_a_kill(self):
        output = self.path("a.h5")
        request = self.write_request(chains=2, scans=200_000_000)
        sessions = 0
        for number, end in [(signal.SIGKILL, None), (signal.SIGINT, "stop_requested")]:
            process = harness.start([harness.program("sleight"), "direct", request, "-o", output, "-q",
                                     "--end-report", self.pipe])
            sessions += 1
            self.await_session(output, sessions)
            process.send_signal(number)
            process.communicate(timeout=60)
            record = self.told()
            self.assertEqual(record and record["end"], end)
            if end:
                self.assertEqual((record["epoch"], record["exit_code"]), (2, 130))
        self.assertEqual(self.stored(output), [None, record])

    def test_refused_before_there_is_a_store(self):
        output = self.path("a.h5")
        bad = self.write_request("bad.toml", scans=0)
        self.assertEqual(self.run_direct(bad, output).returncode, 3)
        record = self.told()
        self.assertEqual((record["epoch"], record["end"], record["exit_code"]), (0, "failed", 3))
        self.assertEqual(self.run_direct(self.path("none.toml"), output).returncode, 5)
        self.assertIn("none.toml", self.told()["words"])
        output.write_bytes(b"mine")
        self.assertEqual(self.run_direct(self.write_request(scans=20), output).returncode, 4)
        record = self.told()
        self.assertEqual((record["epoch"], record["exit_code"]), (0, 4))

    def test_refused_with_a_store(self):
        """Another file is in the archive's place."""
        output = self.path("a.h5")
        request = self.write_request(scans=20)
        self.succeed(self.run_direct(request, output))
        first = self.told()
        output.write_bytes(b"mine")
        self.assertEqual(self.run_direct(request, output).returncode, 4)
        second = self.told()
        self.assertEqual((second["epoch"], second["end"], second["exit_code"]), (2, "failed", 4))
        self.assertEqual(self.stored(output), [first, second])

    def test_a_full_disk(self):
        """Files may grow to 300 kB: the store can't write the rows, so the pipe receives the record."""
        output = self.path("a.h5")
        request = self.write_request(chains=2, scans=100_000)
        command = f"ulimit -f 300; exec \"$0\" direct {request} -o {output} -q --end-report {self.pipe}"
        result = harness.run(["bash", "-c", command, harness.program("sleight")])
        self.assertEqual(result.returncode, 5, result.stderr)
        record = self.told()
        self.assertEqual((record["epoch"], record["end"], record["exit_code"]), (1, "failed", 5))
        self.assertIn("store.sqlite", record["words"])

    def test_a_check_that_fails(self):
        library = pathlib.Path(harness.arguments.bin).parent / "tests/libsleight_failing_calls.so"
        request = self.write_request(chains=2, scans=50)
        result = self.run_direct(request, self.path("a.h5"), env={"LD_PRELOAD": str(library)})
        self.assertEqual(result.returncode, -signal.SIGABRT)
        record = self.told()
        self.assertEqual((record["end"], record["exit_code"]), ("bug", 1))
        self.assertRegex(record["place"], r"sha256\.cpp:\d+$")
        self.assertIn("check failed: EVP_DigestInit_ex", record["words"])
        self.assertEqual(self.stored(self.path("a.h5")), [None])

    def test_ranks(self):
        output = self.path("a.h5")
        request = self.write_request(chains=2, scans=50)
        job = harness.batch(2, request, output, "-q", "--end-report", self.pipe, folder=self.folder)
        self.succeed(harness.run(job))
        record = self.told()
        self.assertEqual((record["end"], record["scans"]), ("finished", 50))
        self.assertEqual(self.stored(output), [record])
        bad = self.write_request("bad.toml", scans=0)
        job = harness.batch(2, bad, output, "-q", "--end-report", self.pipe, folder=self.folder)
        self.assertEqual(harness.run(job).returncode, 3)
        self.assertEqual(self.told()["exit_code"], 3)

    def test_a_rank_elsewhere_sees_no_pipe(self):
        """Another host has no such pipe, or a pipe that nobody reads; its ranks compute anyway. Method: run a
        rank other than 0, before MPI refuses to start this way."""
        request = self.write_request(scans=20)
        for rank, words in [("0", "--end-report"), ("1", None)]:
            result = harness.run([harness.program("sleight-batch"), request, "-o", self.path("a.h5"),
                                  "--end-report", self.path("none")],
                                 env={"OMPI_COMM_WORLD_RANK": rank, "OMPI_COMM_WORLD_SIZE": "2"})
            self.assertEqual("--end-report" in result.stderr, words is not None, result.stderr)
            self.assertEqual(result.returncode, 2 if words else 0, result.stderr)

    def test_a_run_that_never_drew(self):
        request = self.path("judged.toml")
        request.write_text('[world]\nname = "spelling"\nbitmap = "#.#"\n[sampler]\nmethod = '
                           '"metropolis_hastings"\nstart = "search"\n[stop]\nscans = 3\n')
        self.succeed(self.run_direct(request, self.path("a.h5")))
        record = self.told()
        self.assertEqual((record["end"], record["digest"]), ("no_draws", ""))

    def test_no_pipe(self):
        request = self.write_request(scans=20)
        for path, words in [(self.path("none"), "No such file"), (self.path("unread"), "no process is reading")]:
            if "unread" in str(path):
                os.mkfifo(path)
            result = harness.sleight("direct", request, "-o", self.path("a.h5"), "--end-report", path)
            self.assertEqual(result.returncode, 2)
            self.assertIn(words, result.stderr)
        self.assertFalse(self.path("a.h5").exists())

    def test_a_supervisor_that_has_gone(self):
        process = subprocess.Popen([harness.program("sleight"), "direct",
                                    self.write_request(chains=2, scans=3000), "-o", self.path("a.h5"),
                                    "-q", "--end-report", str(self.pipe)], env=harness.environment())
        while not self.path("a.h5.run").exists():
            time.sleep(0.005)
        os.close(self.reader)
        self.reader = os.open("/dev/null", os.O_RDONLY)
        self.assertEqual(process.wait(timeout=60), 0)


if __name__ == "__main__":
    harness.main()
