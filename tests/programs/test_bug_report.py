"""Goal: a bug report has everything to repeat the bug: the command line, the request with its
seed, and a job's rank. Method: run the programs with a replaced library function
(failing_calls.cpp), so that a CHECK fails; run one that can't create threads."""

import pathlib
import re
import signal

import harness
from harness import ProgramTest

class BugReport(ProgramTest):
    def failing_calls(self):
        library = pathlib.Path(harness.arguments.bin).parent / "tests" / "libsleight_failing_calls.so"
        self.assertTrue(library.is_file(), library)
        return {"LD_PRELOAD": str(library)}

    def request_line(self, request):
        return f"request {request}, world ball_2d, seed 41, version 0."

    def test_a_check_that_fails_in_sleight(self):
        request = self.write_request("my request.toml", chains=2, seed=41, scans=50)
        command = [harness.program("sleight"), "direct", request, "-o", self.path("a.h5"), "-q"]
        result = harness.run(command, env=self.failing_calls())
        self.assertEqual(result.returncode, -signal.SIGABRT, result.stderr)
        lines = result.stderr.splitlines()
        self.assertRegex(lines[0], r"sha256\.cpp:\d+: check failed: EVP_DigestInit_ex")
        quoted = [f"'{part}'" if " " in str(part) else str(part) for part in command]
        self.assertEqual(lines[1], "to repeat: " + " ".join(quoted))
        self.assertTrue(lines[2].startswith(self.request_line(request)), lines)
        self.assertEqual(len(lines), 3, lines)

        # The printed command repeats the bug: the run resumes from its store and fails again.
        again = harness.run(["sh", "-c", "exec " + lines[1].removeprefix("to repeat: ")],
                            env=self.failing_calls())
        self.assertEqual(again.stderr, result.stderr)
        # The seed is the run's seed, not the request's.
        command[command.index(self.path("a.h5"))] = self.path("b.h5")
        result = harness.run([*command, "--seed", "77"], env=self.failing_calls())
        self.assertIn("seed 77, version", result.stderr)

    def test_an_exception_that_nobody_expected(self):
        request = self.write_request(chains=2, seed=41, scans=50)
        command = [harness.program("sleight"), "direct", request, "-o", self.path("a.h5"), "-q"]
        result = harness.run(command, env={**self.failing_calls(), "FAILING_THREADS": "1"})
        self.assertEqual(result.returncode, 1, result.stderr)
        # The event log also needs a thread and first reports that it has none.
        lines = [line for line in result.stderr.splitlines()
                 if not line.startswith("sleight: warning: ")]
        self.assertRegex(lines[0], "^sleight: unexpected error: .")
        self.assertEqual(lines[1], "to repeat: " + " ".join(str(part) for part in command))
        self.assertTrue(lines[2].startswith(self.request_line(request)), lines)

    def test_a_check_that_fails_on_a_rank(self):
        request = self.write_request(chains=2, seed=41, scans=50)
        result = harness.run([*harness.batch(3, request, self.path("a.h5"), "-q", folder=self.folder)],
                             env=self.failing_calls())
        self.assertNotEqual(result.returncode, 0)
        self.assertRegex(result.stderr, r"main_batch\.cpp:\d+: check failed: provided >= ")
        self.assertIn(f"to repeat: mpirun -n 3 {harness.program('sleight-batch')} {request} -o ",
                      result.stderr)
        self.assertIn("rank 1 of 3\n", result.stderr)
        self.assertEqual(len(re.findall("to repeat: ", result.stderr)), 1, result.stderr)

    def test_other_failures_are_no_bugs(self):
        """A failure that the user can fix prints no bug report."""
        result = harness.sleight("direct", self.path("none.toml"), "-o", self.path("a.h5"))
        self.assertEqual(result.returncode, 5)
        self.assertNotIn("to repeat: ", result.stderr)


if __name__ == "__main__":
    harness.main()
