"""Goal: `sleight archive derive` makes the archive that a run would have if it ended now: beside the running
job, from a copy, and from a run that has ended. If it can't, it refuses with a reason. Method: make real
runs, and compare digests with runs that requested as many scans."""

import json
import os
import pathlib
import shutil
import signal
import sqlite3
import tempfile
import time

import harness
from harness import ProgramTest, sleight


class Derive(ProgramTest):
    def derive(self, run, output):
        result = self.succeed(sleight("archive", "derive", run, "-o", output, "--json"))
        return json.loads(result.stdout)

    def run_id(self, archive):
        """The id that all archives of a run share."""
        info = json.loads(self.succeed(sleight("archive", "info", archive, "--json")).stdout)
        self.assertEqual(len(info["run_id"]), 64)
        return info["run_id"]

    def refused(self, code, words, *args):
        result = sleight("archive", "derive", *args)
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertRegex(result.stderr, words)

    def test_beside_a_running_job_and_of_a_copy(self):
        output = self.path("a.h5")
        request = self.write_request(chains=2, scans=200_000_000, iterations_per_scan=20)
        process = harness.start([harness.program("sleight"), "direct", request, "-o", output, "-q"])
        store = pathlib.Path(f"{output}.run/store.sqlite-wal")
        while not store.exists() or store.stat().st_size < 300_000:
            time.sleep(0.02)
        # The first results may belong to one chain, so that no scan is common to all.
        first = self.derive(f"{output}.run", self.path("first.h5"))
        end = time.monotonic() + 60
        while first["scans"] == 0 and time.monotonic() < end:
            first = self.derive(f"{output}.run", self.path("first.h5"))
        second = first
        while second["scans"] <= first["scans"] and time.monotonic() < end:
            time.sleep(0.3)
            second = self.derive(f"{output}.run/", self.path("second.h5"))
        self.assertFalse(second["finished"])
        self.assertGreater(first["scans"], 0)
        self.assertGreater(second["scans"], first["scans"])
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)

        for archive in [first, second]:
            self.succeed(sleight("archive", "verify", archive["archive"]))
            exact = self.path("exact.toml")
            exact.write_text(self.info(archive["archive"])["request"])
            self.direct(exact, self.path("exact.h5"), "--fresh")
            self.assertEqual(self.digest(self.path("exact.h5")), archive["digest"])
            self.assertEqual(self.digest(archive["archive"]), archive["digest"])
            self.assertEqual(self.run_id(archive["archive"]), self.run_id(output))
            self.assertEqual(self.run_id(self.path("exact.h5")), self.run_id(output))
        other = self.write_request("other.toml", chains=2, scans=10, seed=8, iterations_per_scan=20)
        self.direct(other, self.path("other.h5"))
        self.assertNotEqual(self.run_id(self.path("other.h5")), self.run_id(output))
        shutil.copytree(f"{output}.run", self.path("copy"))
        copied = self.derive(self.path("copy"), self.path("copied.h5"))
        self.assertEqual(copied["digest"], self.digest(output))
        # A run's own archive, or another archive of the same run, may be replaced.
        self.assertEqual(self.derive(self.path("copy"), self.path("first.h5")),
                         {**copied, "archive": str(self.path("first.h5"))})

    def test_its_own_output_may_be_renewed(self):
        """Derives from only finds, then from finds and draws."""
        output = self.path("hi.h5")
        run = [harness.program("sleight"), "direct", "--word", "HI", "-n", "50", "-o", output, "-q"]
        self.succeed(harness.run([*run, "--time-limit", "1s"]))
        for _ in range(2):
            self.derive(f"{output}.run", self.path("so_far.h5"))
        self.assertEqual(self.digest(self.path("so_far.h5")), self.digest(output))

    def test_a_folder_that_nobody_may_write(self):
        """A user who can only read the folder derives from a run that has ended."""
        output = self.path("a.h5")
        self.direct(self.write_request(chains=2, scans=50), output)
        as_nobody = ["setpriv", "--reuid", "65534", "--regid", "65534", "--clear-groups",
                     harness.program("sleight")]
        if os.geteuid() != 0 or harness.run([*as_nobody, "--version"]).returncode != 0:
            self.skipTest("this user can't become nobody")
        self.folder.chmod(0o755)
        place = pathlib.Path(tempfile.mkdtemp(prefix="sleight-nobody-"))
        self.addCleanup(shutil.rmtree, place, ignore_errors=True)
        place.chmod(0o777)
        made = self.succeed(harness.run([*as_nobody, "archive", "derive", f"{output}.run", "-o",
                                         place / "b.h5"]))
        self.assertIn(self.digest(output), made.stdout)

    def test_what_it_refuses(self):
        output = self.path("a.h5")
        self.direct(self.write_request(chains=2, scans=50), output)
        run = f"{output}.run"
        before = output.read_bytes()
        self.refused(5, "not the folder of a run", self.folder, "-o", self.path("b.h5"))
        self.refused(5, "not the folder of a run", self.path("none.run"), "-o", self.path("b.h5"))
        self.refused(2, "the run itself writes", run, "-o", output)
        self.path("link").symlink_to(run)
        self.refused(2, "the run itself writes", self.path("link"), "-o", output)
        self.refused(2, "file name", run, "-o", self.folder)
        self.refused(4, "run store of another output", run, "-o", f"{run}/b.h5")
        self.path("mine").write_text("mine")
        self.refused(4, "not overwritten", run, "-o", self.path("mine"))
        self.refused(5, "nowhere/b.h5: .*: No such file", run, "-o", self.path("nowhere/b.h5"))
        other = self.path("other.h5")
        self.direct(self.write_request("other.toml", chains=2, scans=50, seed=9), other)
        self.refused(4, "not overwritten", run, "-o", other)
        self.assertEqual(self.path("mine").read_text(), "mine")
        self.assertEqual(output.read_bytes(), before)
        for key, value, code, words in [("results_version", "0123456789abcdef", 4, "0123456789abcdef"),
                                        ("format_version", "4", 4, "format 4"),
                                        ("request", "[world]\nname = 3\n", 5, "can't read its request")]:
            shutil.copytree(run, self.path("changed"))
            store = sqlite3.connect(self.path("changed/store.sqlite"))
            store.execute("UPDATE run SET value=? WHERE key=?", (value, key))
            store.commit()
            store.close()
            self.refused(code, words, self.path("changed"), "-o", self.path("b.h5"))
            shutil.rmtree(self.path("changed"))
        self.assertFalse(self.path("b.h5").exists())


if __name__ == "__main__":
    harness.main()
