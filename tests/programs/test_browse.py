"""Goal: find, groups and compare report what archives of each world contain; damage affects only its own part
of an archive. Method: make small runs of each world, compute the same with h5py, and compare 100,000 random
queries of each with slow answers."""

import json
import pathlib
import shutil
import tempfile

import h5py
import numpy
import harness
from harness import ProgramTest, sleight
from test_spelling import REQUEST as TWO_BINS

QUERIES = 100_000
SEED = 26


def parsed(result):
    return json.loads(result.stdout)


class Browse(ProgramTest):
    @classmethod
    def setUpClass(cls):
        """An archive of each world, which no test changes."""
        cls.kept = pathlib.Path(tempfile.mkdtemp(prefix="sleight-test-"))
        cls.addClassCleanup(shutil.rmtree, cls.kept, ignore_errors=True)
        source = pathlib.Path(harness.arguments.source)
        (cls.kept / "two.toml").write_text(TWO_BINS)
        runs = {"ball": [source / "requests/ball_2d.toml", "--set", "stop.scans=400",
                         "--set", "output.min_distance=0.05"],
                "spelling": [cls.kept / "two.toml", "--set", "stop.scans=120",
                             "--set", "output.min_distance=0",
                             "--set", "output.keep_per_lineage=30"],
                "dice": [source / "requests/die.toml", "--set", "stop.rounds=3",
                         "--set", "output.min_distance=0.2"]}
        cls.archives = {}
        for world, arguments in runs.items():
            cls.archives[world] = cls.kept / f"{world}.h5"
            result = sleight("direct", *arguments, "-o", cls.archives[world], "-q")
            assert result.returncode == 0, result.stderr

    def find(self, *arguments):
        return parsed(self.succeed(sleight("find", *arguments, "--json")))

    def test_queries_are_answered_as_slowly_and_plainly(self):
        program = pathlib.Path(harness.arguments.bin).parent / "tests/sleight-check-queries"
        for archive in self.archives.values():
            result = harness.run([program, archive, QUERIES, SEED])
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            self.assertIn(f"{QUERIES} queries", result.stdout)

    def test_find_says_what_the_file_holds(self):
        for world, archive in self.archives.items():
            with h5py.File(archive) as file:
                animations = file["animations"]
                log_prior = animations["log_prior"][:]
                in_proportion = animations["in_proportion"][:].astype(bool).tolist()
                names = [f"c{chain}.{draw}" for chain, draw in
                         zip(animations["chain"][:], animations["draw"][:])]
            found = self.find(archive)
            self.assertEqual([one["id"] for one in found["animations"]], names, world)
            self.assertGreater(len(names), 2, world)
            self.assertEqual([one["in_proportion"] for one in found["animations"]], in_proportion)
            self.assertEqual([one["numbers"]["log_prior"] for one in found["animations"]],
                             list(log_prior))
            middle = repr(float(numpy.median(log_prior)))
            above = self.find(archive, "--where", f"log_prior > {middle}", "--sort", "log_prior")
            self.assertEqual(above["found"], int((log_prior > float(middle)).sum()))
            self.assertEqual([one["numbers"]["log_prior"] for one in above["animations"]],
                             sorted(log_prior[log_prior > float(middle)]))
            below = self.find(archive, "--not", f"log_prior > {middle}", "--descending", "--sort",
                              "log_prior", "-n", "2")
            self.assertEqual(below["found"], len(names) - above["found"])
            self.assertEqual(len(below["animations"]), min(2, below["found"]))
            text = self.succeed(sleight("find", archive)).stdout
            self.assertIn(f"{len(names)} of {len(names)} animations", text)
            for name in names:
                self.assertIn(name, text)

    def test_what_a_search_found_is_told_apart(self):
        # Draws have the model's proportions, finds don't. A query keeps both apart.
        archive = self.kept / "found.h5"
        self.direct(pathlib.Path(harness.arguments.source) / "requests/die.toml", archive, "--set", "stop.found=3",
                    "--set", "stop.rounds=2")
        found = self.find(archive)["animations"]
        self.assertEqual({one["group"]: one["in_proportion"] for one in found},
                         {"finds": False, "animations": True})
        alone = self.find(archive, "--where", "in_proportion = 0")
        self.assertEqual({one["group"] for one in alone["animations"]}, {"finds"})

    def test_names_alone_are_what_export_takes(self):
        archive = self.archives["dice"]
        names = self.succeed(sleight("find", archive, "--sort", "log_prior", "--descending", "-n", 3,
                                     "--ids")).stdout.split()
        self.assertEqual(len(names), 3)
        rows = self.succeed(sleight("export", archive, "--format", "csv", "--ids", *names)).stdout
        self.assertEqual([row.split(",")[0] for row in rows.splitlines()[1:]], names)

    def test_of_several_worlds_each_query_finds_its_own(self):
        both = [self.archives["dice"], self.archives["ball"]]
        result = self.succeed(sleight("find", *both, "--where", "die 1 touches table", "--json"))
        alone = self.find(both[0], "--where", "die 1 touches table")
        self.assertEqual(parsed(result)["found"], alone["found"])
        self.assertEqual([left["path"] for left in parsed(result)["left_out"]], [str(both[1])])
        self.assertEqual([one["path"] for one in parsed(result)["archives"]], [str(both[0])])
        self.assertEqual(sleight("find", *both, "--where", "dye 1 touches table").returncode, 2)

    def test_paths_and_contacts_are_the_segments(self):
        archive = self.archives["dice"]
        with h5py.File(archive) as file:
            animations = file["animations"]
            starts, counts = animations["segment_start"][:], animations["segment_count"][:]
            position = animations["position_m"][:]
            rest = [position[start + count - 1] for start, count in zip(starts, counts)]
            names = [f"c{chain}.{draw}" for chain, draw in
                     zip(animations["chain"][:], animations["draw"][:])]
            hits = [int((animations["partner"][start:start + count] >= 0).sum())
                    for start, count in zip(starts, counts)]
        for low, high in [(28, 30), (30, 31), (0, 100)]:
            found = self.find(archive, "--where", f"die 1 ends in x {low}..{high}mm")
            self.assertEqual([one["id"] for one in found["animations"]],
                             [name for name, place in zip(names, rest) if low <= 1000 * place[0] <= high])
        twice = self.find(archive, "--where", "die 1 touches table then die 1 touches table")
        self.assertEqual([one["id"] for one in twice["animations"]],
                         [name for name, count in zip(names, hits) if count > 1])
        self.assertEqual(self.find(archive, "--in", "die 1: z 5m..")["found"], 0)
        self.assertEqual(self.find(archive, "--in", "any: z 90..110mm during ..0s")["found"], len(names))

    def test_a_bad_archive_costs_its_own_place(self):
        cut = self.path("cut.h5")
        cut.write_bytes(self.archives["ball"].read_bytes()[:40_000])
        missing = self.path("missing.h5")
        text = self.path("text.h5")
        text.write_text("not an archive")
        good = self.archives["dice"]
        result = self.succeed(sleight("find", cut, good, missing, text, "--json"))
        found = parsed(result)
        self.assertEqual([left["path"] for left in found["left_out"]], [str(cut), str(missing), str(text)])
        self.assertTrue(all(left["reason"] for left in found["left_out"]))
        self.assertEqual(found["found"], self.find(good)["found"])
        for path in [cut, missing, text]:
            self.assertIn(f"left out: {path}: ", result.stderr)
        for command in ["find", "groups"]:
            result = sleight(command, cut, text)
            self.assertEqual(result.returncode, 6, result.stderr)
            self.assertIn(str(cut), result.stderr)
        self.assertEqual(sleight("compare", good, cut).returncode, 6)

    def test_groups_divide_all(self):
        for world, archive in self.archives.items():
            names = {one["id"] for one in self.find(archive)["animations"]}
            for way in ["medoids", "hierarchy"]:
                groups = parsed(self.succeed(sleight("groups", archive, "-k", 3, "--by", way, "--json")))
                self.assertEqual(len(groups["groups"]), 3)
                members = [name for group in groups["groups"] for name in group["members"]]
                self.assertEqual(sorted(members), sorted(names), world)
                for group in groups["groups"]:
                    self.assertIn(group["representative"]["id"], group["members"])
            picture = self.path(f"{world}.svg")
            self.succeed(sleight("groups", archive, "-k", 3, "-o", picture))
            self.assertNotIn("nan", picture.read_text())
            self.assertEqual(picture.read_text().count("are like"), 3)

    def test_archives_in_any_order_have_the_same_groups(self):
        other = self.path("other.h5")
        self.direct(pathlib.Path(harness.arguments.source) / "requests/die.toml", other,
                    "--set", "stop.rounds=2", "--set", "sampler.seed=7", "--set", "output.min_distance=0.2")
        told = []
        for pair in [(self.archives["dice"], other), (other, self.archives["dice"])]:
            groups = parsed(self.succeed(sleight("groups", *pair, "-k", 4, "--json")))
            told.append([(group["representative"]["id"], group["members"]) for group in groups["groups"]])
        self.assertEqual(*told)
        self.assertTrue(all(":" in name for name, _ in told[0]))
        # Another world's bodies can't be compared.
        result = sleight("groups", self.archives["dice"], self.archives["ball"])
        self.assertEqual(result.returncode, 2)
        # The same run twice counts once.
        twice = self.find(self.archives["dice"], self.archives["dice"])
        self.assertEqual(twice["found"], self.find(self.archives["dice"])["found"])
        # Differences: the request's keys, and the numbers of similar animations.
        compared = parsed(self.succeed(sleight("compare", self.archives["dice"], other, "-k", 3, "--json")))
        self.assertEqual({line["key"] for line in compared["request"]}, {"stop.scans", "sampler.seed"})
        members = sum(group["first"] + group["second"] for group in compared["groups"])
        self.assertEqual(members, sum(archive["animations"] for archive in compared["archives"]))
        self.assertTrue(0 < compared["nearest_neighbours"]["p_value"] <= 1)


if __name__ == "__main__":
    harness.main()
