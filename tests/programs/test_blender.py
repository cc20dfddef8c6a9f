"""Goal: Blender, with the add-on of clients/blender, shows exported animations as their archives describe
them: each body at ten times of each animation, to 0.1 mm and 0.2 degrees, with materials and metadata.
Method: direct a ball, dice and balls that spell. Run tests/blender/in_blender.py in Blender without a
display, which compares the scene with h5py's values. Too long and too large for CI: deploy/soak blender runs
it and needs `deploy/install-deps --blender`."""

import csv
import io
import pathlib
import shutil
import sys

import harness
from harness import ProgramTest, run, sleight

ANIMATIONS = 20  # of each world, at most


class Blender(ProgramTest):
    def setUp(self):
        super().setUp()
        self.source = pathlib.Path(harness.arguments.source).resolve()

    def directed(self, name, what, seconds):
        archive = self.path(f"{name}.h5")
        self.succeed(sleight("direct", *what, "-o", archive, "-q", "--time-limit", f"{seconds}s"))
        rows = csv.DictReader(io.StringIO(
            self.succeed(sleight("export", archive, "--format", "csv")).stdout))
        ids = [row["id"] for row in rows]
        # Some animations of chains and some finds, if both exist.
        return archive, [*ids[:ANIMATIONS // 2], *ids[ANIMATIONS // 2:][-(ANIMATIONS // 2):]]

    def exported(self, archive, ids, *options):
        folder = self.path(f"{archive.stem}-models")
        self.succeed(sleight("export", archive, "--ids", *ids, "-o", folder, *options))
        files = sorted(folder.iterdir())
        self.assertEqual(len(files), len(ids))
        return files

    def in_blender(self, archive, files):
        return run(["blender", "--background", "--factory-startup", "--python",
                    self.source / "tests/blender/in_blender.py", "--",
                    self.source / "clients/blender/sleight_import.py", archive, "24", *files],
                   env={"SLEIGHT": str(pathlib.Path(harness.program("sleight")).resolve())})

    def compared(self, world, result):
        self.succeed(result)
        line = next(line for line in result.stdout.splitlines() if line.startswith("in Blender"))
        print(f"{world}: {line}")

    def test_each_world(self):
        requests = self.source / "requests"
        for world, what, seconds in [("ball", [requests / "ball_2d.toml"], 10),
                                     ("die", [requests / "die.toml"], 20),
                                     ("hi", ["--word", "HI"], 60)]:
            archive, ids = self.directed(world, what, seconds)
            self.compared(world, self.in_blender(archive, self.exported(archive, ids)))

    def test_archives_and_what_is_too_coarse(self):
        archive, ids = self.directed("ball", [self.source / "requests/ball_2d.toml"], 5)
        # The add-on runs `sleight` to export the archive.
        self.compared("ball, by the add-on", self.in_blender(archive, []))
        # Five frames a second don't give these keys, so the comparison can fail.
        coarse = self.in_blender(archive, self.exported(archive, ids, "--fps", "5"))
        self.assertNotEqual(coarse.returncode, 0)
        self.assertIn("AssertionError", coarse.stdout + coarse.stderr)
        # A file that isn't a model is refused by name.
        bad = self.path("bad.glb")
        bad.write_bytes(b"glTF and no more")
        result = self.in_blender(archive, [bad])
        self.assertNotEqual(result.returncode, 0)
        self.assertIn(f"{bad}: not a .glb file", result.stdout + result.stderr)


if __name__ == "__main__":
    if shutil.which("blender") is None:
        sys.exit("test_blender.py: there is no Blender: run deploy/install-deps --blender")
    harness.main()
