"""Goal: balls are directed to spell, and the archive records it. Method: direct a small word of two bins by
threads, by mpirun and on processors without AVX2. Read the archive with h5py, and inspect its drawings as
SVG."""

import re

import h5py
import numpy
import harness
from harness import ProgramTest, sleight

REQUEST = '''
[world]
name = "spelling"
bitmap = """
.#.
.#.
"""
[constraint]
log_lambda = 3
[sampler]
method = "metropolis_hastings"
chains = 2
seed = 4
iterations_per_scan = 2
[stop]
scans = 40
'''


class Spelling(ProgramTest):
    def request(self):
        path = self.path("two.toml")
        path.write_text(REQUEST)
        return path

    def test_the_archive_holds_what_happened(self):
        self.direct(self.request(), self.path("two.h5"))
        self.succeed(sleight("archive", "verify", self.path("two.h5")))
        with h5py.File(self.path("two.h5")) as archive:
            animations = archive["animations"]
            filled = animations["filled"][:]
            self.assertGreater(len(filled), 0)
            self.assertTrue((filled == 2).all())
            self.assertTrue((animations["elsewhere"][:] == 0).all())
            self.assertTrue((animations["active"][:] == 1).all())
            drops = animations["drop_m"][:]
            self.assertTrue((numpy.abs(drops[:, :, 0]) <= 0.032 - 0.008).all())
            # Each animation's balls end at rest in the two bins of the middle column.
            starts = animations["segment_start"][:]
            counts = animations["segment_count"][:]
            for start, count in zip(starts, counts):
                ball = animations["body"][start:start + count]
                mode = animations["mode"][start:start + count]
                place = animations["position_m"][start:start + count]
                ends = [numpy.flatnonzero(ball == one)[-1] for one in (0, 1)]
                self.assertTrue((mode[ends] == 3).all())
                self.assertTrue((numpy.abs(place[ends, 0]) < 0.01).all())
                self.assertEqual(sorted(numpy.sign(place[ends, 1])), [-1, 1])

    def test_the_same_bits_by_any_means(self):
        request = self.request()
        self.direct(request, self.path("one.h5"), "--threads", "1")
        self.direct(request, self.path("two.h5"), "--threads", "2")
        self.succeed(harness.run(harness.batch(2, request, self.path("ranks.h5"), "-q",
                                               folder=self.folder)))
        self.direct(request, self.path("plain.h5"),
                    env={"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA"})
        for name in ["two.h5", "ranks.h5", "plain.h5"]:
            self.assertEqual(self.path(name).read_bytes(), self.path("one.h5").read_bytes(), name)

    def test_pictures(self):
        archive = self.path("two.h5")
        self.direct(self.request(), archive)
        for what in ["trace", "animations"]:
            for ending, head in [("svg", b"<svg"), ("png", b"\x89PNG")]:
                picture = self.path(f"{what}.{ending}")
                self.succeed(sleight("plot", archive, "--what", what, "-o", picture))
                self.assertTrue(picture.read_bytes().startswith(head))
        svg = self.path("animations.svg").read_text()
        with h5py.File(archive) as file:
            kept = min(3, len(file["animations/animation"]))
            found = {(int(chain), 2 * int(draw)) for chain, draw in
                     zip(file["animations/chain"], file["animations/draw"])}
        shown = re.findall(r"chain (\d+), iteration (\d+)<", svg)
        self.assertEqual(len(shown), kept)
        self.assertLessEqual({(int(chain), int(step)) for chain, step in shown}, found)
        # Seen from above, two of six bins are tinted. Two balls have their paths, with their numbers from
        # above and from the front.
        self.assertEqual(svg.count('fill="#f4b8a0"'), 2 * kept)
        self.assertEqual(svg.count(">at rest after "), kept)
        for ball in ["1", "2"]:
            self.assertEqual(len(re.findall(rf"<text [^>]*>{ball}</text>", svg)), 2 * kept)
        one = self.succeed(sleight("plot", archive, "--what", "animations", "--count", "1"))
        self.assertEqual(one.stdout.count("iteration"), 1)
        filled = self.path("filled.svg")
        self.succeed(sleight("plot", archive, "--chain", "1", "-o", filled))
        self.assertIn(">filled bins<", filled.read_text())
        self.assertIn(">all 2<", filled.read_text())
        self.assertNotIn("chain 0", filled.read_text())

    def test_words_are_drawn_too(self):
        # The world determines a word's bins. The largest box has a request with its whole bitmap on one line.
        for world, tinted in [('word = "I"', 5), ('bitmap = "#"\ncolumns = 40\nrows = 12', 1)]:
            request = self.path("word.toml")
            request.write_text(re.sub(r'bitmap = """.*?"""', world, REQUEST, flags=re.S))
            archive = self.path("word.h5")
            self.direct(request, archive, "--fresh")
            self.succeed(sleight("plot", archive, "-o", self.path("word.svg")))
            self.assertIn(f">all {tinted}<", self.path("word.svg").read_text())

    def test_a_biased_kernel_is_labelled(self):
        path = self.path("thesis.toml")
        path.write_text(REQUEST.replace("[sampler]", '[sampler]\nkernel = "thesis"'))
        label = "biased kernel: thesis (A.2.2 as printed)"
        self.assertIn(label, self.direct(path, self.path("thesis.h5")).stderr)
        self.succeed(sleight("archive", "verify", self.path("thesis.h5")))
        self.assertIn(label, sleight("archive", "info", self.path("thesis.h5")).stdout)
        info = self.info(self.path("thesis.h5"))
        self.assertEqual(info["warning"], label)
        self.assertIn('kernel = "thesis"', info["request"])
        with h5py.File(self.path("thesis.h5")) as archive:
            self.assertEqual(archive.attrs["warning"].decode(), label)
        # With the correct kernel, there is no such warning.
        self.assertNotIn("biased", self.direct(self.request(), self.path("two.h5")).stderr)
        self.assertEqual(self.info(self.path("two.h5"))["warning"], "")


if __name__ == "__main__":
    harness.main()
