"""Goal: the kept animations of dice become pictures. Method: two dice with wide goals; the archive
read back with h5py, drawn and looked at as SVG."""

import re

import h5py
import numpy
import harness
from harness import ProgramTest, sleight

REQUEST = '''
[world]
name = "dice"
dice = 2
[[constraint.place]]
die = 1
x_mm = 30
y_mm = 0
sigma_mm = 100
tolerance_mm = 200
[[constraint.face]]
die = 2
up = 5
[sampler]
method = "metropolis_hastings"
chains = 2
seed = 4
[stop]
scans = 60
'''


class Dice(ProgramTest):
    def archive(self):
        request = self.path("two.toml")
        request.write_text(REQUEST)
        archive = self.path("two.h5")
        self.direct(request, archive)
        return archive

    def test_pictures(self):
        archive = self.archive()
        for what in ["trace", "animations"]:
            for ending, head in [("svg", b"<svg"), ("png", b"\x89PNG")]:
                picture = self.path(f"{what}.{ending}")
                self.succeed(sleight("plot", archive, "--what", what, "-o", picture))
                self.assertTrue(picture.read_bytes().startswith(head))
        svg = self.path("animations.svg").read_text()
        with h5py.File(archive) as file:
            kept = min(3, len(file["animations/animation"]))
        self.assertGreater(kept, 0)
        self.assertEqual(len(re.findall(r"chain \d+, iteration \d+<", svg)), kept)
        # Each shows the upper faces, the second of which is asked for, and the ring.
        shown = re.findall(r">up: (\d), (\d); ([0-9.]+) mm from the place", svg)
        self.assertEqual(len(shown), kept)
        for _, second, off_mm in shown:
            self.assertEqual(second, "5")
            self.assertLess(float(off_mm), 200)
        self.assertEqual(svg.count("<ellipse"), kept)
        one = self.succeed(sleight("plot", archive, "--what", "animations", "--count", "1"))
        self.assertEqual(one.stdout.count("iteration"), 1)

    def test_plausibility(self):
        # Scores by numpy from the archive's columns and the request's defaults.
        archive = self.archive()
        with h5py.File(archive) as file:
            animations = file["animations"]
            position = animations["start_position_m"][:]
            velocity = animations["start_velocity_mps"][:]
            spin = animations["start_spin_radps"][:]
            points = animations["offsets"][:].sum()
            squares = animations["offset_squares"][:]
            stats = file["sample_stats/offsets"][:]
        count = len(position)
        self.assertGreater(count, 0)
        self.assertEqual(stats.shape[-1], 14)
        # Dice start 45 mm apart.
        scores = [(position[:, :, 0] + 0.15) / 0.005,
                  (position[:, :, 1] - [-0.0225, 0.0225]) / 0.005,
                  (velocity[:, :, 0] - 0.7) / 0.1, velocity[:, :, 1] / 0.1,
                  spin[:, :, 0] / 20, spin[:, :, 1] / 20, spin[:, :, 2] / 20]
        start = sum((one ** 2).sum() for one in scores) / count / 2 - len(scores)
        table = (squares.sum() - points) / count / 2
        picture = self.path("plausibility.svg")
        result = self.succeed(sleight("plot", archive, "--what", "plausibility", "-o", picture))
        said = re.findall(r"(starts|table): +log probability ([0-9.]+)(?: \+- [0-9.]+)? (below|above)",
                          result.stdout)
        self.assertEqual([name for name, _, _ in said], ["starts", "table"])
        for (_, cost, way), expected in zip(said, [start, table]):
            self.assertAlmostEqual(float(cost) * (1 if way == "below" else -1), expected, delta=0.006)
        svg = picture.read_text()
        self.assertEqual(svg.count("standard scores"), 8)
        self.assertIn("velocity y", svg)
        wrong = sleight("plot", archive, "--what", "plausibility", "--chain", "2")
        self.assertEqual(wrong.returncode, 2, wrong.stderr)

    def test_pictures_that_there_are_not(self):
        archive = self.archive()
        damaged = self.path("damaged.h5")
        result = sleight("plot", archive, "--what", "paths", "-o", self.path("no.svg"))
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("try --what animations", result.stderr)
        for dataset, value, words in [("body", 20, "moves a body 21 of 2"),
                                      ("orientation", 0, "that are no rotations"),
                                      ("position_m", numpy.nan, "has numbers that no motion has"),
                                      ("segment_count", 0, "moves nothing")]:
            damaged.write_bytes(archive.read_bytes())
            with h5py.File(damaged, "r+") as file:
                file["animations"][dataset][:] = value
            result = sleight("plot", damaged, "--what", "animations", "-o", self.path("no.svg"))
            self.assertEqual(result.returncode, 6, result.stderr)
            self.assertIn(words, result.stderr)
            self.assertFalse(self.path("no.svg").exists())


if __name__ == "__main__":
    harness.main()
