"""Goal: archives of format 2 are verified, listed and exported as ever; of pictures those that need no scene
and no prior are drawn, and what they lack is said.
Method: archives that sleight 0.1.0 of commit 4aed61e wrote, of each world."""

import json
import lzma
import pathlib

import harness
from harness import ProgramTest, sleight

FOLDER = "tests/archive_readers/format_2"
PICTURES = {"ball": ["trace", "paths"], "spelling": ["trace"], "dice": ["trace"]}
LACKING = {"ball": {"animations": "scene"}, "spelling": {"animations": "scene"},
           "dice": {"animations": "scene", "plausibility": "prior to compare with"}}


class OldArchives(ProgramTest):
    def old(self, world):
        packed = pathlib.Path(harness.arguments.source) / FOLDER / f"{world}.h5.xz"
        path = self.path(f"{world}.h5")
        path.write_bytes(lzma.decompress(packed.read_bytes()))
        return path

    def test_they_are_read_as_ever(self):
        for world, pictures in PICTURES.items():
            archive = self.old(world)
            self.succeed(sleight("archive", "verify", archive))
            info = self.succeed(sleight("archive", "info", archive, "--json"))
            self.assertEqual(json.loads(info.stdout)["format_version"], 2)
            for table in ["posterior", "animations", "segments"]:
                rows = self.succeed(sleight("archive", "export", archive, "--csv", "--table", table)).stdout
                self.assertGreater(len(rows.splitlines()), 1, table)
            for what in pictures:
                picture = self.path(f"{what}.svg")
                self.succeed(sleight("plot", archive, "--what", what, "-o", picture))
                self.assertNotIn("nan", picture.read_text())

    def test_what_they_lack_is_said(self):
        archive = self.old("ball")
        for table in ["features", "prior", "points"]:
            result = sleight("archive", "export", archive, "--csv", "--table", table)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn(f"this archive has no table '{table}'", result.stderr)
        for world, pictures in LACKING.items():
            archive = self.old(world)
            for what, lacking in pictures.items():
                picture = self.path(f"{world}_{what}.svg")
                result = sleight("plot", archive, "--what", what, "-o", picture)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn(f"{archive}: archives of its format, 2, have no {lacking}; make a newer one of "
                              "its run, by `sleight archive derive`, or direct its request again",
                              result.stderr)
                self.assertFalse(picture.exists())


if __name__ == "__main__":
    harness.main()
