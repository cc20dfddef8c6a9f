#!/usr/bin/env python3
"""Goal: the checks of documents, and of the sources of their pictures and tables, find faults and accept
correct trees.

Method: as in test_tidy.py, use small trees with a single fault each.
"""

import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from test_tidy import TidyTest  # noqa: E402


class Documents(TidyTest):
    # Assembled here, so that the check doesn't find citations of this project's own.
    GUIDE = "docs/" + "GUIDE"
    ARCHITECTURE = "docs/ARCHITECTURE.md"

    def documents(self):
        """A glossary with names in the code, a row for a folder, links that resolve, a citation."""
        return {
            "README.md": f"[guide]({self.GUIDE}.md#how-it-works-so) and [code](common/base), "
                         "![picture](docs/a.svg), [home](https://example.com/x), `[no](link)`\n"
                         "```\n[no](link)\n```\n",
            "docs/a.svg": "<svg/>\n",
            f"{self.GUIDE}.md": "# Guide\n[here](#how-it-works-so), [up](../README.md)\n"
                                "## How it works: `so`\n",
            "docs/GLOSSARY.md": "| clock | `base::Clock` | `common/base/clock.h` |\n",
            self.ARCHITECTURE: "| `common/base` | basics; not `worker/maps` |\n",
            "common/base/CMakeLists.txt": "# Basics.\nsleight_library()\n",
            "common/base/clock.h":
                f'// See {self.GUIDE}.md, "How it\n// works: `so`".\nnamespace base {{\n'
                "class Clock {};  // Watch\n}\n",
        }

    def assert_finds_in(self, path, text, *expected):
        self.assert_finds({**self.documents(), path: text}, "documents", *expected)

    def test_what_holds_together_passes(self):
        self.assert_clean(self.documents(), "documents")

    def test_dead_links(self):
        self.assert_finds_in("README.md", "a\n[x](docs/gone.md) [y](common/gone)\n",
                             ("README.md:2", "dead link: common/gone"),
                             ("README.md:2", "dead link: docs/gone.md"))

    def test_links_are_relative_to_their_document(self):
        self.assert_finds_in("docs/more.md", "[x](README.md)\n",
                             ("docs/more.md:1", "there is no docs/" + "README.md"))

    def test_dead_anchors(self):
        for link, words in ((f"[x]({self.GUIDE}.md#gone)", "has no such heading"),
                            ("[x](#gone)", "README.md has no such heading"),
                            ("[x](docs/a.svg#gone)", "has no such heading")):
            with self.subTest(link):
                self.assert_finds_in("README.md", f"# A\n{link}\n", ("README.md:2", words))

    def test_a_heading_in_a_fence_is_none(self):
        self.assert_finds_in("README.md", "```\n# Made\n```\n[x](#made)\n",
                             ("README.md:4", "has no such heading"))

    def test_documents_that_code_cites(self):
        for cited, words in ((f"{self.GUIDE}.md, \"What it's not\"", "\"What it's not\""),
                             ("docs/" + "GONE.md", "which there is not"),
                             ("docs/" + "GONE", "which there is not"),
                             ("docs/" + "notebook/gone.md", "which there is not")):
            with self.subTest(cited):
                self.assert_finds_in("common/base/more.h", f"// A.\n// See {cited}.\n",
                                     ("common/base/more.h:2", words))

    def test_names_of_the_glossary_that_no_code_has(self):
        known = "| clock | `common/base/clock.h` |\n"
        self.assert_finds_in("docs/GLOSSARY.md", known + "| time | `base::Watch` |\n",
                             ("docs/GLOSSARY.md:2", "no code has the name Watch"))
        self.assert_finds_in("docs/GLOSSARY.md", known + "| time | `common/base/watch.h` |\n",
                             ("docs/GLOSSARY.md:2", "there is no common/base/watch.h"))

    def test_folders_without_a_row(self):
        self.assert_finds_in("worker/maps/CMakeLists.txt", "# Maps.\nsleight_library()\n",
                             ("worker/maps/CMakeLists.txt:1", "no table row for worker/maps"))
        for text in ("`common/base` is no row\n", "```\n| `common/base` | in a fence |\n```\n"):
            with self.subTest(text):
                self.assert_finds_in(self.ARCHITECTURE, text,
                                     ("common/base/CMakeLists.txt:1", "no table row for common/base"))


class Provenance(TidyTest):
    COMMAND = '#!/usr/bin/env python3\nENTRIES = {"figure_1": 1, "table_1": 2}\n'
    MARK = "<!-- table table_1: commit 1f2e3d4; deploy/figures table_1 -->\n"
    NUMBERS = "| n | s |\n|---|--:|\n| 1 | 2 |\n"

    def picture(self, **changes):
        notes = {"command": "deploy/figures figure_1", "commit": "1f2e3d4", "seed": "7", **changes}
        lines = "".join(f"{name}: {value}\n" for name, value in notes.items() if value)
        return f"<svg>\n<metadata>\n{lines}</metadata>\n</svg>\n"

    def assert_finds_in(self, path, text, *expected):
        self.assert_finds({"deploy/figures": self.COMMAND, path: text}, "provenance", *expected)

    def test_pictures_and_tables_that_say_it_pass(self):
        self.assert_clean({
            "deploy/figures": self.COMMAND,
            "docs/figures/figure_1.svg": self.picture(),
            "docs/figures/figure_1_right.svg": self.picture(),
            "docs/A.md": f"Text.\n\n{self.MARK}{self.NUMBERS}\n| word | meaning |\n|---|---|\n",
            "docs/" + "notebook/b.md":
                "- a list:\n\n  <!-- table b: commit 1f2e3d4; not remade: its code is gone -->\n"
                "  | n | s |\n  |---|---|\n",
            "README.md": self.NUMBERS,
        }, "provenance")

    def test_pictures(self):
        path = "docs/figures/figure_1.svg"
        for text, words in (("<svg></svg>\n", "without metadata"),
                            (self.picture(command=""), "has no command"),
                            (self.picture(commit=""), "has no commit"),
                            (self.picture(seed=""), "has no seed"),
                            (self.picture(seed="any"), "seed is no number"),
                            (self.picture(command="sleight plot a.h5"), "is not deploy/figures NAME"),
                            (self.picture(command="deploy/figures figure_2"), "has no figure_2"),
                            (self.picture(command="deploy/figures table_1"), "another picture"),
                            (self.picture(commit="1f2e3d4.dirty.0a1b"), "is no commit")):
            with self.subTest(words):
                self.assert_finds_in(path, text, (path + ":1", words))

    def test_a_picture_of_another_name(self):
        for path in ("docs/figures/figure_10.svg", "docs/figures/right.svg"):
            self.assert_finds_in(path, self.picture(), (path + ":1", "makes another picture"))

    def test_tables_without_a_mark(self):
        self.assert_finds_in("docs/A.md", "Text.\n\n" + self.NUMBERS,
                             ("docs/A.md:3", "without a line <!-- table"))
        self.assert_finds_in("docs/A.md", self.MARK + "\n" + self.NUMBERS,
                             ("docs/A.md:1", "no table stands below"),
                             ("docs/A.md:3", "without a line <!-- table"))
        self.assert_finds_in("docs/A.md", self.NUMBERS, ("docs/A.md:1", "without a line"))
        self.assert_finds_in("docs/MEASUREMENTS.md", "# A\n| a | b |\n|---|---|\n",
                             ("docs/MEASUREMENTS.md:2", "without a line"))

    def test_marks(self):
        for mark, words in (("<!-- table table_1 -->", "not <!-- table NAME"),
                            ("<!-- table table_1: commit 1f2e3d4 -->", "not <!-- table NAME"),
                            ("<!-- table table_1: deploy/figures table_1 -->", "not <!-- table NAME"),
                            ("<!-- table table_1: commit 1f2e3d4; deploy/figures table_1",
                             "not <!-- table NAME"),
                            ("<!-- table table_1: commit yesterday; deploy/figures table_1 -->",
                             "is no commit"),
                            ("<!-- table table_1: commit 1f2e3d4; by hand -->", "its command is"),
                            ("<!-- table table_1: commit 1f2e3d4; deploy/figures table_2 -->",
                             "its command is"),
                            ("<!-- table table_2: commit 1f2e3d4; deploy/figures table_2 -->",
                             "has no table_2"),
                            ("<!-- table table_1: commit 1f2e3d4; not remade: why -->", "reason needs")):
            with self.subTest(mark):
                self.assert_finds_in("docs/A.md", f"\n{mark}\n{self.NUMBERS}",
                                     ("docs/A.md:2", words))

    def test_a_name_comes_once(self):
        self.assert_finds_in("docs/A.md", (self.MARK + self.NUMBERS + "\n") * 2,
                             ("docs/A.md:6", "has a table table_1 too"))


if __name__ == "__main__":
    unittest.main()
