"""Goal: the odds of a word that was searched for, and of a scene, are reported, are the same for any number of
threads, and a stopped run keeps its results. Method: request odds with one thread, with two, and with a stop. Check the
archive and `sleight archive info`."""

import re

import h5py
import harness
from harness import ProgramTest, sleight

ODDS = """
[world]
name = "spelling"
word = "I"
font = "5 rows"
[stop]
odds = 0.8
found = 2
"""

SCENE = """
[world]
name = "scene"
end_s = 0.8
[world.contact_noise]
above_mps = 0.3
tilt_sd_deg = 8
restitution_sd = 0.15
[[world.material]]
name = "rubber"
restitution = 0.6
[[world.body]]
name = "floor"
shape = "plane"
material = "rubber"
[[world.body]]
name = "ball"
radius_mm = 10
at_mm = [0, 0, 100]
material = "rubber"
[[constraint.event]]
body = "ball"
hits = "floor"
nth = 2
at_s = 0.33
tolerance_s = 0.02
sigma_s = 0.01
window_s = 0.1
[[constraint.place]]
body = "ball"
at_mm = [80, 0]
at_s = 0.5
tolerance_mm = 10
sigma_mm = 10
[sampler]
method = "splitting"
particles = 16
[stop]
odds = 0.5
"""


class SearchOdds(ProgramTest):
    def test_islands_tell_them(self):
        for text in (ODDS, SCENE):
            with self.subTest(text=text):
                self.islands_tell(text)

    def islands_tell(self, text):
        request = self.path("odds.toml")
        request.write_text(text)
        output = self.path("odds.h5")
        self.direct(request, output, "-j", "1", "--fresh")
        self.direct(request, self.path("two.h5"), "-j", "2", "--fresh")
        self.assertEqual(self.digest(self.path("two.h5")), self.digest(output))
        with h5py.File(output) as archive:
            first = archive["tempering/odds_from_island"][:]
            self.assertTrue((first > 0).all())
        info = sleight("archive", "info", output)
        self.assertIn("by chance", info.stdout)
        odds = self.info(output)["tempering"]
        self.assertEqual(odds["from"], "islands")
        self.assertTrue(odds["known"])

    def test_what_is_known_so_far_is_kept(self):
        request = self.path("odds.toml")
        request.write_text(ODDS)
        output = self.path("odds.h5")
        stopped = self.succeed(sleight("direct", request, "-o", output, "--set", "stop.odds=0.001",
                                       "--time-limit", "2s"))
        self.assertRegex(stopped.stdout, r"log P about -\d+\.\d.*, still rough \([\d,]+.* islands?\)")
        self.succeed(sleight("archive", "verify", output))
        self.assertFalse(self.info(output)["tempering"]["known"])
        # The same run is long enough for a larger error.
        whole = self.succeed(sleight("direct", request, "-o", output, "-q"))
        told = re.search(r"log P (-\d+\.\d\d) \+- 0\.\d\d \((\d+) islands\)", whole.stdout)
        odds = self.info(output)["tempering"]["log_p_throw"]
        self.assertAlmostEqual(odds["value"], float(told[1]), delta=0.005)
        self.assertEqual(odds["islands"], int(told[2]))


if __name__ == "__main__":
    harness.main()
