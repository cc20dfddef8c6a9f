"""Goal: a world that is only in a program's list of worlds is directed, drawn, browsed and exported like any
other. Method: run each command on the pucks of tests/failing, and compare its output with their closed-form
motions."""

import json
import math
import pathlib

import h5py
import harness
from harness import ProgramTest, run, sleight

REQUEST = """
[world]
name = "pucks"
friction = 0.05
[constraint]
target_m = 1.5
[sampler]
method = "metropolis_hastings"
chains = 2
seed = 26
[stop]
scans = 300
[output]
min_distance = 0.01
keep_per_lineage = 20
"""
DECELERATION = 0.05 * 9.81


class MadeUpWorld(ProgramTest):
    def setUp(self):
        super().setUp()
        request = self.path("pucks.toml")
        request.write_text(REQUEST)
        self.archive = self.path("pucks.h5")
        self.direct(request, self.archive)

    def json_of(self, *arguments):
        return json.loads(self.succeed(sleight(*arguments, "--json")).stdout)

    def pushes(self):
        with h5py.File(self.archive) as file:
            kept = file["animations"]
            return {f"c{chain}.{draw}": push for chain, draw, push in
                    zip(kept["chain"][:], kept["draw"][:], kept["push"][:].tolist())}

    def test_it_is_drawn(self):
        self.succeed(sleight("archive", "verify", self.archive))
        self.assertEqual(self.info(self.archive)["world"], "pucks")
        for what in ["trace", "animations"]:
            picture = self.path(f"{what}.svg")
            self.succeed(sleight("plot", self.archive, "--what", what, "-o", picture))
            self.assertNotIn("nan", picture.read_text())
        self.assertIn("puck", self.path("animations.svg").read_text())
        # Plots of other worlds are not offered.
        result = sleight("plot", self.archive, "--what", "plausibility", "-o", self.path("a.svg"))
        self.assertEqual(result.returncode, 2)

    def test_it_is_browsed(self):
        pushes = self.pushes()
        self.assertGreater(len(pushes), 5)
        found = self.json_of("find", self.archive)
        self.assertEqual([one["id"] for one in found["animations"]], list(pushes))
        # The hit is when the first puck has closed the gap. Until then, the second doesn't move.
        for moment in [0.3, 0.35, 0.4]:
            found = self.json_of("find", self.archive, "--where",
                                 f"puck 1 touches puck 2 during ..{moment}s")
            expected = []
            for name, (speed, gap) in pushes.items():
                after = math.sqrt(speed * speed - 2 * DECELERATION * gap)
                if (speed - after) / DECELERATION <= moment:
                    expected.append(name)
            self.assertEqual([one["id"] for one in found["animations"]], expected)
        rest = self.json_of("find", self.archive, "--where", "puck 2 ends in x 1.45..1.55m")
        within = self.json_of("find", self.archive, "--where", "rest_x_m 1.45..1.55")
        self.assertEqual(rest["animations"], within["animations"])
        self.assertTrue(0 < rest["found"] < len(pushes))
        groups = self.json_of("groups", self.archive, "-k", 3)
        self.assertEqual(sorted(name for group in groups["groups"] for name in group["members"]),
                         sorted(pushes))

    def test_it_is_exported(self):
        name, (speed, _) = next(iter(self.pushes().items()))
        model = self.path("push.glb")
        self.succeed(sleight("export", self.archive, "--ids", name, "-o", model))
        self.succeed(run(["node", pathlib.Path(harness.arguments.source) / "tests/gltf/validate.js", model]))
        text = model.read_bytes()
        for word in [b'"puck 1"', b'"ice"', b'"target"']:
            self.assertIn(word, text)
        picture = self.path("push.svg")
        self.succeed(sleight("export", self.archive, "--ids", name, "--format", "svg", "-o", picture))
        self.succeed(sleight("export", self.archive, "--ids", name, "--format", "png", "--fps", "4", "-o",
                             self.path("frames")))
        # A hit transfers the whole speed, so the pucks come to rest when a single one would.
        frames = list((self.path("frames")).glob("*/*.png"))
        self.assertEqual(len(frames), math.floor(4 * (speed / DECELERATION)) + 1)
        rows = self.succeed(sleight("export", self.archive, "--ids", name, "--format", "csv", "--table",
                                    "segments")).stdout.splitlines()
        self.assertEqual(len(rows), 1 + 5)


if __name__ == "__main__":
    harness.main()
