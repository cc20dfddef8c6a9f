"""Goal: no output is ever lost to another run. Method: real runs with colliding outputs, full disks and
damaged stores."""

import resource
import signal
import subprocess
import time

import harness
from harness import ProgramTest, sleight

CONFLICT = 4
ENVIRONMENT = 5


class Conflicts(ProgramTest):
    def refuse(self, result, word):
        self.assertEqual(result.returncode, CONFLICT, result.stderr)
        self.assertIn(word, result.stderr)

    def test_another_request_is_refused_and_fresh_takes_over(self):
        output = self.path("a.h5")
        self.direct(self.write_request(), output)
        before = output.read_bytes()
        other = self.write_request("other.toml", seed=2)
        self.refuse(sleight("direct", other, "-o", output), "another request")
        self.assertEqual(output.read_bytes(), before)
        self.direct(other, output, "--fresh")
        self.assertNotEqual(output.read_bytes(), before)

    def test_a_file_that_is_no_run_of_ours_is_not_touched(self):
        output = self.path("thesis.h5")
        output.write_text("three years of work")
        for extra in [[], ["--fresh"]]:
            self.refuse(sleight("direct", self.write_request(), "-o", output, *extra),
                        "not overwritten")
            self.assertEqual(output.read_text(), "three years of work")
        self.assertFalse(self.path("thesis.h5.run").exists())

    def test_two_processes_do_not_write_one_run(self):
        request = self.write_request(scans=3000000)
        command = [harness.program("sleight"), "direct", request, "-o", self.path("a.h5")]
        first = harness.start(command)
        while not self.path("a.h5.run/store.sqlite").exists():
            time.sleep(0.05)
        self.refuse(harness.run(command), str(first.pid))
        harness.kill_group(first)

    def test_a_damaged_store_is_an_error_with_advice(self):
        output = self.path("a.h5")
        self.direct(self.write_request(), output)
        self.path("a.h5.run/store.sqlite").write_bytes(b"garbage" * 1000)
        result = sleight("direct", self.write_request(), "-o", output)
        self.assertEqual(result.returncode, ENVIRONMENT, result.stderr)
        self.assertIn("--fresh", result.stderr)
        self.direct(self.write_request(), output, "--fresh")


class FullDisk(ProgramTest):
    def limited(self, request, output, bytes_max):
        """A run whose files have a size limit. Writes beyond it fail."""
        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (bytes_max, bytes_max))
        return subprocess.run([harness.program("sleight"), "direct", request, "-o", output, "-q"],
                              capture_output=True, text=True, preexec_fn=limit,
                              restore_signals=False, env=harness.environment(), timeout=300)

    def test_a_clear_error_nothing_lost_and_the_run_goes_on(self):
        request = self.write_request(scans=30000)
        whole = self.path("whole.h5")
        self.direct(request, whole)
        output = self.path("a.h5")
        result = self.limited(request, output, 2_000_000)
        self.assertEqual(result.returncode, ENVIRONMENT, result.stderr)
        self.assertIn("store.sqlite", result.stderr)
        self.assertFalse(output.exists())
        self.assertEqual([p.name for p in self.folder.glob("*.tmp*")], [])
        self.direct(request, output)
        self.assertEqual(output.read_bytes(), whole.read_bytes())


if __name__ == "__main__":
    harness.main()
