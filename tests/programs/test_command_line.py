"""Goal: the command line behaves as people expect. Method: run real processes and check their output, its
stream, and their exit codes."""

import json
import os
import re
import subprocess

import h5py
import harness
from harness import ProgramTest, sleight

COMMANDS = [["direct"], ["check"], ["keys"], ["archive"], ["archive", "info"],
            ["archive", "digest"], ["archive", "verify"], ["archive", "export"],
            ["archive", "derive"], ["diagnose"],
            ["plot"], ["config"], ["completion"], ["man"]]


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
                               r"|src\.[0-9a-f]{12})\nresults [0-9a-f]{16}\n$")


class Usage(ProgramTest):
    def test_wrong_usage_is_code_2(self):
        request = self.write_request()
        for wrong in [[], ["nonsense"], ["direct"], ["direct", request],
                      ["direct", request, "-o", self.path("a.h5"), "--threads", "0"],
                      ["direct", request, "-o", self.path("a.h5"), "--time-limit", "soon"],
                      ["direct", request, "-o", self.path("a.h5"), "--seed", "-1"],
                      ["direct", request, "-o", self.path("a.h5"), "--seed", "010"],
                      ["direct", request, "-o", self.path("a.h5"), "--seed", "0x10"],
                      ["keys", "no_such_world"], ["plot", self.path("a.h5"), "--what", "smoke"]]:
            result = sleight(*wrong)
            self.assertEqual(result.returncode, 2, (wrong, result.stderr))
            self.assertEqual(result.stdout, "", wrong)
        self.assertIn("'lst'; did you mean 'list'?", sleight("lst").stderr)
        self.assertIn("'--wat'", sleight("--wat").stderr)

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
                        ["diagnose"], ["plot"]]:
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

    def test_the_archive_carries_the_request_that_reproduces_it(self):
        self.direct(self.write_request(), self.path("a.h5"), "--seed", "99")
        stored = self.path("stored.toml")
        stored.write_text(self.info(self.path("a.h5"))["request"])
        self.direct(stored, self.path("b.h5"))
        self.assertEqual(self.path("a.h5").read_bytes(), self.path("b.h5").read_bytes())

    def test_plots(self):
        self.direct(self.write_request(), self.path("a.h5"))
        for what in ["trace", "paths", "animations"]:
            for ending, head in [("svg", b"<"), ("png", b"\x89PNG")]:
                picture = self.path(f"{what}.{ending}")
                self.succeed(sleight("plot", self.path("a.h5"), "--what", what, "-o", picture))
                self.assertTrue(picture.read_bytes().startswith(head))
        self.assertEqual(sleight("plot", self.path("a.h5"), "--chain", "4").returncode, 2)

    def test_progress_on_a_terminal(self):
        # `script` gives the program a terminal. The progress line rewrites itself with a carriage return and
        # has time left, rate and solutions within 80 columns.
        request = self.write_request(scans=200000)
        command = (f"{harness.program('sleight')} direct {request} -o {self.path('a.h5')}"
                   " --time-limit 2s")
        result = subprocess.run(["script", "-qec", command, "/dev/null"], capture_output=True,
                                env=harness.environment(), timeout=120)
        self.assertEqual(result.returncode, 0, result.stdout)
        # As bytes, because Python would treat carriage returns as line ends.
        self.assertRegex(result.stdout.decode(), r"\rball_2d  [\d,]+ of 800,000 scans \(\d+%\)  "
                                        r"\d+:\d\d left  [\d,]+ sims/s  solutions \d+")


class Output(ProgramTest):
    """Results that can't be written are never reported as success."""

    def setUp(self):
        super().setUp()
        self.archive = self.path("a.h5")
        self.direct(self.write_request(), self.archive)

    def test_a_full_or_closed_stdout_is_code_5(self):
        a = self.archive
        for command in [["archive", "info", a], ["archive", "info", a, "--json"],
                        ["archive", "digest", a], ["archive", "verify", a],
                        ["archive", "export", a, "--csv"],
                        ["archive", "export", a, "--csv", "--table", "animations"],
                        ["check", self.path("request.toml")], ["keys"], ["keys", "ball_2d"],
                        ["plot", a], ["plot", a, "-o", self.path("a.svg")], ["--help"],
                        ["--version"],
                        ["direct", self.path("request.toml"), "-o", a, "-q", "--json"]]:
            line = " ".join(str(part) for part in [harness.program("sleight"), *command])
            for to in [">/dev/full", ">&-"]:
                result = harness.run(["sh", "-c", f"{line} {to}"])
                self.assertEqual(result.returncode, 5, (line, to, result.stderr))
            self.succeed(harness.run(["sh", "-c", f"{line} <&- >/dev/null"]))

    def export(self, output, *args):
        return sleight("archive", "export", self.archive, "--csv", "-o", output, *args)

    def test_an_export_never_replaces_its_archive(self):
        before = self.archive.read_bytes()
        self.path("soft.h5").symlink_to(self.archive)
        os.link(self.archive, self.path("hard.h5"))
        (self.folder / "below").mkdir()
        for same in [self.archive, self.path("soft.h5"), self.path("hard.h5"),
                     self.folder / "below" / ".." / "a.h5"]:
            result = self.export(same)
            self.assertEqual(result.returncode, 2, (same, result.stderr))
        self.assertEqual(self.archive.read_bytes(), before)

    def test_an_export_is_whole_or_absent(self):
        table = self.path("t.csv")
        table.write_text("old")
        self.succeed(self.export(table))
        self.assertEqual(len(table.read_text().splitlines()), 4001)
        self.assertEqual(self.export(self.path("none") / "t.csv").returncode, 5)
        full = self.export("/dev/full")
        self.assertEqual(full.returncode, 5, full.stderr)
        limited = self.path("limited.csv")
        limited.write_text("old")
        result = harness.run(["bash", "-c", "trap '' XFSZ; ulimit -f 8; exec "
                              f"{harness.program('sleight')} archive export {self.archive} --csv "
                              f"-o {limited}"])
        self.assertEqual(result.returncode, 5, result.stderr)
        self.assertEqual(limited.read_text(), "old")
        self.assertEqual(list(self.folder.glob("*.tmp.*")), [])


class Plots(ProgramTest):
    def setUp(self):
        super().setUp()
        self.archive = self.path("a.h5")
        self.direct(self.write_request(), self.archive)

    def svg(self, *args):
        self.succeed(sleight("plot", self.archive, *args, "-o", self.path("p.svg")))
        return self.path("p.svg").read_text()

    def test_numbers_are_checked(self):
        for wrong in [["--draws", "-1"], ["--draws", "0"], ["--chain", "-1"], ["--chain", "x"],
                      ["--chain", "4"], ["--chain", "4", "--what", "paths"], ["--count", "13"]]:
            result = sleight("plot", self.archive, *wrong)
            self.assertEqual(result.returncode, 2, (wrong, result.stderr))

    def test_paths_of_one_chain(self):
        with h5py.File(self.archive) as file:
            kept = set(file["animations/chain"][:])
        chain = max(kept)
        drawn = set(re.findall(r"chain (\d+), draw", self.svg("--what", "paths", "--chain",
                                                              str(chain))))
        self.assertEqual(drawn, {str(chain)})


class Damage(ProgramTest):
    """Numbers and texts of a hostile archive are refused by name, and never crash a program."""

    def setUp(self):
        super().setUp()
        self.direct(self.write_request(), self.path("whole.h5"))

    def refused(self, damage, *command):
        archive = self.path("damaged.h5")
        archive.write_bytes(self.path("whole.h5").read_bytes())
        with h5py.File(archive, "r+") as file:
            damage(file)
        result = sleight(*command[:2], archive, *command[2:]) if command[0] == "archive" else \
            sleight(command[0], archive, *command[1:])
        self.assertEqual(result.returncode, 6, result.stderr)
        self.assertNotIn("crashed", result.stderr)
        self.assertNotIn("\x1b", result.stderr + result.stdout)
        return result.stderr

    def test_segments_outside_the_table(self):
        for dataset, value in [("segment_start", -1), ("segment_start", 1 << 62),
                               ("segment_start", -(1 << 63)), ("segment_count", -5),
                               ("segment_count", (1 << 63) - 1), ("segment_count", 100000)]:
            def damage(file):
                file["animations"][dataset][:] = value
            self.assertRegex(self.refused(damage, "plot", "--what", "paths"), r"animation 0\b.* segment\b")


if __name__ == "__main__":
    harness.main()
