"""Goal: a saved gallery's page finds, groups and compares like the programs: the same entries, errors,
groups, orders and distances to the last bit. Method: answer random questions about an archive of each world
by clients/browse (sleight-gallery-answers) and by the page's own search in Node."""

import json
import pathlib
import shutil
import subprocess

import harness
from harness import ProgramTest, sleight
from test_spelling import REQUEST as TWO_BINS

QUERIES = 2000
SETS = 40
SEED = 27


class GallerySearch(ProgramTest):
    @classmethod
    def setUpClass(cls):
        cls.source = pathlib.Path(harness.arguments.source)
        cls.page = cls.source / "clients/gallery"
        cls.answers = pathlib.Path(harness.arguments.bin).parent / "tests/sleight-gallery-answers"
        if shutil.which("node") is None or not (cls.page / "node_modules/esbuild").exists():
            raise AssertionError("node or clients/gallery/node_modules is missing: run deploy/install-deps")

    def archive(self, world):
        if world == "spelling":
            self.path("two.toml").write_text(TWO_BINS)
        arguments = {"ball": [self.source / "requests/ball_2d.toml", "--set", "stop.scans=4000",
                              "--set", "output.min_distance=0", "--set", "output.keep_per_lineage=250"],
                     "spelling": [self.path("two.toml"), "--set", "stop.scans=120",
                                  "--set", "output.min_distance=0", "--set", "output.keep_per_lineage=30"],
                     "dice": [self.source / "requests/die.toml", "--set", "stop.rounds=3",
                              "--set", "output.min_distance=0.2"]}
        archive = self.path(f"{world}.h5")
        self.succeed(sleight("direct", *arguments[world], "-o", archive, "-q"))
        return archive

    def lines(self, name):
        return [json.loads(line) for line in self.path(name).read_text().splitlines()]

    def said_by_the_page(self):
        """The page's answers to questions.jsonl for index.bin."""
        program = self.path("search-program.mjs")
        self.succeed(harness.run(["node", self.page / "test/bundle.mjs", "search-program.ts", program]))
        with open(self.path("said.jsonl"), "w") as said:
            result = subprocess.run(
                ["node", program, self.path("index.bin"), self.path("questions.jsonl")],
                stdout=said, stderr=subprocess.PIPE, text=True, timeout=600)
        self.assertEqual(result.returncode, 0, result.stderr)
        return self.lines("said.jsonl")

    def test_the_page_answers_as_the_programs_do(self):
        sets = []
        for world in ["ball", "spelling", "dice"]:
            folder = self.path("index.bin").parent
            self.succeed(harness.run([self.answers, self.archive(world), folder, QUERIES, SETS, SEED]))
            questions, answers = self.lines("questions.jsonl"), self.lines("answers.jsonl")
            said = self.said_by_the_page()
            self.assertEqual(len(said), len(questions))
            for question, answer, own in zip(questions, answers, said):
                self.assertEqual(own, answer, f"{world}, seed {SEED}: {json.dumps(question)}")
            # Enough questions of all kinds, or equality proves little.
            finds = [answer for question, answer in zip(questions, answers) if "find" in question]
            self.assertGreater(sum("message" in answer for answer in finds), len(finds) / 4)
            self.assertGreater(sum(bool(answer.get("entries")) for answer in finds), len(finds) / 10)
            self.assertEqual(len(questions) - len(finds), 2 * SETS)
            sets += [(len(q["groups"]["entries"]), q["groups"]["groups"]) for q in questions if "groups" in q]
        # Sets of which all pairs are compared, and larger sets of both sampling kinds.
        self.assertTrue(any(entries <= 500 and groups > 1 for entries, groups in sets))
        self.assertTrue(any(entries > 500 and 1 < groups <= 100 for entries, groups in sets))
        self.assertTrue(any(entries > 500 and groups > 100 for entries, groups in sets))

    def test_other_answers_would_be_noticed(self):
        """Goal: the comparison can fail. Method: ask the page about an index whose places differ in their
        ninth digit."""
        folder = self.path("index.bin").parent
        self.succeed(harness.run([self.answers, self.archive("dice"), folder, 0, SETS, SEED]))
        index = bytearray(self.path("index.bin").read_bytes())
        head = int.from_bytes(index[:4], "little")
        columns = {column["name"]: column for column in json.loads(index[4:4 + head])["columns"]}
        positions = columns["piece_position_m"]
        for at in range(0, 8 * positions["count"], 8):
            index[4 + head + positions["offset"] + at + 3] ^= 1
        self.path("index.bin").write_bytes(index)
        self.assertNotEqual(self.said_by_the_page(), self.lines("answers.jsonl"))


if __name__ == "__main__":
    harness.main()
