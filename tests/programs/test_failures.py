"""Goal: a failing simulation is never a sample and is always reported. Method: run the programs with a world
in which 3% of simulations give up, 1% exceed a limit and 2% can't start (tests/failing). Threads, ranks,
kills and sessions must not change the counts."""

import json
import math
import pathlib
import re
import sqlite3
import time

import harness
from harness import ProgramTest


def tempered_text(scans, seed=1, method="parallel_tempering"):
    return f"""
[world]
name = "ball_2d"
[sampler]
method = "{method}"
chains = 3
replicas = 4
seed = {seed}
round_scans = 32
iterations_per_scan = 3
[stop]
scans = {scans}
"""


def without_checksum(text):
    """A failure's file without its checksum, as if a person had edited it."""
    changed, count = re.subn(r"\nchecksum = .*", "", text)
    assert count == 1, text
    return changed


class Failures(ProgramTest):
    def request(self, text, name="request.toml"):
        path = self.path(name)
        path.write_text(text)
        return path

    def summary(self, request, output, *args):
        return json.loads(self.direct(request, output, "--json", *args).stdout)

    def counted(self, archive):
        return self.info(archive)["failed_simulations"]

    def same(self, output, reference):
        self.assertEqual(output.read_bytes(), reference.read_bytes())
        self.assertEqual(self.counted(output), self.counted(reference))

    def test_they_are_counted_by_kind(self):
        request = self.write_request(scans=3000, iterations_per_scan=2)
        output = self.path("a.h5")
        summary = self.summary(request, output)
        failed = summary["failed_simulations"]
        self.assertEqual(failed["total"], failed["search_gave_up"] + failed["work_limit"])
        # The share of failures of independent simulations would be binomial. A chain's candidates differ each
        # time, so their hashes are independent.
        simulations = summary["session_simulations"]
        for kind, share in [("search_gave_up", 0.03), ("work_limit", 0.01)]:
            sd = math.sqrt(simulations * share * (1 - share))
            self.assertLess(abs(failed[kind] - share * simulations), 5 * sd, (kind, failed))
        self.assertEqual(self.counted(output), failed)
        self.succeed(harness.sleight("archive", "verify", output))

    def test_threads_ranks_and_sessions_count_the_same(self):
        for name, text in [("plain", harness.request_text(scans=1500)),
                           ("tempered", tempered_text(600)),
                           ("excursions", tempered_text(700, method="tempered_transitions"))]:
            with self.subTest(name):
                request = self.request(text, f"{name}.toml")
                one = self.path(f"{name}.h5")
                self.direct(request, one, "--threads", "1")
                self.assertGreater(self.counted(one)["total"], 0)
                threads = self.path(f"{name}-threads.h5")
                self.direct(request, threads, "--threads", "3", "--cache", "0")
                self.same(threads, one)
                self.same_events(threads, one)
                ranks = self.path(f"{name}-ranks.h5")
                self.succeed(harness.run(harness.batch(3, request, ranks, "-q",
                                                       folder=self.folder)))
                self.same(ranks, one)
                kinds = {event["kind"] for event in self.same_events(ranks, one)}
                self.assertEqual(kinds, {"failure", "solution", "round_ended"})
                self.files_are_named(one)

    def files_are_named(self, output):
        """Each file belongs to a failure event that names it. A unit may have written a file for a scan that
        other chains lack, without an event yet."""
        files = {str(path) for path in pathlib.Path(f"{output}.run/failures").glob("*.toml")}
        named = [event for event in self.events(output) if event.get("file")]
        self.assertGreater(len(named), 0)
        for event in named:
            self.assertIn(event["file"], files)
            place = f"{event['chain']}-{event['replica']}-{event['scan']}"
            self.assertRegex(pathlib.Path(event["file"]).name, rf"^failure-{place}(-\d+)?\.toml$")
            self.assertIn(f'kind = "{event["simulation"]}"',
                          pathlib.Path(event["file"]).read_text())

    def test_kills_lose_and_double_none(self):
        # Killed at moments of the work, by threads and as an MPI job, then resumed.
        text = harness.request_text(scans=12000, chains=3, iterations_per_scan=100)
        request = self.request(text)
        whole = self.path("whole.h5")
        self.direct(request, whole)
        for name, command in [
                ("direct", lambda output: [harness.program("sleight"), "direct", request, "-o",
                                           output, "-q"]),
                ("batch", lambda output: harness.batch(2, request, output, "-q",
                                                       folder=self.folder))]:
            with self.subTest(name):
                output = self.path(f"{name}.h5")
                kills = 0
                for _ in range(3):
                    stored = self.stored_scans(output)
                    process = harness.start(command(output))
                    deadline = time.monotonic() + 60
                    while (self.stored_scans(output) < stored + 500 and process.poll() is None
                           and time.monotonic() < deadline):
                        time.sleep(0.02)
                    kills += process.poll() is None
                    harness.kill_group(process)
                self.assertGreater(kills, 0)
                self.succeed(harness.run(command(output)))
                self.same(output, whole)
                self.same_events(output, whole)
                files = list(pathlib.Path(f"{output}.run/failures").glob("*.toml"))
                self.assertEqual(len(files), 10)

    def stored_scans(self, output):
        try:
            store = sqlite3.connect(f"file:{output}.run/store.sqlite?mode=ro", uri=True)
            count, = store.execute("SELECT count(*) FROM scan").fetchone()
            store.close()
            return count
        except sqlite3.OperationalError:
            return 0

    def test_starts_that_overlap_are_counted_apart(self):
        request = self.write_request(scans=3000)
        self.direct(request, self.path("a.h5"))
        store = sqlite3.connect(f"file:{self.path('a.h5')}.run/store.sqlite?mode=ro", uri=True)
        overlaps, = store.execute("SELECT sum(overlapping_starts) FROM scan").fetchone()
        store.close()
        self.assertLess(abs(overlaps - 240), 5 * math.sqrt(240))
        self.assertNotIn("overlap", json.dumps(self.counted(self.path("a.h5"))))

    def test_the_first_is_said_at_once_and_can_be_repeated(self):
        request = self.write_request(scans=2000)
        result = harness.sleight("direct", request, "-o", self.path("a.h5"))
        self.succeed(result)
        self.assertEqual(result.stderr.count("a simulation failed"), 1, result.stderr)
        path = re.search(r"sleight replay (\S+)", result.stderr).group(1)
        replayed = harness.sleight("replay", path)
        self.assertEqual(replayed.returncode, 8, replayed.stderr)
        told = json.loads(harness.sleight("replay", path, "--json").stdout)
        self.assertTrue(told["same"])
        # Ten files for any number of failures. Each file repeats one failure.
        files = sorted(pathlib.Path(path).parent.glob("*.toml"))
        self.assertEqual(len(files), 10)
        for file in files:
            self.assertEqual(harness.sleight("replay", file).returncode, 8, file)
        # A later session prints no replay command.
        later = self.succeed(harness.sleight("direct", self.write_request("later.toml", scans=3000),
                                             "-o", self.path("a.h5")))
        self.assertNotIn("sleight replay", later.stdout + later.stderr)
        # A file with a state that doesn't fail is simulated without a failure.
        text = without_checksum(files[0].read_text())
        state = re.search(r'state = "([0-9a-f]+)"', text).group(1)
        moved = self.request(text.replace(state, "0" * len(state)), "moved.toml")
        carried_out = harness.sleight("replay", moved)
        self.assertEqual(carried_out.returncode, 0, carried_out.stderr)

    def test_bad_files_are_refused(self):
        request = self.write_request(scans=300)
        self.direct(request, self.path("a.h5"))
        good = sorted(pathlib.Path(f"{self.path('a.h5')}.run/failures").glob("*.toml"))[0]
        whole = good.read_text()
        text = without_checksum(whole)
        for name, bad, expected in [
                ("changed", whole.replace("\nscan = ", "\nscan = 1"),
                 r"bad\.toml:\d+:\d+: .*changed"),
                ("short state", re.sub(r'state = "\w+"', 'state = "00"', text),
                 r"'state' .*'ball_2d'"),
                ("world", text.replace('name = "ball_2d"', 'name = "marbles"'), "marbles")]:
            with self.subTest(name):
                result = harness.sleight("replay", self.request(bad, "bad.toml"))
                self.assertEqual(result.returncode, 3, result.stderr)
                self.assertRegex(result.stderr, expected)
        self.assertEqual(harness.sleight("replay", self.path("none.toml")).returncode, 5)

    def test_strict_ends_the_run(self):
        request = self.write_request(scans=100000)
        output = self.path("a.h5")
        result = harness.sleight("direct", request, "-o", output, "--strict", "--json")
        self.assertEqual(result.returncode, 8, result.stderr)
        summary = json.loads(result.stdout)
        self.assertEqual(summary["end"], "simulation_failed")
        self.assertLess(summary["scans"], 100000)
        # The stored run ends the same way again. Without --strict, it resumes to its full result.
        self.assertEqual(harness.sleight("direct", request, "-o", output, "--strict").returncode, 8)
        short = self.write_request(scans=1000)
        self.direct(short, output)
        whole = self.path("whole.h5")
        self.direct(short, whole)
        self.same(output, whole)
        batch = harness.run(harness.batch(2, request, self.path("b.h5"), "--strict",
                                          folder=self.folder))
        self.assertEqual(batch.returncode, 8, batch.stderr)

    def test_fresh_gives_the_files_up(self):
        request = self.write_request(scans=1000)
        output = self.path("a.h5")
        self.direct(request, output)
        folder = pathlib.Path(f"{output}.run/failures")
        before = {file.name for file in folder.glob("*.toml")}
        self.direct(self.write_request("other.toml", scans=1000, seed=2), output, "--fresh")
        self.assertNotEqual({file.name for file in folder.glob("*.toml")}, before)


if __name__ == "__main__":
    harness.main()
