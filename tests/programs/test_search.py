"""Goal: searches find words at a word's cost, with any number of threads and ranks and through kills, and
finds are never presented as draws. Method: run the programs as people do."""

import json
import os
import subprocess
import time
import unittest

import h5py
import numpy
import harness
from harness import ProgramTest, kill_group, program, run, sleight, start
from test_search_odds import ODDS

SEARCH = """
[world]
name = "spelling"
word = "{word}"
[sampler]
method = "search"
seed = 3
[stop]
found = {found}
"""

ISLANDS = """
[world]
name = "spelling"
word = "I"
font = "5 rows"
[sampler]
method = "sequential"
chains = 3
particles = 16
round_scans = 4
iterations_per_scan = 2
[stop]
scans = 12
found = 3
"""

DICE = """
[world]
name = "dice"
[[world.die]]
y_mm = -40
[[world.die]]
y_mm = 40
[[constraint.place]]
die = 1
x_mm = 30
y_mm = -40
sigma_mm = 5
tolerance_mm = 10
[[constraint.face]]
die = 1
up = 6
[[constraint.face]]
die = 2
up = 1
[stop]
"""

TEMPERED = """
[world]
name = "dice"
[[constraint.face]]
up = 6
[[constraint.place]]
x_mm = 30
y_mm = 0
sigma_mm = 5
tolerance_mm = 10
[sampler]
method = "parallel_tempering"
start = "search"
seed = 2  # by which both chains have forgotten their search within five rounds
chains = 2
round_scans = 20
[stop]
rounds = 5
[output]
thin = 1
"""

class Search(ProgramTest):
    def search(self, found=4, word="HI"):
        path = self.path("search.toml")
        path.write_text(SEARCH.format(found=found, word=word))
        return path

    def test_what_is_found_spells(self):
        self.direct(self.search(), self.path("hi.h5"))
        self.succeed(sleight("archive", "verify", self.path("hi.h5")))
        with h5py.File(self.path("hi.h5")) as archive:
            finds = archive["finds"]
            self.assertEqual(finds.attrs["found"], 4)
            self.assertEqual(len(finds["start"]), 4)
            self.assertTrue((finds["filled"][:] == 16).all())
            self.assertTrue((finds["elsewhere"][:] == 0).all())
            # Plausible alone: as likely as blind throws.
            throws = finds["log_prior_of_throw"][:]
            self.assertEqual(len(throws), 100)
            spread = throws.std()
            self.assertTrue((numpy.abs(finds["log_prior"][:] - throws.mean()) < 6 * spread).all())
            # All balls end at rest.
            for first, count in zip(finds["segment_start"][:], finds["segment_count"][:]):
                ball = finds["body"][first:first + count]
                mode = finds["mode"][first:first + count]
                ends = [numpy.flatnonzero(ball == one)[-1] for one in range(16)]
                self.assertTrue((mode[ends] == 3).all())
            self.assertFalse(finds["in_proportion"][:].any())
            self.assertEqual(archive["posterior/drop_m"].size, 0)

    def test_it_is_labelled_wherever_it_appears(self):
        output = self.path("hi.h5")
        self.direct(self.search(), output)
        numbers = self.info(output)
        self.assertNotEqual(numbers["warning"], "")
        self.assertEqual((numbers["found"], numbers["scans"]), (4, 0))
        self.assertNotIn("tempering", numbers)
        judged = sleight("diagnose", output)
        self.assertEqual(judged.returncode, 2)
        trace = sleight("plot", output, "--what", "trace", "-o", self.path("trace.svg"))
        self.assertEqual(trace.returncode, 2)
        picture = self.path("hi.svg")
        self.succeed(sleight("plot", output, "--count", "2", "-o", picture))
        self.assertIn("find 1 of start", picture.read_text())
        self.assertIn("not in proportion", picture.read_text())
        table = self.succeed(sleight("archive", "export", output, "--csv", "--table", "finds"))
        self.assertEqual(len(table.stdout.splitlines()), 5)

    def test_the_same_by_threads_ranks_and_kills(self):
        request = self.search(found=100)
        straight = self.path("straight.h5")
        self.direct(request, straight, "-j", "1")
        digest = self.digest(straight)
        self.direct(request, self.path("threads.h5"), "-j", "4")
        self.assertEqual(self.digest(self.path("threads.h5")), digest)
        self.succeed(run(harness.batch(3, request, self.path("ranks.h5"), "-q")))
        self.assertEqual(self.digest(self.path("ranks.h5")), digest)
        killed = self.path("killed.h5")
        for _ in range(3):
            process = start([harness.program("sleight"), "direct", request, "-o", killed, "-q"])
            time.sleep(0.2)
            kill_group(process)
        self.direct(request, killed)
        self.assertEqual(self.digest(killed), digest)

    def test_islands_give_the_same_by_threads_and_ranks(self):
        request = self.path("islands.toml")
        request.write_text(ISLANDS)
        self.direct(request, self.path("one.h5"), "-j", "1")
        digest = self.digest(self.path("one.h5"))
        self.direct(request, self.path("four.h5"), "-j", "4")
        self.assertEqual(self.digest(self.path("four.h5")), digest)
        self.succeed(run(harness.batch(2, request, self.path("ranks.h5"), "-q")))
        self.assertEqual(self.digest(self.path("ranks.h5")), digest)
        with h5py.File(self.path("one.h5")) as archive:
            self.assertEqual(archive["tempering/island_log_z"].shape, (3, 33))
            self.assertEqual(archive["posterior/draw"].size, 8)
            self.assertEqual(archive["finds/start"].size, 3)

    def test_tours_give_the_same_by_threads_ranks_and_kills(self):
        request = self.path("tours.toml")
        request.write_text(ISLANDS.replace("round_scans = 4", "tour_scans = 4").replace(
            "scans = 12", "independent_solutions = 7"))
        one = self.path("one.h5")
        self.direct(request, one, "-j", "1")
        self.direct(request, self.path("four.h5"), "-j", "4")
        self.assertEqual(self.digest(self.path("four.h5")), self.digest(one))
        self.succeed(run(harness.batch(2, request, self.path("ranks.h5"), "-q")))
        self.assertEqual(self.digest(self.path("ranks.h5")), self.digest(one))
        killed = self.path("killed.h5")
        for wait_s in (0.3, 0.6):
            process = start([harness.program("sleight"), "direct", request, "-o", killed, "-q"])
            time.sleep(wait_s)
            kill_group(process)
        said = json.loads(self.direct(request, killed, "--json").stdout)
        self.assertEqual(self.digest(killed), self.digest(one))
        # Draws are the last scans of tours. Satisfying draws are the solutions, and these are kept.
        self.assertGreaterEqual(said["independent_solutions"], 7)
        with h5py.File(one) as archive:
            self.assertEqual(archive["posterior/draw"].size * 4, said["scans"])
            satisfied = archive["sample_stats/satisfied"][:] != 0
            self.assertEqual(satisfied.sum(), said["independent_solutions"])
        again = self.path("again.toml")
        again.write_text(self.info(one)["request"])
        self.direct(again, self.path("again.h5"))
        self.assertEqual(self.digest(self.path("again.h5")), self.digest(one))

    def test_an_archive_of_finds_alone_names_what_repeats_it(self):
        # A run stopped before its first draw has only the search. The run can be resumed.
        request = self.path("tours.toml")
        request.write_text(ISLANDS.replace("round_scans = 4", "tour_scans = 100000").replace(
            "scans = 12", "independent_solutions = 1"))
        output = self.path("cut.h5")
        self.direct(request, output, "--time-limit", "1s")
        again = self.path("again.toml")
        again.write_text(self.info(output)["request"])
        self.assertIn('method = "search"\nseed = 1\n\n[stop]\nfound = 3\n', again.read_text())
        self.direct(again, self.path("again.h5"))
        self.assertEqual(self.digest(self.path("again.h5")), self.digest(output))
        # The resumed run has more draws from the prior and no other find.
        self.direct(request, output, "--time-limit", "1s")
        again.write_text(self.info(output)["request"])
        self.direct(again, self.path("again.h5"))
        self.assertEqual(self.digest(self.path("again.h5")), self.digest(output))

    def test_dice_without_a_sampler(self):
        # Found die by die, then drawn in proportion.
        request = self.path("dice.toml")
        request.write_text(DICE + "found = 3\nindependent_solutions = 1\n")
        self.direct(request, self.path("one.h5"), "-j", "1")
        digest = self.digest(self.path("one.h5"))
        self.succeed(run(harness.batch(3, request, self.path("ranks.h5"), "-q")))
        self.assertEqual(self.digest(self.path("ranks.h5")), digest)
        with h5py.File(self.path("one.h5")) as archive:
            self.assertEqual(len(archive["finds/start"]), 3)
            # The distance of each goal, all within tolerance.
            self.assertTrue((archive["finds/goal_1_place_m"][:] <= 0.010).all())
            for face in ("finds/goal_2_face_rad", "finds/goal_3_face_rad"):
                self.assertTrue((archive[face][:] < numpy.pi / 4).all())

    def test_ladders_from_searches_burn_in(self):
        request = self.path("tempered.toml")
        request.write_text(TEMPERED)
        output = self.path("tempered.h5")
        self.direct(request, output, "-j", "1")
        self.succeed(run(harness.batch(3, request, self.path("ranks.h5"), "-q")))
        self.assertEqual(self.digest(self.path("ranks.h5")), self.digest(output))
        with h5py.File(output) as archive:
            # Rounds that depend on a search are not reported and have no draws. Later rounds are reported and
            # have draws.
            burnt_in = 20 * 31 - archive["posterior/draw"].size
            self.assertIn(burnt_in, [20, 60, 140, 300])
            begins = archive["tempering/first_scan"][:]
            self.assertTrue((begins[:, 0] == burnt_in).all())
            self.assertTrue(numpy.isfinite(archive["tempering/log_z"][:]).all())
        info = sleight("archive", "info", output)
        self.assertEqual(info.returncode, 0, info.stderr)
        judged = sleight("diagnose", output)
        self.assertIn(judged.returncode, (0, 7), judged.stderr)  # sampled well enough, or not

    def test_a_word_is_enough(self):
        shown = sleight("direct", "--word", 'A"B', "--print-request", "-n", "7")
        self.assertEqual(shown.returncode, 3)  # no such letter
        shown = self.succeed(sleight("direct", "--word", "HI", "--print-request", "-n", "7"))
        self.assertEqual(shown.stdout, '[world]\nname = "spelling"\nword = "HI"\n\n'
                                       '[stop]\ntakes = 7\n')
        for option, rule in [("--found", "found"), ("--in-proportion", "independent_solutions")]:
            shown = self.succeed(sleight("direct", "--word", "HI", "--print-request", option))
            self.assertIn(f"[stop]\n{rule} = 5\n", shown.stdout)
        fewer = self.succeed(sleight("direct", self.search(found=9), "-n", "2", "--print-request"))
        self.assertIn("[stop]\nfound = 2\n", fewer.stdout)
        # -n replaces the rules, and the sampler is chosen for solutions, not for the odds.
        odds = self.path("odds.toml")
        odds.write_text(ODDS)
        anew = self.succeed(sleight("direct", odds, "-n", "2", "--print-request")).stdout
        self.assertIn("tour_scans = 16\n", anew)
        self.assertIn("[stop]\nindependent_solutions = 2\nfound = 2\n", anew)
        for arguments, complaint in [
                ([], r"REQUEST\.toml .*--word WORD .*required"),
                (["--word", "HI"], r"-o OUTPUT\.h5 .*required"),
                (["--word", "HI", "x.toml", "-o", "x.h5"], "request .*--word"),
                (["--word", b"A\xff", "-o", "x.h5"], "--word: .*UTF-8"),
                (["--word", "HI", "-n", "0", "-o", "x.h5"], r"--number: .*\b1 .*\b1000000\b"),
                (["--word", "HI", "-n", "1e3", "-o", "x.h5"], "--number: .*'1e3'")]:
            result = sleight("direct", *map(os.fsdecode, arguments))
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertRegex(result.stderr, complaint)

    def test_takes_end(self):
        """Finds exist at once, then takes replace them, with labels. A signal ends the run at once, and an
        interrupted run resumes to the same archive."""
        output = self.path("hi.h5")
        run = ["direct", "--word", "HI", "-n", "3", "-o", output]
        whole = self.succeed(sleight(*run))
        self.assertRegex(whole.stdout, r"\b3 takes .*\b114 scans")
        self.succeed(sleight("archive", "verify", output))
        numbers = self.info(output)
        self.assertIn("relaxed from a search: ", numbers["warning"])
        self.assertEqual((numbers["found"], numbers["relax_scans"], numbers["scans"]), (3, 114, 0))
        with h5py.File(output) as archive:
            self.assertEqual(archive["finds"].attrs["relax_scans"], 114)
            self.assertEqual(archive["prior/draw"].size, 100)
            self.assertTrue((archive["finds/filled"][:] == 16).all())
        self.assertEqual(sleight("diagnose", output).returncode, 2)
        picture = self.path("takes.svg")
        self.succeed(sleight("plot", output, "-o", picture))
        self.assertIn("take 1 of start", picture.read_text())
        cut = self.path("cut.h5")
        process = subprocess.Popen([program("sleight"), "direct", "--word", "HI", "-n", "30", "-o",
                                    cut, "-q"])
        end = time.monotonic() + 60
        while not cut.exists() and time.monotonic() < end:
            time.sleep(0.01)
        process.terminate()
        self.assertEqual(process.wait(timeout=60), 130)
        self.assertEqual(self.info(cut)["found"], 30)
        self.assertEqual(self.info(cut)["relax_scans"], 0)
        self.succeed(sleight("direct", "--word", "HI", "-n", "3", "-o", cut))
        self.assertEqual(self.digest(cut), self.digest(output))
        slow = sleight("direct", "--word", "HI", "--in-proportion", "-o", self.path("p.h5"),
                       "--time-limit", "0.1s")
        self.assertIn("for HI (16 balls)", slow.stderr)

    def test_what_can_not_be_found_is_said(self):
        # Balls that never come to rest in time.
        request = self.path("never.toml")
        request.write_text(SEARCH.format(found=2, word="I").replace(
            'word = "I"', 'word = "I"\ntime_limit_s = 0.01'))
        output = self.path("never.h5")
        self.succeed(sleight("direct", request, "-o", output, "-q"))
        self.assertFalse(output.exists())

    @unittest.skipUnless(os.environ.get("SLEIGHT_SOAK"), "long: for `deploy/soak programs`")
    def test_a_die_that_can_not_come_there(self):
        # A die that would have to rest ten metres away, after a die with a feasible goal.
        request = self.path("far.toml")
        request.write_text(DICE.replace("[stop]", """[[constraint.place]]
die = 2
x_mm = 10000
y_mm = 0
sigma_mm = 5
tolerance_mm = 10
[sampler]
method = "search"
[stop]
found = 8
"""))
        result = self.succeed(sleight("direct", request, "-o", self.path("far.h5"), "-q"))
        self.assertIn("none got past die 2 of 2: ", result.stdout)


if __name__ == "__main__":
    harness.main()
