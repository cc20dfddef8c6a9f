"""Goal: a run's results version changes with every source and flag that affects stored results, and with
nothing else. Method: change a file in each library's folder in turn, in a copy of the sources, and each flag
in a copy of the build's records. Ask the compiler what some sources include."""

import importlib
import json
import pathlib
import re
import shutil
import subprocess
import sys

import harness
from harness import ProgramTest

# Folders whose files don't affect stored results. All other library folders do.
AFTERWARDS = {"common/access", "common/archive", "common/archive/digest", "common/archive/hdf5",
              "common/archive/reader_program", "common/archive/remote", "common/config",
              "common/events", "common/failure_file", "common/hash", "common/json", "common/logging", "common/motion",
              "common/rpc", "common/scene", "common/schema", "common/schema/wire", "common/store", "worker/run/mpi",
              "worker/worlds/readers", "worker/worlds/segments"}


class ResultsVersion(ProgramTest):
    def setUp(self):
        super().setUp()
        self.source = pathlib.Path(harness.arguments.source)
        self.build = pathlib.Path(harness.arguments.bin).parent

    def results(self, build=None, *more):
        made = self.succeed(harness.run([self.source / "deploy/version", "--results",
                                         build or self.build, *more]))
        return made.stdout.strip()

    def deciding(self):
        return set(self.results(None, "--list").splitlines())

    def records(self):
        """A copy of the build's records."""
        copy = self.path("build")
        if not copy.exists():
            copy.mkdir()
            for name in [".ninja_deps", "compile_commands.json", "results_version.json"]:
                shutil.copy(self.build / name, copy / name)
        return copy

    def test_programs_say_it(self):
        said = self.succeed(harness.sleight("--version")).stdout
        self.assertIn(f"results {self.results()}\n", said)
        batch = self.succeed(harness.run([harness.program("sleight-batch"), "--version"])).stdout
        self.assertEqual(said, batch)

    def test_a_change_in_each_library(self):
        copy = self.path("source")
        for side in ["common", "worker", "service", "clients"]:
            shutil.copytree(self.source / side, copy / side)
        as_built = self.results()
        self.assertEqual(self.results(None, "--source", copy), as_built)
        listed = self.deciding()
        # In this process, because hundreds of programs would take a minute.
        sys.path.insert(0, str(self.source / "deploy/cmake"))
        deciding = importlib.import_module("results_version").Deciding(str(self.build))
        changed = 0
        for cmake in sorted(copy.rglob("CMakeLists.txt")):
            if "sleight_library(" not in cmake.read_text():
                continue
            folder = cmake.parent.relative_to(copy).as_posix()
            decides = folder not in AFTERWARDS and not folder.startswith(("service", "clients"))
            for file in sorted(cmake.parent.glob("*.cpp")) or sorted(cmake.parent.glob("*.h")):
                before = file.read_bytes()
                file.write_bytes(before + b"// planted\n")
                same = deciding.version(str(copy)) == as_built
                file.write_bytes(before)
                self.assertEqual(same, not decides, file)
                changed += decides
            for header in cmake.parent.glob("*.h"):
                if not decides:
                    self.assertNotIn(f"{folder}/{header.name}", listed)
        self.assertGreater(changed, 100)
        self.assertEqual(self.results(None, "--source", copy), as_built)

    def test_flags(self):
        as_built = self.results(self.records())
        self.assertEqual(as_built, self.results())
        commands = self.records() / "compile_commands.json"
        text = commands.read_text()
        self.assertIn(" -ffp-contract=off ", text)
        for before, after, decides in [("-ffp-contract=off", "-ffp-contract=fast", True),
                                       ("-std=c++20", "-std=c++20 -mavx2", True),
                                       ("-std=c++20", "-std=c++20 -DLESS=1", True),
                                       ("-std=c++20", "-std=c++20 -ffast-math", True),
                                       ("-std=c++20", "-std=c++20 -Ofast", True),
                                       ("-std=c++20", "-std=c++20 -Wp,-DLESS=1", True),
                                       ("-std=c++20", "-std=c++20 -O0 -g3 -Wextra", False),
                                       ("-std=c++20", "-std=c++20 -fsanitize=address", False)]:
            commands.write_text(text.replace(before, after))
            self.assertEqual(self.results(self.records()) != as_built, decides, after)
        # The same flag on other files is another version.
        versions = set()
        for name in ["unity_0_cxx.cxx", "unity_1_cxx.cxx"]:
            values = json.loads(text)
            for value in values:
                if value["file"].endswith("worker_sampling.dir/Unity/" + name):
                    value["command"] = value["command"].replace("-std=c++20", "-std=c++20 -mfma")
            commands.write_text(json.dumps(values))
            versions.add(self.results(self.records()))
        self.assertEqual(len(versions - {as_built}), 2)
        commands.write_text(text)
        settings = self.records() / "results_version.json"
        values = json.loads(settings.read_text())
        settings.write_text(json.dumps({**values, "compiler": "GNU 99"}))
        self.assertNotEqual(self.results(self.records()), as_built)

    def test_the_compiler_says_the_same(self):
        """Oracle: g++ -MM lists our headers, and all of them must be in the list."""
        listed = self.deciding()
        for source in ["worker/physics/simulator/simulation.cpp", "worker/sampling/swap.cpp",
                       "worker/run/catalogue.cpp"]:
            rule = subprocess.run(["g++", "-std=c++20", "-MM", "-I", self.source,
                                   "-isystem", "/usr/include/eigen3", self.source / source],
                                  capture_output=True, text=True, check=True).stdout
            names = {str(pathlib.Path(word).relative_to(self.source))
                     for word in re.sub(r"\\\n", " ", rule).split()[1:]}
            ours = {name for name in names
                    if not name.startswith(tuple(folder + "/" for folder in AFTERWARDS))}
            self.assertGreater(len(ours), 5)
            self.assertLessEqual(ours, listed, source)

    def test_what_it_cannot_do(self):
        for name, words in [(".ninja_deps", "No such file"),
                            ("results_version.json", "results_version.json")]:
            copy = self.records()
            (copy / name).unlink()
            result = harness.run([self.source / "deploy/version", "--results", copy])
            self.assertEqual(result.returncode, 1)
            self.assertIn(words, result.stderr)
            shutil.rmtree(copy)
        (self.records() / ".ninja_deps").write_bytes(b"something else")
        result = harness.run([self.source / "deploy/version", "--results", self.records()])
        self.assertIn("is no record of Ninja's", result.stderr)


if __name__ == "__main__":
    harness.main()
