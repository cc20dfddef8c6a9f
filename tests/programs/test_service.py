"""Goal: people's tasks with the service work with real programs, and have the results of runs by hand:
submit, watch, wait, fetch, cancel, resume, extend, delete. A daemon that is killed or replaced loses nothing.
Method: run a daemon in its own folder and the commands of `sleight`, and compare digests with `sleight
direct`."""

import contextlib
import json
import shutil
import subprocess
import signal
import sqlite3
import time

import h5py
import harness
from harness import sleight
from service_harness import ServiceTest


class Service(ServiceTest):
    def test_a_job_from_submit_to_delete(self):
        self.serve()
        request = self.write_request(chains=2, scans=3000)
        number = self.submit(request, "--name", "first")
        self.wait(number)
        job = self.job(number)
        self.assertEqual((job["state"], job["name"], job["world"]), ("done", "first", "ball_2d"))
        digest = self.quiet_digest(request)
        self.assertEqual(job["digest"], digest)
        archive = self.path("fetched.h5")
        self.succeed(self.ask("fetch", number, "-o", archive))
        self.assertEqual(self.digest(archive), digest)
        history = [change["state"] for change in self.ask_json("status", number, "--history")["history"]]
        self.assertEqual(history, ["queued", "starting", "running", "done"])
        # Events are numbered from 1 without a gap, and the last one is the end.
        events = [json.loads(line) for line in
                  self.succeed(self.ask("watch", number, "--json")).stdout.splitlines()]
        numbers = [event["number"] for event in events if event["number"] > 0]
        self.assertEqual(numbers, list(range(1, len(numbers) + 1)))
        self.assertEqual([e["kind"] for e in events if e["number"] > 0][-1], "ended")
        self.succeed(self.ask("delete", number, "-y"))
        self.until(lambda: not self.folder_of(number).exists())
        gone = self.ask("status", number)
        self.assertEqual(gone.returncode, 2, gone.stderr)
        self.succeed(self.ask("server", "stop"))
        self.assertEqual(self.daemon.wait(timeout=30), 0)

    def test_cancel_resume_and_extend(self):
        self.serve()
        request = self.write_request(chains=2, scans=30_000, iterations_per_scan=400)
        number = self.submit(request, "--cores", 1)
        self.until_running(number)
        self.succeed(self.ask("cancel", number))
        self.wait(number, 11)
        self.succeed(self.ask("resume", number))
        self.until(lambda: self.job(number)["state"] == "running")
        self.succeed(self.ask("hold", number))
        self.until(lambda: self.job(number)["state"] == "held")
        so_far = self.path("so_far.h5")
        self.succeed(self.ask("fetch", number, "--so-far", "-o", so_far))
        scans = self.info(so_far)["scans"]
        exact = self.write_request("exact.toml", chains=2, scans=scans, iterations_per_scan=400)
        with h5py.File(so_far) as archive:
            draws = archive["prior/draw"].size if "prior" in archive else 0
        self.assertEqual(self.digest(so_far),
                         self.quiet_digest(exact, "--set", f"output.prior_draws={draws}"))
        self.succeed(self.ask("cancel", number))
        # An extended run equals the longer run.
        short = self.submit(self.write_request("short.toml", chains=2, scans=500))
        self.wait(short)
        self.succeed(self.ask("extend", short, "--scans", 900))
        self.wait(short)
        longer = self.write_request("longer.toml", chains=2, scans=900)
        self.assertEqual(self.job(short)["digest"], self.quiet_digest(longer))
        refused = self.ask("extend", short, "--scans", 900)
        self.assertNotEqual(refused.returncode, 0)

    def test_recordings_by_their_ids(self):
        """Goal: requested recordings, and only these, equal the archive's. Method: compare with the archive's
        own export; request unknown ids."""
        self.serve()
        number = self.submit(self.write_request(chains=2, scans=500))
        self.wait(number)
        self.succeed(self.ask("fetch", number, "--recordings", "0,2", "-o", self.path("few")))
        few, = self.path("few").iterdir()
        self.assertEqual(few.name, f"job-{number}-recordings.csv")
        of_two = [arg for at in (0, 2) for arg in ("--animation", at)]
        by_hand = self.succeed(sleight("archive", "export", self.folder_of(number) / "out.h5", "--csv",
                                       "--table", "segments", *of_two))
        self.assertEqual(few.read_text(), by_hand.stdout)
        self.assertGreater(len(by_hand.stdout.splitlines()), 4)
        refused = self.ask("fetch", number, "--recordings", "1000000", "-o", self.path("none"))
        self.assertNotEqual(refused.returncode, 0)
        self.assertEqual(self.ask("fetch", number, "--recordings", "3..", "-o", self.path("none")).returncode, 2)
        self.assertFalse(self.path("none").exists() and any(self.path("none").iterdir()))

    def test_copies_of_a_run_that_goes_on_are_few(self):
        """Goal: a client that follows a run by its archives so far doesn't fill the service's disk. Method:
        request archives of a running job, each longer than the last, and count the copies that the service
        holds."""
        self.serve()
        number = self.submit(self.write_request(chains=2, scans=30_000_000, iterations_per_scan=400))
        self.until_running(number)
        scans = set()

        def fetched_longer():
            path = self.path(f"{len(scans)}.h5")
            path.unlink(missing_ok=True)
            self.succeed(self.ask("fetch", number, "--so-far", "-o", path))
            scans.add(self.info(path)["scans"])
            return len(scans) == 4

        self.until(fetched_longer)
        held = list((self.state / "fetched").iterdir())
        self.assertEqual(len(held), 2, held)
        self.succeed(self.ask("cancel", number))

    def test_what_the_disk_damaged_is_refused(self):
        """Goal: a damaged archive, another job's archive and a damaged run are refused. Method: change bytes
        of each on the daemon's disk, and put an archive of another seed in its place."""
        self.serve()
        number = self.submit(self.write_request(chains=1, scans=400))
        self.wait(number)
        archive = self.folder_of(number) / "out.h5"
        content = bytearray(archive.read_bytes())
        for at in range(len(content) // 3, len(content) // 3 + 2000):
            content[at] ^= 0x55
        archive.write_bytes(content)
        here = self.path("here.h5")
        refused = self.ask("fetch", number, "-o", here)
        self.assertEqual(refused.returncode, 6, refused.stderr)
        self.assertIn("--so-far", refused.stderr)
        self.assertFalse(here.exists())
        self.direct(self.write_request("other.toml", chains=1, scans=400), self.path("other.h5"),
                    "--seed", 7)
        archive.write_bytes(self.path("other.h5").read_bytes())
        refused = self.ask("fetch", number, "-o", here)
        self.assertEqual(refused.returncode, 6, refused.stderr)
        self.assertIn("digest is " + self.digest(self.path("other.h5")), refused.stderr)
        self.assertFalse(here.exists())
        self.succeed(self.ask("fetch", number, "--so-far", "-o", here))
        self.assertEqual(self.digest(here), self.job(number)["digest"])
        starts = self.job(number)["starts"]
        (archive.parent / "out.h5.run" / "store.sqlite").write_bytes(b"garbage" * 1000)
        self.succeed(self.ask("extend", number, "--scans", 500))
        self.wait(number, 10)
        self.assertEqual(self.job(number)["starts"], starts + 1)
        self.assertIn("damaged", self.job(number)["end_words"])

    def test_a_reader_that_goes_ends_a_watch(self):
        """Goal: `sleight watch 1 | head -1` ends even if nothing more is written. Method: close the pipe's
        other end while the job waits for cores."""
        self.serve("--disk-reserve", "8000TB")
        number = self.submit(self.write_request(chains=1, scans=100))
        for command in [["watch", number], ["watch", number, "--json"], ["wait", number]]:
            watcher = subprocess.Popen([harness.program("sleight"), *map(str, command)],
                                       stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                       env={**harness.environment(), **self.environment()})
            time.sleep(0.3)
            self.assertIsNone(watcher.poll())
            watcher.stdout.close()
            self.assertEqual(watcher.wait(timeout=30), -signal.SIGPIPE)

    def test_folders_that_somebody_deleted(self):
        """Goal: a job whose folder is deleted begins again and reports that. After a deleted job store, no
        new job uses an old folder. Without its socket, a server can be stopped."""
        self.serve()
        request = self.write_request(chains=2, scans=20_000, iterations_per_scan=250)
        number = self.submit(request)
        self.until_running(number)
        # The run may create or remove a file during the deletion.
        while self.folder_of(number).exists():
            try:
                shutil.rmtree(self.folder_of(number))
                break
            except OSError:
                pass
        self.until(lambda: self.job(number)["starts"] == 2, 30)
        history = self.ask_json("status", number, "--history")["history"]
        self.assertIn("folder was deleted", str(history))
        self.wait(number)
        self.assertEqual(self.job(number)["digest"], self.quiet_digest(request))
        shutil.rmtree(self.folder_of(number))
        self.assertNotEqual(self.ask("fetch", number, "-o", self.path("gone.h5")).returncode, 0)
        self.submit(self.write_request("second.toml", chains=1, scans=100))
        self.wait(2)
        (self.state / "socket").unlink()
        stopped = self.succeed(self.ask("server", "stop", "--json"))
        self.assertEqual(json.loads(stopped.stdout), {"pid": self.daemon.pid, "stopped": True})
        self.daemon.wait(timeout=30)
        # A clean stop leaves all jobs in jobs.sqlite, so that a copy of this file is enough.
        alone = shutil.copy(self.state / "jobs.sqlite", self.path("alone.sqlite"))
        with contextlib.closing(sqlite3.connect(alone)) as store:
            self.assertEqual(store.execute("SELECT count(*) FROM job").fetchone(), (2,))
        for store in self.state.glob("jobs.sqlite*"):
            store.unlink()
        self.serve()
        self.assertIn("missing from the job store", self.path("sleightd.log").read_text())
        third = self.submit(self.write_request("third.toml", chains=1, scans=50))
        self.assertEqual(third, 3)
        self.wait(third)
        self.assertEqual(self.job(third)["scans_done"], 50)

    def test_one_daemon_a_folder(self):
        self.serve()
        second = subprocess.run([harness.program("sleightd")], capture_output=True, text=True,
                                env={**harness.environment(), **self.environment()}, timeout=30)
        self.assertEqual(second.returncode, 4, second.stderr)
        self.assertIn(str(self.daemon.pid), second.stderr)

    def test_a_changed_or_newer_job_store_is_refused_and_kept(self):
        self.serve()
        number = self.submit(self.write_request(chains=1, scans=200))
        self.wait(number)
        self.kill_daemon()
        store = self.state / "jobs.sqlite"
        with sqlite3.connect(store) as database:
            database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            database.execute("UPDATE job SET record = replace(record, 'done', 'dome')")
        self.refuses_to_begin("wrong checksum", 5)
        with sqlite3.connect(store) as database:
            database.execute("UPDATE job SET record = replace(record, 'dome', 'done')")
        self.serve()
        self.assertEqual(self.job(number)["state"], "done")
        self.kill_daemon()
        with sqlite3.connect(store) as database:
            kept = database.execute("SELECT value, checksum FROM state WHERE key='format'").fetchone()
            database.execute("UPDATE state SET value = '99' WHERE key='format'")
        self.refuses_to_begin("format", 5)
        with sqlite3.connect(store) as database:
            database.execute("UPDATE state SET value = ? WHERE key='format'", (kept[0],))
        self.serve()
        self.assertEqual(self.job(number)["state"], "done")
        self.kill_daemon()
        store.write_bytes(b"garbage" * 1000)
        self.refuses_to_begin("the job store is damaged", 5)

    def refuses_to_begin(self, words, code):
        result = subprocess.run([harness.program("sleightd")], capture_output=True, text=True,
                                env={**harness.environment(), **self.environment()}, timeout=30)
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertIn(words, result.stderr)

    def test_a_search_that_finds_nothing_fails_and_is_not_started_again(self):
        self.serve()
        # A ball falls for 0.12 s, so none is at rest 0.01 s after its drop.
        request = self.path("hopeless.toml")
        request.write_text("""
[world]
name = "spelling"
word = "HI"
time_limit_s = 0.01
[sampler]
method = "search"
[stop]
found = 1
""")
        number = self.submit(request)
        self.wait(number, 10)
        job = self.job(number)
        self.assertEqual((job["starts"], job["found"]), (1, 0))


if __name__ == "__main__":
    harness.main()
