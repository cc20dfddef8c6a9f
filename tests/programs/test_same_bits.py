"""Goal: the archive is a function of only request, seed and version. Method: run the same request in other
ways and compare archives byte for byte and by digest."""

import pathlib
import re

import harness
from harness import ProgramTest

# One of each world, at most two seconds each.
QUICK = ["requests/ball_2d.toml", "requests/die.toml", "requests/hi.toml"]
K_GOLDEN = pathlib.Path(__file__).parent / "golden_digests.txt"


class Golden:
    """A line of golden_digests.txt: a request, changes that shorten its copy, a digest. `key=value` sets
    another value, `key:other=value` replaces the key by another."""

    def __init__(self, line):
        self.name, *changes, self.digest = line.split()
        self.changes = [change.split("=") for change in changes]

    def shortened(self, text):
        for key, value in self.changes:
            key, _, other = key.partition(":")
            text, count = re.subn(rf"^{key} = \S+", f"{other or key} = {value}", text,
                                  flags=re.MULTILINE)
            assert count == 1, f"{self.name}: {count} lines of {key}"
        return text


def goldens():
    lines = K_GOLDEN.read_text().splitlines()
    return [Golden(line) for line in lines if line.strip() and not line.startswith("#")]


class SameBits(ProgramTest):
    def test_threads(self):
        request = self.write_request(scans=5000)
        self.direct(request, self.path("one.h5"), "--threads", "1")
        for threads in ["2", "3", "7"]:
            output = self.path(f"threads{threads}.h5")
            self.direct(request, output, "--threads", threads)
            self.assertEqual(output.read_bytes(), self.path("one.h5").read_bytes(), threads)
            self.same_events(output, self.path("one.h5"))

    def test_ranks(self):
        request = self.write_request(scans=5000, chains=5)
        self.direct(request, self.path("direct.h5"))
        without = self.path("without.h5")
        self.succeed(harness.run([harness.program("sleight-batch"), request, "-o", without, "-q"]))
        self.assertEqual(without.read_bytes(), self.path("direct.h5").read_bytes())
        for ranks in [1, 2, 3]:
            output = self.path(f"ranks{ranks}.h5")
            self.succeed(harness.run(harness.batch(ranks, request, output, "-q",
                                                   folder=self.folder)))
            self.assertEqual(output.read_bytes(), self.path("direct.h5").read_bytes(), ranks)
            self.same_events(output, self.path("direct.h5"))

    def test_processors_without_avx2_and_fma(self):
        # tests/determinism shows that libm's own sums change under this setting.
        request = self.write_request(scans=5000)
        self.direct(request, self.path("with.h5"))
        self.direct(request, self.path("without.h5"),
                    env={"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA"})
        self.assertEqual(self.path("with.h5").read_bytes(), self.path("without.h5").read_bytes())

    def test_what_is_asked_for_does_change_the_archive(self):
        # The comparison can fail: seed, chains and scans change the digest.
        self.direct(self.write_request(scans=200), self.path("base.h5"))
        for name, changes in [("seed", {"seed": 2}), ("chains", {"chains": 5}),
                              ("scans", {"scans": 201}), ("thin", {"thin": 2}),
                              ("iterations", {"iterations_per_scan": 2})]:
            output = self.path(f"{name}.h5")
            self.direct(self.write_request(f"{name}.toml", **{"scans": 200, **changes}), output)
            self.assertNotEqual(self.digest(output), self.digest(self.path("base.h5")), name)

    def test_golden_digests(self):
        self.judge([golden for golden in goldens() if golden.name not in QUICK])

    def test_golden_digests_of_quick_requests(self):
        self.judge([golden for golden in goldens() if golden.name in QUICK])

    def judge(self, some):
        # A change of bits must be explained by its commit: update the file and name the cause there.
        source = pathlib.Path(harness.arguments.source)
        for golden in some:
            with self.subTest(golden.name):
                request = self.path(pathlib.Path(golden.name).name)
                request.write_text(golden.shortened((source / golden.name).read_text()))
                output = request.with_suffix(".h5")
                self.direct(request, output)
                self.assertEqual(self.digest(output), golden.digest)

    def test_each_request_has_a_golden_digest(self):
        source = pathlib.Path(harness.arguments.source)
        requests = [f"requests/{path.name}" for path in (source / "requests").glob("*.toml")]
        self.assertEqual(sorted(golden.name for golden in goldens()), sorted(requests))


if __name__ == "__main__":
    harness.main()
