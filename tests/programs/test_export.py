"""Goal: `sleight export` writes the requested animations as valid glTF and as tables that equal the archive,
and damages no file. Method: export small runs of each world, and a made-up archive with finds. Check the glTF
with Khronos's validator, and compare a few poses and tables with h5py's values."""

import csv
import io
import json
import pathlib
import re
import signal
import struct
import time

import h5py
import harness
from harness import ProgramTest, run, sleight
from test_spelling import REQUEST as SPELLING

BALL = """
[world]
name = "ball_2d"
[constraint]
tolerance_diameters = 5
sigma_diameters = 5
[sampler]
method = "metropolis_hastings"
chains = 4
seed = 1
[stop]
scans = 100
[output]
thin = 1
min_distance = 0.001
keep_per_lineage = 1000
"""

DICE = """
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
chains = 1
seed = 4
[stop]
scans = 20
[output]
thin = 1
"""

class Model:
    """A .glb file, parsed by the specification."""

    def __init__(self, path):
        data = path.read_bytes()
        magic, version, length, json_bytes, kind = struct.unpack_from("<4sIII4s", data)
        assert (magic, version, length, kind) == (b"glTF", 2, len(data), b"JSON")
        self.text = data[20:20 + json_bytes]
        self.json = json.loads(self.text)
        self.binary = data[28 + json_bytes:]
        self.clips = [clip["name"] for clip in self.json["animations"]]

    def floats(self, number):
        accessor = self.json["accessors"][number]
        view = self.json["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        rows = struct.iter_unpack(f"<{width}f", self.binary[view["byteOffset"]:][:view["byteLength"]])
        return list(rows)

    def keys(self, node_name, path, clip=0):
        """Times and values."""
        animation = self.json["animations"][clip]
        for channel in animation["channels"]:
            target = channel["target"]
            if (self.json["nodes"][target["node"]]["name"], target["path"]) == (node_name, path):
                sampler = animation["samplers"][channel["sampler"]]
                return ([time for time, in self.floats(sampler["input"])],
                        self.floats(sampler["output"]))
        raise KeyError(node_name)


class Export(ProgramTest):
    def run_of(self, world, text):
        request = self.path(f"{world}.toml")
        request.write_text(text)
        self.direct(request, self.path(f"{world}.h5"))
        return self.path(f"{world}.h5")

    def made_up(self):
        """Twenty animations of chains and seven finds, of a made-up world."""
        writer = pathlib.Path(harness.arguments.bin).parent / "tests/sleight-sample-archive"
        self.succeed(run([writer, self.path("made_up.h5"), "100"]))
        return self.path("made_up.h5")

    def export(self, *args):
        return self.succeed(sleight("export", *args)).stdout

    def refused(self, code, words, *args):
        result = sleight("export", *args)
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertIn(words, result.stderr)

    def table(self, archive, *args):
        return list(csv.DictReader(io.StringIO(self.export(archive, "--format", "csv", *args))))

    def test_models_of_each_world(self):
        archives = [self.run_of("dice", DICE), self.run_of("spelling", SPELLING), self.made_up(),
                    self.run_of("ball", BALL)]
        files = []
        for archive in archives:
            world = archive.stem
            ids = [row["id"] for row in self.table(archive)][:3]
            told = json.loads(self.export(archive, "--ids", *ids, "-o", self.path(world), "--json"))
            self.assertEqual(told["archive"], str(archive))
            self.assertEqual([written["ids"] for written in told["written"]], [[one] for one in ids])
            each = [pathlib.Path(written["path"]) for written in told["written"]]
            run_id = re.sub(r"[^0-9A-Za-z]", "", self.info(archive)["run_id"])[:8]
            self.assertEqual([path.name for path in each], [f"{run_id}-{one}.glb" for one in ids])
            self.assertEqual(sorted(each), sorted(self.path(world).iterdir()))
            self.assertEqual([path.stat().st_size for path in each],
                             [written["bytes"] for written in told["written"]])
            together = self.path(f"{world}.glb")
            self.export(archive, "--ids", *ids, "--together", "--fps", "24", "-o", together)
            self.assertEqual(Model(together).clips, ids)
            self.bodies_are_where_the_archive_says(archive, each, ids)
            files += [*each, together]
        validator = pathlib.Path(harness.arguments.source) / "tests/gltf/validate.js"
        judged = self.succeed(run(["node", validator, *files]))
        self.assertIn(f"{len(files)} files judged", judged.stdout)
        # The validator detects an invalid file.
        bad = self.path("bad.glb")
        bad.write_bytes(files[0].read_bytes().replace(b'"LINEAR"', b'"CURVED"'))
        self.assertEqual(run(["node", validator, bad]).returncode, 1)

    def bodies_are_where_the_archive_says(self, archive, files, ids):
        with h5py.File(archive) as file:
            group = file["animations"]
            request = file["request"].asstr()[()]
            for path, one in zip(files, ids):
                model = Model(path)
                self.assertEqual(model.json["asset"]["extras"]["request"], request)
                extras = model.json["animations"][0]["extras"]
                self.assertEqual(extras["id"], one)
                nth = next(i for i in range(len(group["chain"]))
                           if one == f"c{group['chain'][i]}.{group['draw'][i]}")
                self.assertEqual(extras["log_prior"], group["log_prior"][nth])
                self.assertEqual(extras["lineage"], group["lineage"][nth])
                self.assertEqual(extras["in_proportion"], bool(group["in_proportion"][nth]))
                first, count = group["segment_start"][nth], group["segment_count"][nth]
                last = {}
                for i in range(first, first + count):
                    last[int(group["body"][i])] = i
                bodies = [node["name"] for node in model.json["nodes"]
                          if node["extras"]["kind"] == "body"]
                self.assertEqual(len(bodies), len(last))
                for name, body in zip(bodies, sorted(last)):
                    times, places = model.keys(name, "translation")
                    x, y, z = group["position_m"][last[body]]
                    start_s = group["start_s"][last[body]]
                    # At a jump of a made-up motion, use the second of two keys.
                    key = max(i for i, time in enumerate(times) if time <= start_s + 1e-5)
                    self.assertAlmostEqual(times[key], start_s, places=5)
                    for shown, true in zip(places[key], [x, z, -y]):
                        self.assertAlmostEqual(shown, true, places=5)

    def test_the_same_bytes_and_only_our_files(self):
        archive = self.made_up()
        one, two = self.path("one.glb"), self.path("two.glb")
        self.export(archive, "--together", "-o", one)
        self.export(archive, "--together", "-o", two)
        self.assertEqual(one.read_bytes(), two.read_bytes())
        # Our own models are replaced, other files only with --force. The same holds in folders.
        self.export(archive, "--ids", "find.3", "-o", one)
        self.assertEqual(Model(one).clips, ["find.3"])
        self.export(archive, "--ids", "find.3", "-o", self.path("folder/deep"))
        in_folder = next(self.path("folder/deep").iterdir())
        self.assertEqual(in_folder.read_bytes(), one.read_bytes())
        for theirs, output in [(two, two), (in_folder, in_folder.parent)]:
            theirs.write_bytes(b"glTF of somebody else")
            self.refused(4, f"{theirs}: already exists", archive, "--ids", "find.3", "-o", output)
            self.assertEqual(theirs.read_bytes(), b"glTF of somebody else")
            self.export(archive, "--ids", "find.3", "-o", output, "--force")
            self.assertEqual(theirs.read_bytes(), one.read_bytes())
        self.refused(2, "is the archive itself", archive, "--ids", "find.3", "--force",
                     "--format", "csv", "-o", self.linked(archive, "link.csv"))
        left = {path.name for path in self.folder.rglob("*")}
        self.assertEqual({name for name in left if name.startswith(".") or "export" in name}, set())

    def linked(self, archive, name):
        self.path(name).symlink_to(archive)
        return self.path(name)

    def test_ids(self):
        archive = self.made_up()
        rows = self.table(archive)
        self.assertEqual(len(rows), 27)
        first, last = rows[0]["id"], rows[-1]["id"]
        self.assertEqual(last, "find.6")
        # In the requested order, each once.
        asked = [last, first, last]
        self.assertEqual([row["id"] for row in self.table(archive, "--ids", *asked)], [last, first])
        output = self.path("a.glb")
        self.export(archive, "--ids", *asked, "--together", "-o", output)
        self.assertEqual(Model(output).clips, [last, first])
        for unknown in ["c9.9", "find.7", "\x1b[31m"]:
            result = sleight("export", archive, "--ids", unknown, "-o", self.path("b.glb"))
            self.assertEqual(result.returncode, 2)
            self.assertIn(f"the archive has {first}, ", result.stderr)
            self.assertNotIn("\x1b", result.stderr)
        self.assertFalse(self.path("b.glb").exists())

    def test_without_ids_not_without_end(self):
        archive = self.run_of("ball", BALL)
        count = len(self.table(archive))
        self.assertGreater(count, 100)
        result = sleight("export", archive, "-o", self.path("all"))
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertRegex(result.stderr, rf"\b{count} animations\b.*\b100\b")
        self.assertFalse(self.path("all").exists())
        self.assertIn(f"{count} animations, {count} files",
                      self.export(archive, "--all", "-o", self.path("all")))
        self.assertEqual(len(list(self.path("all").iterdir())), count)

    def test_queries_and_representatives(self):
        archive = self.run_of("ball", BALL)
        found = json.loads(self.succeed(sleight("find", archive, "--where", "ball in x 0.. z 0.2..",
                                                "--where", "draw < 60", "--json")).stdout)
        ids = [one["id"] for one in found["animations"]]
        self.assertGreater(len(ids), 3)
        selection = ["--select", "ball in x 0.. z 0.2..", "--select", "draw < 60"]
        self.assertEqual([row["id"] for row in self.table(archive, *selection)], ids)
        groups = json.loads(self.succeed(sleight("groups", archive, "-k", 3, "--where", "draw < 60",
                                                 "--json")).stdout)
        self.export(archive, "--select", "draw < 60", "--representatives", "3", "--together", "-o",
                    self.path("kinds.glb"))
        self.assertEqual(Model(self.path("kinds.glb")).clips,
                         [group["representative"]["id"] for group in groups["groups"]])
        # An animation's long name belongs to its run only.
        run = found["archives"][0]["run_id"][:8]
        self.assertEqual(len(self.table(archive, "--ids", f"{run}:{ids[0]}")), 1)
        self.refused(2, "no animation", archive, "--ids", f"00000000:{ids[0]}", "-o", self.path("a.glb"))

    def test_told_to_stop_it_leaves_nothing(self):
        archive = self.made_up()
        for told in [signal.SIGINT, signal.SIGTERM]:
            out = self.path(f"out{told}")
            process = harness.start([harness.program("sleight"), "export", archive, "--format", "png",
                                     "--scale", "8", "--fps", "1000", "-o", out])
            # In the middle of an export, frames exist and the folder doesn't have its final name yet.
            end = time.monotonic() + 60
            while not list(out.glob("*.tmp.*/*.png")):
                self.assertLess(time.monotonic(), end)
                self.assertIsNone(process.poll())
                time.sleep(0.02)
            process.send_signal(told)
            process.wait(timeout=60)
            self.assertEqual(process.returncode, 130, process.stderr.read())
            self.assertEqual([path for path in out.iterdir() if "tmp" in path.name], [])

    def test_tables(self):
        archive = self.made_up()
        with h5py.File(archive) as file:
            # Chains' animations, then finds, each with its columns. Missing values are empty.
            rows = self.table(archive)
            count = len(file["animations/chain"])
            self.assertEqual([row["log_prior"] for row in rows[:count]],
                             [repr(float(value)) for value in file["animations/log_prior"]])
            self.assertEqual([row["start"] for row in rows[:count]], [""] * count)
            self.assertEqual([row["start"] for row in rows[count:]],
                             [str(start) for start in file["finds/start"]])
            self.assertEqual([row["chain"] for row in rows[count:]], [""] * (len(rows) - count))
            # Segments of three animations in the requested order.
            places = [len(rows) - 1, 1, 0]
            ids = [rows[place]["id"] for place in places]
            segments = self.table(archive, "--ids", *ids, "--table", "segments")
            expected = []
            for one, place in zip(ids, places):
                group = file["finds" if place >= count else "animations"]
                nth = place % count
                first = group["segment_start"][nth]
                expected += [(one, repr(float(group["start_s"][i])).removesuffix(".0"))
                             for i in range(first, first + group["segment_count"][nth])]
            self.assertGreater(len(expected), len(ids))
            self.assertEqual([(row["id"], row["start_s"].removesuffix(".0")) for row in segments],
                             expected)
        output = self.path("t.csv")
        self.export(archive, "--format", "csv", "-o", output)
        self.assertEqual(output.read_text(), self.export(archive, "--format", "csv"))
        self.refused(4, "--force", archive, "--format", "csv", "-o", output)

    def test_what_it_cannot_do(self):
        archive = self.made_up()
        output = self.path("a.glb")
        none = self.path("none.toml")
        none.write_text(BALL.replace("tolerance_diameters = 5", "tolerance_diameters = 1e-6"))
        self.direct(none, self.path("none.h5"))
        for code, words, args in [
                (2, "-o is required", [archive]),
                (2, "--ids: expected", [archive, "--ids=", "-o", output]),
                (2, "must end in .glb", [archive, "--together", "-o", self.path("a")]),
                (2, "add --together", [archive, "-o", output]),
                (2, "ends in .csv", [archive, "--format", "csv", "-o", output]),
                (2, "--fps requires", [archive, "--format", "csv", "--fps", "24"]),
                (2, "--together requires", [archive, "--format", "svg", "--together", "-o", output]),
                (2, "--view and --scale require", [archive, "--view", "front", "-o", output]),
                (2, "--scale 9", [archive, "--format", "png", "--scale", "9", "-o", self.path("f")]),
                (2, "-o is required", [archive, "--format", "png"]),
                (2, "--ids can't be combined", [archive, "--ids", "0.1", "--select", "draw < 3", "-o", output]),
                (2, "column 13: ", [archive, "--select", "log_prior < low", "-o", output]),
                (2, "no animation matches --select", [archive, "--select", "draw < 0", "-o", output]),
                (2, "requires -o", [archive, "--format", "csv", "--json"]),
                (2, "--table", [archive, "--format", "csv", "--table", "posterior"]),
                (2, "--format", [archive, "--format", "obj", "-o", output]),
                (2, ".mov", [archive, "--format", "mp4", "-o", self.path("a.mov")]),
                (2, ".png", [archive, "-o", self.path("a.png")]),
                (2, "--table requires", [archive, "--table", "points", "-o", output]),
                (5, "can't write", [archive, "--together", "-o", self.path("no/folder/a.glb")]),
                (5, "this folder", [archive, "-o", archive / "folder"]),
                (5, "no.h5: can't open", [self.path("no.h5"), "-o", output]),
                (6, "", [none, "-o", output]),
                (2, "has no animations", [self.path("none.h5"), "-o", output])]:
            self.refused(code, words, *args)
        self.assertFalse(output.exists())


if __name__ == "__main__":
    harness.main()
