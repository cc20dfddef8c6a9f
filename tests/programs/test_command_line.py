"""Goal: the command line behaves as people expect. Method: real processes; what they print, on
which stream, and their exit codes."""

import json
import re
import signal
import subprocess
import time

import harness
from harness import ProgramTest, sleight

COMMANDS = [["direct"], ["check"], ["keys"], ["archive"], ["archive", "info"],
            ["archive", "digest"], ["archive", "verify"], ["archive", "export"], ["plot"]]


class Help(ProgramTest):
    def test_every_command_has_help_with_an_example(self):
        self.succeed(sleight("--help"))
        for command in COMMANDS:
            text = self.succeed(sleight(*command, "--help")).stdout
            if command != ["archive"]:
                self.assertRegex(text, r"Examples?:\n", command)

    def test_version_is_exact(self):
        text = self.succeed(sleight("--version")).stdout
        self.assertRegex(text, r"^sleight \d+\.\d+\.\d+\+(g[0-9a-f]{12}(\.dirty\.[0-9a-f]{12})?"
                               r"|src\.[0-9a-f]{12})\n$")

    def test_exit_codes_are_documented(self):
        text = sleight("--help").stdout
        for code in ["0", "1", "2", "3", "4", "5", "6", "130"]:
            self.assertRegex(text, rf"\b{code}\b")

    def test_keys_name_unit_and_range(self):
        text = self.succeed(sleight("keys", "ball_2d")).stdout
        for key in ["restitution", "normal_sd_deg", "sigma_diameters", "chains", "scans", "thin"]:
            self.assertIn(key, text)


class Usage(ProgramTest):
    def test_wrong_usage_is_code_2(self):
        request = self.write_request()
        for wrong in [[], ["nonsense"], ["direct"], ["direct", request],
                      ["direct", request, "-o", self.path("a.h5"), "--threads", "0"],
                      ["direct", request, "-o", self.path("a.h5"), "--time-limit", "soon"],
                      ["direct", request, "-o", self.path("a.h5"), "--seed", "-1"],
                      ["keys", "no_such_world"], ["plot", self.path("a.h5"), "--what", "smoke"]]:
            result = sleight(*wrong)
            self.assertEqual(result.returncode, 2, (wrong, result.stderr))
            self.assertEqual(result.stdout, "", wrong)

    def test_a_bad_request_is_code_3_with_every_error_placed(self):
        request = self.path("bad.toml")
        request.write_text('[world]\nname = "ball_2d"\nrestitution = 2\n[constraint]\n'
                           "sigma_diametres = 0.1\n[stop]\nscans = 0\n")
        result = sleight("direct", request, "-o", self.path("a.h5"))
        self.assertEqual(result.returncode, 3)
        lines = result.stderr.splitlines()
        self.assertEqual(len(lines), 3, result.stderr)
        for line, place in zip(lines, [3, 5, 7]):
            self.assertRegex(line, rf"^{re.escape(str(request))}:{place}:\d+: ")
        self.assertIn("did you mean 'sigma_diameters'?", lines[1])
        self.assertFalse(self.path("a.h5.run").exists())

    def test_a_missing_request_is_code_5_and_named(self):
        result = sleight("direct", self.path("none.toml"), "-o", self.path("a.h5"))
        self.assertEqual(result.returncode, 5)
        self.assertIn("none.toml", result.stderr)

    def test_no_archive_is_code_6(self):
        other = self.path("text.h5")
        other.write_text("not an archive")
        for command in [["archive", "info"], ["archive", "verify"], ["archive", "digest"],
                        ["plot"]]:
            result = sleight(*command, other)
            self.assertEqual(result.returncode, 6, (command, result.stderr))
            self.assertIn("text.h5", result.stderr)


class Results(ProgramTest):
    def test_results_on_stdout_progress_on_stderr(self):
        request = self.write_request()
        result = self.succeed(sleight("direct", request, "-o", self.path("a.h5"), "--json"))
        summary = json.loads(result.stdout)
        self.assertEqual(summary["scans"], 1000)
        self.assertEqual(summary["end"], "finished")
        self.assertEqual(summary["digest"], self.digest(self.path("a.h5")))

    def test_check_prints_a_request_that_reads_the_same(self):
        request = self.write_request()
        first = self.succeed(sleight("check", request)).stdout
        again = self.path("again.toml")
        again.write_text(first)
        self.assertEqual(self.succeed(sleight("check", again)).stdout, first)

    def test_the_archive_carries_the_request_that_reproduces_it(self):
        self.direct(self.write_request(), self.path("a.h5"), "--seed", "99")
        stored = self.path("stored.toml")
        stored.write_text(self.info(self.path("a.h5"))["request"])
        self.direct(stored, self.path("b.h5"))
        self.assertEqual(self.path("a.h5").read_bytes(), self.path("b.h5").read_bytes())

    def test_export_has_a_row_for_every_draw(self):
        self.direct(self.write_request(), self.path("a.h5"))
        for table in ["sample_stats", "posterior"]:
            text = self.succeed(sleight("archive", "export", self.path("a.h5"), "--csv",
                                        "--table", table)).stdout
            self.assertEqual(len(text.splitlines()), 1 + 4 * 1000, table)
        to_file = self.path("animations.csv")
        self.succeed(sleight("archive", "export", self.path("a.h5"), "--csv", "--table",
                             "animations", "-o", to_file))
        self.assertEqual(len(to_file.read_text().splitlines()),
                         1 + self.info(self.path("a.h5"))["animations"])

    def test_plots(self):
        self.direct(self.write_request(), self.path("a.h5"))
        for what in ["trace", "paths"]:
            for ending, head in [("svg", b"<"), ("png", b"\x89PNG")]:
                picture = self.path(f"{what}.{ending}")
                self.succeed(sleight("plot", self.path("a.h5"), "--what", what, "-o", picture))
                self.assertTrue(picture.read_bytes().startswith(head))
        self.assertIn("landing", self.succeed(
            sleight("plot", self.path("a.h5"))).stdout.lower().replace("lands", "landing"))
        self.assertEqual(sleight("plot", self.path("a.h5"), "--chain", "4").returncode, 2)

    def test_interrupted_run_says_so_and_goes_on(self):
        request = self.write_request(scans=300000)
        process = harness.start([harness.program("sleight"), "direct", request, "-o",
                                 self.path("a.h5")])
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, errors)
        cut = self.info(self.path("a.h5"))["scans"]
        self.assertGreater(cut, 0)
        self.assertLess(cut, 300000)
        self.direct(request, self.path("a.h5"))
        self.assertEqual(self.info(self.path("a.h5"))["scans"], 300000)

    def test_progress_on_a_terminal(self):
        # `script` gives the program a terminal; the progress line renews itself with a carriage
        # return and has rate, time left, acceptance and satisfied.
        request = self.write_request(scans=200000)
        command = (f"{harness.program('sleight')} direct {request} -o {self.path('a.h5')}"
                   " --time-limit 2s")
        result = subprocess.run(["script", "-qec", command, "/dev/null"], capture_output=True,
                                env=harness.environment(), timeout=120)
        self.assertEqual(result.returncode, 0, result.stdout)
        # As bytes: Python would take the carriage returns for line ends.
        self.assertRegex(result.stdout.decode(), r"\rball_2d  [\d,]+ of 800,000 scans \(\d+%\)  [\d,]+/s  "
                                        r"\d+:\d\d left  accepted \d+%  satisfied [\d,]+")


if __name__ == "__main__":
    harness.main()
