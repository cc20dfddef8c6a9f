#!/usr/bin/python3
"""Goal: deploy/figures remakes each of the documents' pictures by name, with its source, and
reports errors plainly.

Method: make pictures of requests that take a second in a temporary folder and compare them with
the committed ones, except for metadata; put a made-up program's table into a copy of the
documents; compare the list of figures with the documents; make wrong calls."""

import pathlib
import re
import shutil

import harness

METADATA = re.compile(r"<metadata>\n(.*?)</metadata>\n", re.DOTALL)


def figures(*words):
    return harness.run([root() / "deploy/figures", *words])


def root():
    return pathlib.Path(harness.arguments.source).resolve()


def listed():
    """Returns names with the place of each."""
    lines = [line.split() for line in figures("--list").stdout.splitlines()]
    return {line[0]: line[-1] for line in lines}


class FiguresTest(harness.ProgramTest):
    def made(self, name, file):
        result = figures("--bin", harness.arguments.bin, "--out", self.path("out"), name)
        self.assertEqual(result.returncode, 0, result.stderr)
        return self.path("out").joinpath(file).read_text()

    def test_pictures_are_the_committed_ones(self):
        for name in ("figure_2_3", "figure_2_4"):
            with self.subTest(name):
                made = self.made(name, f"{name}.svg")
                committed = (root() / f"docs/figures/{name}.svg").read_text()
                self.assertTrue(METADATA.sub("", made) == METADATA.sub("", committed),
                                f"another picture; `deploy/figures {name}` draws it anew")
                said = METADATA.search(made).group(1).splitlines()
                self.assertEqual(said[0], f"command: deploy/figures {name}")
                self.assertRegex(said[1], r"^commit: \w")
                self.assertEqual(said[2], "seed: 2000")

    def test_every_picture_and_table_is_listed_once(self):
        names = listed()
        for picture in (root() / "docs/figures").glob("*.svg"):
            command = METADATA.search(picture.read_text()).group(1).splitlines()[0]
            self.assertEqual(names.get(command.split()[-1]), "docs/figures", picture.name)
        for name, place in names.items():
            if place == "docs/figures":
                self.assertTrue(list((root() / place).glob(f"{name}*.svg")), name)
            else:
                marks = re.findall(rf"(?m)^ *<!-- table {name}: ", (root() / place).read_text())
                self.assertEqual(len(marks), 1, f"{name} in {place}")

    def test_a_table_is_put_into_its_document(self):
        tree = self.path("tree")
        for folder in ("deploy", "docs", "requests", "tests/thesis"):
            shutil.copytree(root() / folder, tree / folder)
        table = "| a | b |\n|---|---|\n| 1 | 2 |\n"
        (tree / "tests/thesis/ball_2d").write_text(f"print('a heading')\nprint({table!r})\n")
        document = tree / "docs/THESIS.md"
        before = document.read_text()

        def put():
            return harness.run([tree / "deploy/figures", "--bin", harness.arguments.bin, "--write",
                                "table_2_4"])

        self.assertEqual(put().returncode, 0)
        marked = r"<!-- table table_2_4: commit (\S+); deploy/figures table_2_4 -->\n"
        commit = re.search(marked, document.read_text()).group(1)
        self.assertIn(commit, harness.sleight("--version").stdout)
        new = f"<!-- table table_2_4: commit {commit}; deploy/figures table_2_4 -->\n{table}"
        self.assertEqual(document.read_text(), re.sub(marked + r"(?:\|.*\n)+", new, before))
        document.write_text(before.replace("<!-- table table_2_4:", "<!-- table table_2_5:"))
        self.assertRegex(put().stderr, "docs/THESIS.md: .*table_2_4.* 0$")

    def test_what_it_cannot_do(self):
        unknown = figures("figure_9_9")
        self.assertEqual(unknown.returncode, 2)
        self.assertIn("--list", unknown.stderr)
        missing = figures("--bin", self.path("nowhere"), "figure_2_3")
        self.assertEqual(missing.returncode, 1)
        self.assertRegex(missing.stderr, f"{self.path('nowhere')}: sleight$")
        self.path("failing").mkdir()
        program = self.path("failing") / "sleight"
        program.write_text("#!/bin/sh\n[ \"$1\" = --version ] && echo sleight 0.1.0+g1f2e || exit 3\n")
        program.chmod(0o755)
        failed = figures("--bin", program.parent, "--out", self.path("out"), "figure_2_3")
        self.assertEqual(failed.returncode, 1)
        self.assertIn("exit code 3 of: ", failed.stderr)
        self.assertFalse(self.path("out").exists())


if __name__ == "__main__":
    harness.main()
