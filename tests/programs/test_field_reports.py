"""Goal: mistakes stay fixed that we found in our programs because of public bug reports about other software:
names that look like numbers, links, file modes, commands that need no service, cores, memory, standard input,
dumb terminals. Method: run each report's smallest input, and similar inputs, on the real programs."""

import csv
import io
import json
import os
import pty
import subprocess

import harness
from harness import MPIRUN, ProgramTest, program, run, sleight
from test_export import BALL

# A chain with finds at draws 3, 11 and 30.
REQUEST = BALL.replace("seed = 1", "seed = 3")
# Enough address space to begin with, and too little to continue, in kB.
SHORT_OF_MEMORY_KB = [115_000, 125_000, 135_000, 150_000]


class FieldReports(ProgramTest):
    @classmethod
    def setUpClass(cls):
        cls.kept = ProgramTest()
        cls.kept.setUp()
        cls.addClassCleanup(cls.kept.doCleanups)
        cls.request = cls.kept.path("ball.toml")
        cls.request.write_text(REQUEST)
        cls.archive = cls.kept.path("ball.h5")
        cls.kept.direct(cls.request, cls.archive)

    def failed(self, code, words, result):
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertIn(words, result.stderr)

    def test_no_reader_takes_an_id_for_a_number(self):
        table = self.succeed(sleight("export", self.archive, "--format", "csv", "--all")).stdout
        ids = [row["id"] for row in csv.DictReader(io.StringIO(table))]
        for name in ids:
            with self.assertRaises(ValueError, msg=name):
                float(name)
        # The old form of ids: 0.3 could have been 0.30.
        named = lambda name: sleight("export", self.archive, "--ids", name, "--format", "csv")
        self.assertLessEqual({"c0.3", "c0.30", "c0.11"}, set(ids))
        for old in ["0.11", "0.30"]:
            self.assertIn(f"\nc{old},", self.succeed(named(old)).stdout)
        lost = named("0.3")
        self.assertEqual(lost.returncode, 2, lost.stderr)
        self.assertRegex(lost.stderr, r"'0\.3'.*\bc0\.3 .*\bc0\.30\b")

    def test_a_link_stays_and_its_target_is_written(self):
        self.path("real").mkdir()
        outputs = [("a.h5", ["direct", self.request, "-q", "-o"]),
                   ("b.h5", ["archive", "derive", f"{self.archive}.run", "-o"]),
                   ("c.csv", ["archive", "export", self.archive, "--csv", "-o"]),
                   ("d.csv", ["export", self.archive, "--all", "-o"]),
                   ("e.glb", ["export", self.archive, "--ids", "c0.11", "-o"]),
                   ("f.svg", ["export", self.archive, "--ids", "c0.11", "-o"]),
                   ("g.svg", ["plot", self.archive, "-o"]),
                   ("h.svg", ["groups", self.archive, "-k", "3", "-o"]),
                   ("frames", ["export", self.archive, "--ids", "c0.11", "--format", "png", "--fps",
                               "2", "-o"]),
                   ("gallery", ["gallery", self.archive, "--save"])]
        for name, command in outputs:
            with self.subTest(name):
                link, target = self.path(name), self.path("real") / name
                link.symlink_to(f"real/{name}")
                # The file is missing at first, then appears.
                for _ in range(2):
                    again = ["--force"] if name in ("d.csv", "f.svg") and target.exists() else []
                    if name == "frames" and target.exists():
                        break
                    self.succeed(sleight(*command, link, *again))
                    self.assertTrue(link.is_symlink())
                    self.assertTrue(target.exists() and not target.is_symlink())
        self.assertTrue(self.path("real/a.h5.run").is_dir())
        self.assertEqual({path.name for path in self.folder.iterdir()},
                         {"real", *(name for name, _ in outputs)})
        # One file each in a folder.
        into = self.path("into")
        into.mkdir()
        self.succeed(sleight("export", self.archive, "--ids", "c0.11", "-o", into))
        model, = into.iterdir()
        model.rename(self.path("real/model.glb"))
        model.symlink_to("../real/model.glb")
        self.succeed(sleight("export", self.archive, "--ids", "c0.11", "-o", into))
        self.assertTrue(model.is_symlink())

    def test_files_of_a_group(self):
        self.succeed(sleight("direct", self.request, "-q", "-o", self.path("a.h5"), umask=0o002))
        files = [self.path("a.h5"), self.path("a.h5.run"), *self.path("a.h5.run").rglob("*")]
        self.assertIn("store.sqlite", {path.name for path in files})
        self.assertIn("motions.sqlite", {path.name for path in files})
        for path in files:
            self.assertEqual(path.stat().st_mode & 0o777, 0o775 if path.is_dir() else 0o664, path)

    def test_local_commands_need_no_service(self):
        command = [program("sleight"), "gallery", self.archive, "--save"]
        bad = self.path("config/sleight")
        bad.mkdir(parents=True)
        (bad / "config.toml").write_text("nonsense = 1\n")
        for i, env in enumerate([{}, {"HOME": str(self.folder), "SLEIGHT_SOCKET": "relative/x"},
                                 {"HOME": str(self.folder), "XDG_CONFIG_HOME": str(bad.parent)}]):
            result = subprocess.run([*command, self.path(f"g{i}")], env=env, capture_output=True, text=True)
            self.succeed(result)
            # A job does.
            result = subprocess.run([program("sleight"), "gallery", "17", "--save", self.path("j")], env=env,
                                    capture_output=True, text=True)
            self.assertEqual(result.returncode, 2, result.stderr)

    def test_as_many_threads_as_cores(self):
        core = str(min(os.sched_getaffinity(0)))
        told = self.succeed(run(["taskset", "-c", core, program("sleight"), "direct", self.request, "-q",
                                 "--json", "-o", self.path("a.h5")])).stdout
        self.assertEqual(json.loads(told)["workers"], 1)

    def test_too_little_memory_is_told_as_that(self):
        refused = 0
        for kb in SHORT_OF_MEMORY_KB:
            for command in (f"plot '{self.archive}' -o x.png", f"export '{self.archive}' --all --together -o x.glb",
                            f"direct '{self.request}' -q -o m.h5"):
                result = run(["bash", "-c", f"ulimit -v {kb}; '{program('sleight')}' {command}"], cwd=self.folder)
                # Before main begins, the dynamic loader prints.
                if "error while loading shared libraries" in result.stderr: continue
                with self.subTest(command, kb=kb):
                    self.assertIn(result.returncode, (0, 5), result.stderr)
                    if result.returncode == 5: self.assertIn("memory", result.stderr)
                    refused += result.returncode == 5
        self.assertGreater(refused, 0)

    def test_requests_from_standard_input(self):
        digest = self.digest(self.archive)
        text = REQUEST.encode()
        given = lambda command: subprocess.run([str(part) for part in command], input=text, capture_output=True,
                                               env=harness.environment())
        for number, name in enumerate(["-", "/dev/stdin"]):
            output = self.path(f"a{number}.h5")
            result = given([*MPIRUN, "-n", "2", program("sleight-batch"), name, "-o", output])
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(self.digest(output), digest)
        output = self.path("b.h5")
        self.assertEqual(given([program("sleight"), "direct", "-", "-q", "-o", output]).returncode, 0)
        self.assertEqual(self.digest(output), digest)
        checked = given([program("sleight"), "check", "-"])
        self.assertIn(b"[world]", checked.stdout)
        text = b"nonsense"
        wrong = given([*MPIRUN, "-n", "2", program("sleight-batch"), "-", "-o", self.path("c.h5")])
        self.assertEqual(wrong.returncode, 3)
        self.assertEqual(wrong.stderr.count(b"standard input:1:"), 1, wrong.stderr)

    def on_a_terminal(self, term):
        """Output of `direct` on a terminal of this kind."""
        pid, terminal = pty.fork()
        if pid == 0:
            os.execve(program("sleight"), [program("sleight"), "direct", str(self.request), "--set",
                                           "stop.scans=3000", "-o", str(self.path(f"{term}.h5"))],
                      {**harness.environment(), "TERM": term})
        text = b""
        try:
            while piece := os.read(terminal, 65536):
                text += piece
        except OSError:
            pass  # the other end is closed
        os.waitpid(pid, 0)
        os.close(terminal)
        return text

    def test_terminals_without_escapes_get_none(self):
        self.assertIn(b"\x1b[K", self.on_a_terminal("xterm"))
        plain = self.on_a_terminal("dumb")
        self.assertIn(b"of 3,000 scans", plain)
        self.assertNotIn(b"\x1b", plain)

    def test_what_goes_to_standard_output(self):
        self.failed(2, "name a file or folder", sleight("export", self.archive, "--all", "-o", "-", cwd=self.folder))
        self.failed(2, "name a file or folder", sleight("direct", self.request, "-o", "-", cwd=self.folder))
        table = self.succeed(sleight("export", self.archive, "--all", "--format", "csv", "-o", "-",
                                     cwd=self.folder)).stdout
        self.assertTrue(table.startswith("id,"))
        self.assertEqual(list(self.folder.iterdir()), [])
        for command in (["export", self.archive, "--all", "--format", "csv"], ["find", self.archive],
                        ["archive", "export", self.archive, "--csv"], ["keys", "dice"]):
            with open("/dev/full", "w", encoding="ascii") as full:
                result = subprocess.run([program("sleight"), *map(str, command)], stdout=full,
                                        stderr=subprocess.PIPE, text=True)
            self.failed(5, "No space left on device", result)

    def test_archives_of_odds_are_browsed(self):
        # The diagnosis is omitted, because it has nothing to report.
        request = self.path("odds.toml")
        request.write_text('[world]\nname = "spelling"\nbitmap = "#."\n[stop]\nodds = 0.5\n')
        self.direct(request, self.path("odds.h5"))
        self.succeed(sleight("gallery", self.path("odds.h5"), "--save", self.path("g")))


if __name__ == "__main__":
    harness.main()
