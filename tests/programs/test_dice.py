"""Goal: the kept animations of dice become pictures. Method: direct two dice with wide goals, read the
archive with h5py, and inspect its drawings as SVG."""

import re

import h5py
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
        # Each picture shows the upper faces, the second of which is requested, and the ring.
        shown = re.findall(r">up: (\d), (\d); ([0-9.]+) mm from the place", svg)
        self.assertEqual(len(shown), kept)
        for _, second, off_mm in shown:
            self.assertEqual(second, "5")
            self.assertLess(float(off_mm), 200)
        self.assertEqual(svg.count("<ellipse"), kept)
        one = self.succeed(sleight("plot", archive, "--what", "animations", "--count", "1"))
        self.assertEqual(one.stdout.count("iteration"), 1)


if __name__ == "__main__":
    harness.main()
