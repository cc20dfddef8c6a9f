"""Goal: no output is ever lost to another run. Method: real runs whose outputs
collide, disks that fill up, stores that are damaged."""

import os
import resource
import shutil
import signal
import sqlite3
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

    def test_another_thinning_is_another_run(self):
        output = self.path("a.h5")
        self.direct(self.write_request(thin=10), output)
        self.refuse(sleight("direct", self.write_request("b.toml", thin=1), "-o", output),
                    "another request")

    def test_a_file_that_is_no_run_of_ours_is_not_touched(self):
        output = self.path("thesis.h5")
        output.write_text("three years of work")
        for extra in [[], ["--fresh"]]:
            self.refuse(sleight("direct", self.write_request(), "-o", output, *extra),
                        "not overwritten")
            self.assertEqual(output.read_text(), "three years of work")
        self.assertFalse(self.path("thesis.h5.run").exists())

    def test_a_foreign_file_in_the_archives_place_is_not_overwritten(self):
        output = self.path("a.h5")
        request = self.write_request()
        self.direct(request, output)
        self.direct(self.write_request("other.toml", seed=2), self.path("other.h5"))
        for foreign in [b"mine", self.path("other.h5").read_bytes()]:
            output.write_bytes(foreign)
            self.refuse(sleight("direct", request, "-o", output), "is not the archive of this run")
            self.assertEqual(output.read_bytes(), foreign)
        output.write_bytes(b"mine")
        self.refuse(sleight("direct", request, "-o", output, "--fresh"), "not overwritten")
        self.assertEqual(output.read_bytes(), b"mine")

    def test_results_without_an_identity_are_refused(self):
        output = self.path("a.h5")
        for damage in ["DELETE FROM run WHERE key='identity'", "DROP TABLE run"]:
            self.direct(self.write_request(), output, "--fresh")
            store = sqlite3.connect(self.path("a.h5.run/store.sqlite"))
            store.execute(damage)
            store.commit()
            store.close()
            result = sleight("direct", self.write_request("b.toml", seed=2), "-o", output)
            self.assertEqual(result.returncode, ENVIRONMENT, result.stderr)
            self.assertIn("--fresh", result.stderr)

    def test_results_of_another_run_are_refused(self):
        self.direct(self.write_request(), self.path("a.h5"))
        self.direct(self.write_request("b.toml", seed=2), self.path("b.h5"))
        store = sqlite3.connect(self.path("a.h5.run/store.sqlite"))
        store.execute("ATTACH ? AS other", (str(self.path("b.h5.run/store.sqlite")),))
        store.execute("DELETE FROM scan WHERE chain=1")
        store.execute("INSERT INTO scan SELECT * FROM other.scan WHERE chain=1")
        store.commit()
        store.close()
        result = sleight("direct", self.write_request(), "-o", self.path("a.h5"))
        self.assertEqual(result.returncode, ENVIRONMENT, result.stderr)
        self.assertIn("chain 1", result.stderr)

    def test_two_processes_do_not_write_one_run(self):
        request = self.write_request(scans=3000000)
        command = [harness.program("sleight"), "direct", request, "-o", self.path("a.h5")]
        first = harness.start(command)
        while not self.path("a.h5.run/store.sqlite").exists():
            time.sleep(0.05)
        time.sleep(0.3)
        self.refuse(harness.run(command), str(first.pid))
        harness.kill_group(first)

    def test_more_scans_extend_a_run_and_fewer_cut_the_archive(self):
        output = self.path("a.h5")
        self.direct(self.write_request(scans=500), output)
        self.direct(self.write_request(scans=1500), output)
        self.assertEqual(self.info(output)["scans"], 1500)
        self.direct(self.write_request(scans=700), output)
        whole = self.path("b.h5")
        self.direct(self.write_request(scans=700), whole)
        self.assertEqual(output.read_bytes(), whole.read_bytes())

    def test_a_deleted_archive_is_derived_again(self):
        output = self.path("a.h5")
        self.direct(self.write_request(), output)
        before = output.read_bytes()
        output.unlink()
        self.direct(self.write_request(), output)
        self.assertEqual(output.read_bytes(), before)

    def test_other_results_are_refused(self):
        output = self.path("a.h5")
        self.direct(self.write_request(), output)
        store = sqlite3.connect(self.path("a.h5.run/store.sqlite"))
        store.execute("UPDATE run SET value='0.0.0+gffffffffffff' WHERE key='program_version'")
        store.commit()
        # Another program of the same results goes on.
        self.direct(self.write_request(), output)
        store.execute("UPDATE run SET value='0123456789abcdef' WHERE key='results_version'")
        store.commit()
        store.close()
        self.refuse(sleight("direct", self.write_request(), "-o", output), "0123456789abcdef")

    def test_a_damaged_store_is_an_error_with_advice(self):
        output = self.path("a.h5")
        self.direct(self.write_request(), output)
        self.path("a.h5.run/store.sqlite").write_bytes(b"garbage" * 1000)
        result = sleight("direct", self.write_request(), "-o", output)
        self.assertEqual(result.returncode, ENVIRONMENT, result.stderr)
        self.assertIn("--fresh", result.stderr)
        self.direct(self.write_request(), output, "--fresh")

    def test_a_folder_that_does_not_exist_is_named(self):
        result = sleight("direct", self.write_request(), "-o", self.path("no/such/a.h5"))
        self.assertEqual(result.returncode, ENVIRONMENT, result.stderr)
        self.assertIn("no/such", result.stderr)


class FullDisk(ProgramTest):
    def limited(self, request, output, bytes_max):
        """A run whose files may not grow beyond a size: what it writes past it fails."""
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

    def test_an_old_archive_outlives_a_failed_new_one(self):
        # The store fits, the archive does not: the old archive stays as it was.
        output = self.path("a.h5")
        request = self.write_request(scans=30000)
        self.direct(request, output)
        before = output.read_bytes()
        self.direct(self.write_request(scans=60000), self.path("b.h5"))
        store = self.path("b.h5.run")
        shutil.rmtree(self.path("a.h5.run"))
        shutil.move(store, self.path("a.h5.run"))
        result = self.limited(self.write_request(scans=60000), output, len(before) // 2)
        self.assertNotEqual(result.returncode, 0)
        self.assertEqual(output.read_bytes(), before)
        self.assertEqual(sorted(p.name for p in self.folder.glob("*.tmp*")), [])

    def test_a_read_only_folder(self):
        if os.geteuid() == 0:
            self.skipTest("root may write everywhere")
        self.folder.chmod(0o500)
        result = sleight("direct", self.write_request(), "-o", self.path("a.h5"))
        self.folder.chmod(0o700)
        self.assertEqual(result.returncode, ENVIRONMENT)


if __name__ == "__main__":
    harness.main()
