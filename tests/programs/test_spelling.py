"""Goal: balls are directed to spell, and the archive holds what happened. Method: a small word of
two bins, by threads, by mpirun, on processors without AVX2; the archive read back with h5py."""

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
                ball = animations["moving_ball"][start:start + count]
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

    def test_a_wrong_bitmap_is_told(self):
        path = self.path("bad.toml")
        path.write_text(REQUEST.replace(".#.\n.#.", ".#.\n.#"))
        result = sleight("check", path)
        self.assertEqual(result.returncode, 3)
        self.assertIn("row 2 has 2 characters, row 1 has 3", result.stderr + result.stdout)


if __name__ == "__main__":
    harness.main()
