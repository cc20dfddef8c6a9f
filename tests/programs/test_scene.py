"""Goal: a person can describe a scene, check it and see it. Method: run the commands of docs/SCENES, and check scenes
that can't be simulated."""

import json
import pathlib
import re

import h5py
import harness
from harness import ProgramTest, sleight


class Scene(ProgramTest):
    def page(self):
        return (pathlib.Path(harness.arguments.source) / "docs/SCENES.md").read_text()

    def tray(self):
        path = self.path("tray.toml")
        path.write_text(re.search(r"```toml\n(\[world\].*?)```", self.page(), re.S)[1])
        return path

    def check(self, path, *options):
        return sleight("scene", "check", path, *options)

    def test_the_page_as_printed(self):
        path = self.tray()
        command = re.search(r"```sh\n(sleight scene check .*)\n```", self.page())[1].split()
        self.assertEqual(command[:4], ["sleight", "scene", "check", "tray.toml"])
        drawing = self.path("tray.svg")
        text = self.succeed(self.check(path, "--draw", drawing)).stdout
        for name in ["die 1 to die 5", "wall 4", "table", "resin", "4.9152"]:
            self.assertIn(name, text)
        self.assertEqual(len(re.findall(r">\d\.\d\d s<", drawing.read_text())), 8)
        report = json.loads(self.succeed(self.check(path, "--json")).stdout)
        die = next(one for one in report["objects"] if one["name"] == "die 1")
        self.assertAlmostEqual(die["mass_kg"], 1200 * 0.016**3)
        self.assertEqual(report["overlaps"], [])
        for body in report["run"]["bodies"]:
            self.assertEqual(body["end"], "rests", body)
            self.assertLess(abs(body["place_m"][0]), 0.1, body)

    def test_from_nothing_to_the_first_take(self):
        path = self.tray()
        blocks = re.findall(r"```toml\n(.*?)```", self.page(), re.S)
        path.write_text(path.read_text() + blocks[1])
        report = json.loads(self.succeed(self.check(path, "--draws", 60, "--json")).stdout)
        self.assertEqual(report["prior_draws"]["count"], 60)
        self.assertEqual([one["name"] for one in report["constraints"]], [f"die face: die {i}" for i in range(1, 6)])
        drawing = self.path("draws.svg")
        self.succeed(self.check(path, "--draw", drawing))
        self.assertEqual(len(set(re.findall(r"prior draw (\d+)", drawing.read_text()))), 9)
        # The commands of the page, but not the gallery.
        direct, gallery = re.findall(r"^sleight (?:direct|gallery) .*", self.page(), re.M)[:2]
        self.assertEqual(gallery, "sleight gallery tray.h5")
        archive = self.path("tray.h5")
        self.assertEqual(direct, "sleight direct tray.toml -o tray.h5")
        self.succeed(sleight("direct", path, "-o", archive))
        self.succeed(sleight("archive", "verify", archive))
        with h5py.File(archive) as file:
            self.assertEqual(len(file["finds/animation"]), 5)
            names = [b"".join(name).decode().rstrip("\0") for name in file["sample_stats/constraint"][:]]
            self.assertEqual(names, [f"die face: die {i}" for i in range(1, 6)])
        for command in [("find",), ("groups",), ("export", "--together", "-o", self.path("takes.glb"))]:
            self.succeed(sleight(command[0], archive, *command[1:]))
        # Chains that start from a search give the model's proportions.
        path.write_text(path.read_text().replace("count = 5", "count = 1"))
        one = self.path("one.h5")
        self.succeed(sleight("direct", path, "-o", one, "--in-proportion"))
        self.succeed(sleight("export", one, "--together", "-o", self.path("one.glb")))

    def test_the_pages_helix(self):
        path = self.path("helix.toml")
        blocks = re.findall(r"```toml\n(.*?)```", self.page(), re.S)
        helix = next(block for block in blocks if 'shape = "helix"' in block)
        note = next(block for block in blocks if "first note" in block)
        path.write_text(helix + note)
        report = json.loads(self.succeed(self.check(path, "--json")).stdout)
        self.assertAlmostEqual(report["run"]["bodies"][0]["place_m"][2], -0.192, 3)

    def test_the_page_lists_each_shape_and_its_keys(self):
        keys = self.succeed(sleight("keys", "scene")).stdout
        table = self.page().split("## Shapes")[1].split("## ")[0]
        rows = re.findall(r"^\| `(\w+)`.*", table, re.M)[1:]
        self.assertEqual(len(rows), 13)
        for row in rows:
            self.assertIn(f'"{row}"', keys)
        for name in re.findall(r"`(\w+_mm|steps|strips|turns|triangles|closed|density_kgpm3)`", table):
            self.assertRegex(keys, rf"(?m)^  {name} ")

    def test_overlaps_are_all_listed(self):
        path = self.tray()
        path.write_text(path.read_text().replace("step_mm = [0, 30, 0]", "step_mm = [0, 10, 0]"))
        result = self.check(path, "--json")
        self.assertEqual(result.returncode, 3, result.stderr)
        pairs = {(one["a"], one["b"]) for one in json.loads(result.stdout)["overlaps"]}
        self.assertLessEqual({(f"die {i}", f"die {i + 1}") for i in range(1, 5)}, pairs)
        text = self.check(path)
        self.assertEqual(text.returncode, 3)
        self.assertRegex(text.stdout, r"die 4.*die 5.*mm")

    def test_a_search_without_finds_says_why(self):
        path = self.path("never.toml")
        path.write_text("""
[world]
name = "scene"
end_s = 0.05
[[world.body]]
name = "ball"
radius_mm = 5
[[world.body]]
name = "floor"
shape = "plane"
at_mm = [0, 0, -500]
[[world.uncertain]]
body = "ball"
quantity = "velocity_mps"
normal_sd = [0.1, 0.1, 0.1]
[[constraint.event]]
name = "too early"
body = "ball"
hits = "floor"
at_s = 0.02
tolerance_s = 0.001
sigma_s = 0.001
""")
        whys = set()
        for threads in (1, 3):
            output = self.path(f"{threads}.h5")
            said = json.loads(self.direct(path, output, "-j", threads, "--json").stdout)
            self.assertFalse(output.exists())
            whys.add(said["gave_up_because"])
        (why,) = whys
        self.assertIn(why, self.direct(path, output).stdout)  # resumed
        self.assertRegex(why, r"\b64\b")

    def test_a_scene_without_uncertainty_is_sampled_with_a_warning(self):
        path = self.tray()
        output = self.path("tray.h5")
        run = self.succeed(sleight("direct", path, "-o", output, "--set", "sampler.method=splitting",
                                   "--set", "sampler.particles=2", "--set", "stop.odds=1"))
        self.assertIn("nothing is uncertain, so all animations are the same", run.stderr)
        self.assertIn("log P 0.00 +- 0.00", run.stdout)
        self.succeed(sleight("archive", "verify", output))

    def test_errors_have_places(self):
        path = self.path("bad.toml")
        path.write_text('[world]\nname = "scene"\n[[world.body]]\nname = "a"\nshape = "box"\nsize_mm = [1, 2]\n')
        result = self.check(path)
        self.assertEqual(result.returncode, 3)
        self.assertRegex(result.stderr, r"bad\.toml:6:\d+: 'size_mm' in \[\[world\.body\]\]")
        self.assertEqual(self.check(self.path("none.toml")).returncode, 5)


if __name__ == "__main__":
    harness.main()
