#!/usr/bin/env python3
"""Goal: each check of tidy finds what it is for, at its place, and leaves good code alone.

Method: for each, small trees in a temporary folder: one with a single fault, where file, line and
message are compared, and one without.
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import rules  # noqa: E402
from rules import commented_code  # noqa: E402
from rules.tree import Source, Tree, without_git  # noqa: E402

HEADER = "// What it is for.\n#pragma once\n"


def write(root, files):
    for path, text in files.items():
        target = pathlib.Path(root) / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(text, encoding="utf-8")
        if text.startswith("#!"):
            target.chmod(0o755)


class TidyTest(unittest.TestCase):
    def findings(self, files, check):
        """What a check says of a tree of these files, without the check's name."""
        with tempfile.TemporaryDirectory() as root:
            write(root, files)
            return [str(f).rsplit(" [", 1)[0] for f in rules.run(Tree(root), [check])]

    def assert_finds(self, files, check, *expected):
        """Each finding starts with `file:line: ` and holds the words, in order."""
        found = self.findings(files, check)
        self.assertEqual(len(found), len(expected), found)
        for said, (place, words) in zip(found, expected):
            self.assertTrue(said.startswith(place + ": "), f"{said} is not at {place}")
            self.assertIn(words, said)

    def assert_clean(self, files, check):
        self.assertEqual(self.findings(files, check), [])


def project():
    """A small project that obeys the law."""
    return {
        "common/base/CMakeLists.txt": "sleight_library(SOURCES check.cpp LINKS fmt::fmt)\n",
        "common/base/check.h": HEADER,
        "common/base/check.cpp": '#include "common/base/check.h"\n',
        "common/math/CMakeLists.txt": "# Numbers.\nsleight_library(LINKS common_base)\n",
        "common/math/vector.h": HEADER + '#include "common/base/check.h"\n',
        "worker/physics/CMakeLists.txt": "sleight_library(LINKS common_math)\n",
        "worker/physics/body.h": HEADER + '#include "common/base/check.h"\n',
        "worker/sampling/CMakeLists.txt": "sleight_library(LINKS common_base)\n",
        "worker/sampling/chain.h": HEADER,
        "service/core/CMakeLists.txt": "sleight_library(LINKS common_base)\n",
        "service/core/step.h": HEADER,
        "worker/run/CMakeLists.txt":
            "sleight_library(LINKS worker_physics)\n"
            "sleight_program(sleight-batch SOURCES main.cpp LINKS worker_run service_core)\n",
        "worker/run/main.cpp":
            '#include "service/core/step.h"\n#include "worker/physics/body.h"\n',
    }


class Dependencies(TidyTest):
    def with_files(self, files):
        return {**project(), **files}

    def test_a_lawful_project_passes(self):
        self.assert_clean(project(), "dependencies")

    def test_include_without_link(self):
        self.assert_finds(
            self.with_files({"worker/sampling/chain.h": HEADER + '#include "common/math/vector.h"\n'}),
            "dependencies", ("worker/sampling/chain.h:3", "without a link to common_math"))

    def test_links_are_followed_through_others(self):
        self.assert_clean(
            self.with_files({"worker/run/loop.h": HEADER + '#include "common/math/vector.h"\n'}),
            "dependencies")

    def test_sides(self):
        for folder, side, other in (("common/math", "common", "worker_physics"),
                                    ("service/core", "service", "worker_physics"),
                                    ("worker/physics", "worker", "service_core")):
            with self.subTest(folder):
                files = self.with_files(
                    {f"{folder}/CMakeLists.txt": f"sleight_library(\n  LINKS common_base\n        {other})\n"})
                if folder == "common/math":  # else physics and math would be a cycle too
                    files["worker/physics/CMakeLists.txt"] = "sleight_library(LINKS common_base)\n"
                files["worker/run/CMakeLists.txt"] = "sleight_library(LINKS common_base)\n"
                files["worker/run/main.cpp"] = "int main() {}\n"
                self.assert_finds(files, "dependencies",
                                  (f"{folder}/CMakeLists.txt:3", f"{folder} must not link"))

    def test_clients_know_no_service(self):
        self.assert_finds(
            self.with_files({"clients/cli/CMakeLists.txt":
                             "sleight_library(LINKS common_base service_core)\n"}),
            "dependencies", ("clients/cli/CMakeLists.txt:1", "clients/cli must not link service/core"))

    def test_only_a_main_joins_sides(self):
        step = '#include "service/core/step.h"\n'
        files = self.with_files({
            "worker/run/CMakeLists.txt":
                "sleight_library(LINKS worker_physics)\n"
                "sleight_program(batch SOURCES main.cpp options.cpp LINKS worker_run service_core)\n",
            "worker/run/options.cpp": step})
        self.assert_finds(files, "dependencies",
                          ("worker/run/options.cpp:1", "worker must not include service"))

    def test_physics_and_sampling_are_strangers(self):
        self.assert_finds(
            self.with_files({"worker/sampling/CMakeLists.txt":
                             "sleight_library(LINKS common_base worker_physics)\n",
                             "worker/sampling/chain.h": HEADER + '#include "worker/physics/body.h"\n'}),
            "dependencies",
            ("worker/sampling/CMakeLists.txt:1", "must not link worker/physics"),
            ("worker/sampling/chain.h:3", "do not know each other"))

    def test_cycles(self):
        self.assert_finds(
            self.with_files({"common/base/CMakeLists.txt": "sleight_library(LINKS common_math)\n"}),
            "dependencies",
            ("common/base/CMakeLists.txt:1", "a cycle: common_base links common_math"),
            ("common/math/CMakeLists.txt:2", "a cycle: common_math links common_base"))

    def test_unknown_library(self):
        self.assert_finds(
            self.with_files({"worker/sampling/CMakeLists.txt": "sleight_library(LINKS common_bass)\n"}),
            "dependencies", ("worker/sampling/CMakeLists.txt:1", "which no folder declares"))

    def test_files_without_a_library(self):
        self.assert_finds(self.with_files({"common/lost/a.h": HEADER}), "dependencies",
                          ("common/lost/a.h:1", "no sleight_library"))

    def test_includes_are_written_from_the_root(self):
        self.assert_finds(self.with_files({"common/base/check.cpp": '#include "check.h"\n'}),
                          "dependencies", ("common/base/check.cpp:1", "from the root"))

    def test_shipped_code_includes_no_tests(self):
        self.assert_finds(
            self.with_files({"common/base/check.cpp": '\n#include "tests/unit/support.h"\n'}),
            "dependencies", ("common/base/check.cpp:2", "must not include tests/"))

    def test_an_include_in_a_comment_is_none(self):
        self.assert_clean(
            self.with_files({"worker/sampling/chain.h":
                             HEADER + '/*\n#include "common/math/vector.h"\n*/\n'}), "dependencies")


class Shells(TidyTest):
    def with_files(self, files):
        return {**project(), **files}

    def test_shells_where_they_belong_pass(self):
        self.assert_clean(self.with_files({
            "common/archive/hdf5/CMakeLists.txt": "sleight_library(LINKS common_base sleight_hdf5)\n",
            "common/archive/hdf5/file.cpp": "#include <hdf5.h>\n#include <hdf5_hl.h>\n",
            "common/store/CMakeLists.txt": "sleight_library(LINKS SQLite::SQLite3)\n",
            "common/store/store.cpp": "#include <sqlite3.h>\n",
            "worker/run/main.cpp": "#include <mpi.h>\n#include <chrono>\n",
            "worker/run/mpi/transport.cpp": "#include <mpi.h>\n",
            "common/schema/read.cpp": "#include <capnp/message.h>\n#include <kj/io.h>\n",
            "tests/unit/common/archive/archive_test.cpp": "#include <hdf5.h>\n"}), "shells")

    def test_pure_folders_include_no_shell(self):
        for header in ("mpi.h", "hdf5.h", "hdf5_hl.h", "capnp/message.h", "kj/async.h", "sqlite3.h"):
            for folder in ("worker/physics", "worker/sampling", "worker/worlds/dice",
                           "tests/unit/worker/physics"):
                with self.subTest(folder + " " + header):
                    self.assert_finds(self.with_files({f"{folder}/a.cpp": f"\n#include <{header}>\n"}),
                                      "shells", (f"{folder}/a.cpp:2", "do without"))

    def test_pure_folders_touch_no_effects(self):
        for header, effect in (("chrono", "the clock"), ("fstream", "files"),
                               ("filesystem", "files"), ("sys/socket.h", "sockets")):
            with self.subTest(header):
                self.assert_finds(
                    self.with_files({"worker/physics/a.cpp": f"#include <{header}>\n"}),
                    "shells", ("worker/physics/a.cpp:1", f"only shells touch {effect}"))

    def test_pure_folders_link_no_shell_even_through_others(self):
        self.assert_finds(
            self.with_files({
                "common/schema/CMakeLists.txt": "sleight_library(LINKS CapnProto::capnp)\n",
                "worker/physics/CMakeLists.txt":
                    "sleight_library(\n  LINKS common_math\n  common_schema)\n"}),
            "shells", ("worker/physics/CMakeLists.txt:3", "CapnProto::capnp through common_schema"))

    def test_each_library_has_its_folder(self):
        for header, owner in (("mpi.h", "worker/run and service/coordinator"),
                              ("hdf5.h", "common/archive/hdf5"), ("sqlite3.h", "common/store")):
            with self.subTest(header):
                self.assert_finds(
                    self.with_files({"common/base/check.cpp": f"#include <{header}>\n"}),
                    "shells", ("common/base/check.cpp:1", f"belongs to {owner}"))

    def test_each_link_has_its_folder(self):
        for link in ("MPI::MPI_C", "sleight_hdf5", "SQLite::SQLite3"):
            with self.subTest(link):
                self.assert_finds(
                    self.with_files({"service/core/CMakeLists.txt": f"sleight_library(LINKS {link})\n"}),
                    "shells", ("service/core/CMakeLists.txt:1", f"links {link}"))


class Formatting(TidyTest):
    STYLE = "BasedOnStyle: Google\nColumnLimit: 100\n"

    def test_formatted_passes(self):
        self.assert_clean({".clang-format": self.STYLE, "a.cpp": "int f() { return 1; }\n"},
                          "formatting")

    def test_unformatted(self):
        self.assert_finds({".clang-format": self.STYLE, "a.h": "int a;\nint   f( ) ;\n",
                           "b.cpp": "int b;\n"},
                          "formatting", ("a.h:2", "clang-format -i a.h"))


class Constructs(TidyTest):
    def assert_line(self, path, line, words):
        """The line is found behind one of strings and comments that hold the same and are none."""
        decoy = '// ' + line.strip("#/ ").rstrip(";{} ") + ' in words\nauto s = R"(' + line + ')";\n'
        self.assert_finds({path: decoy + line + "\n"}, "constructs", (f"{path}:3", words))

    def test_random_numbers_of_the_standard_library(self):
        for path in ("worker/a.cpp", "clients/a.cpp", "tests/a_test.cpp"):
            self.assert_line(path, "std::normal_distribution<double> d;", "common/random")
            self.assert_line(path, "std::random_device device;", "never the machine's")
            self.assert_line(path, "std::mt19937 engine(1);", "counter-based")
            self.assert_line(path, "std::mt19937_64 engine(1);", "counter-based")
            self.assert_line(path, "std::default_random_engine engine;", "counter-based")
            self.assert_line(path, "int x = rand();", "counter-based")
            self.assert_line(path, "std::srand(1);", "counter-based")

    def test_dead_code(self):
        self.assert_finds({"common/a.cpp": "int a;\n#if 0\nint b;\n#endif\n"}, "constructs",
                          ("common/a.cpp:2", "dead code"))

    def test_libm_where_results_come_from(self):
        for path in ("common/math/vector.cpp", "common/random/a.h", "worker/worlds/dice/a.cpp"):
            self.assert_line(path, "const double x = std::sin(angle);", "std::sin of libm")
            self.assert_line(path, "return exp(x) + 1;", "exp of libm")
            self.assert_line(path, "double y = a * pow(x, 2);", "pow of libm")
            self.assert_line(path, "double y = ::atan2(b, a);", "::atan2 of libm")
            self.assert_line(path, "return std::tgamma(x);", "std::tgamma of libm")
            self.assert_line(path, "float y = std::logf(x);", "std::logf of libm")
        self.assert_line("common/math/elementary.cpp", "return std::log(x);", "std::log of libm")

    def test_what_only_looks_like_libm(self):
        self.assert_clean({
            "common/math/elementary.h": "double sin(double x_rad);\ninline double f() { return log(2.0); }\n",
            "worker/a.cpp": "double a = math::sin(x) + turn.cos(1) + p->exp(2) + Sleef_cinz_sind1_u10purec(x);\n"
                            "double b = std::sqrt(x) + my_log(x) + sincos(x).sin;\n"
                            "double log_density(double x);\n"
                            "const Real& exp(const Real& x);\n",
            "clients/plot.cpp": "double c = std::sin(x);\n",
            "tests/oracle_test.cpp": "double c = std::sin(x);\n"}, "constructs")

    def test_eigen_and_others_that_depend_on_the_machine(self):
        for line, words in (("Eigen::AngleAxisd turn(a, axis);", "AngleAxis"),
                            ("Eigen::VectorXd v(n);", "fixed size"),
                            ("Eigen::MatrixXf m;", "fixed size"),
                            ("Eigen::Matrix<double, Eigen::Dynamic, 3> m;", "fixed size"),
                            ("double z = boost::math::erf(x);", "oracle"),
                            ("double s = std::reduce(a.begin(), a.end());", "write the loop")):
            self.assert_line("worker/physics/a.cpp", line, words)
        self.assert_clean({"worker/physics/a.cpp": "Eigen::Vector3d v;\nEigen::Matrix3d m;\n",
                           "tests/a_test.cpp": "Eigen::VectorXd v;\n"}, "constructs")

    def test_unordered_containers_where_order_counts(self):
        for path in ("worker/a.cpp", "common/plan/a.h", "service/core/a.cpp"):
            self.assert_line(path, "std::unordered_map<int, int> m;", "unordered container")
        self.assert_clean({
            "service/core/a.cpp": "#include <unordered_set>\n"
                                  "std::unordered_set<int> s;  // tidy: asked for membership alone\n",
            "clients/a.cpp": "std::unordered_map<int, int> m;\n"}, "constructs")

    def test_compiler_flags(self):
        for flag in ("-ffast-math", "-march=native", "-Ofast"):
            for path in ("worker/CMakeLists.txt", "deploy/cmake/Options.cmake", "CMakePresets.json"):
                self.assert_finds({path: f"# not {flag}\nset(FLAGS {flag})\n"
                                   if path.endswith(("txt", "cmake")) else f'\n"{flag}"\n'},
                                  "constructs", (f"{path}:2", flag))
        self.assert_clean({"CMakeLists.txt": "add_compile_options(-O3 -ffp-contract=off)\n"},
                          "constructs")

    def test_commented_out_code(self):
        self.assert_finds({"common/a.cpp": "void f() {\n  // g(1, 2);\n  g(2, 1);\n}\n"},
                          "constructs", ("common/a.cpp:2", "commented-out code"))


class CommentedCode(unittest.TestCase):
    def test_code(self):
        for line in ("g(1, 2);", "int x = 3;", "const auto y = f(x);", "x += 2;", "return x;",
                     "if (x > 1) {", "} else {", "for (int i = 0; i < n; ++i) {", "}", "});",
                     "body.velocity = Vec3{0, 0, 0};", "std::vector<int> v;", "double total;",
                     "std::cout << x << y;", "bodies[i]->move(t);", "throw Error(\"no\");", "++i;",
                     "struct Body {", "double f(double x) const {", "break;", "};",
                     "using Bytes = std::vector<char>;", "return a + b * c;"):
            with self.subTest(line):
                self.assertTrue(commented_code.looks_like_code(line))
                self.assertEqual(list(commented_code.lines(Source("// " + line + "\n"))), [1])
                self.assertEqual(list(commented_code.lines(Source("/* " + line + " */\n"))), [1])

    def test_prose(self):
        for line in ("A result lost before its commit is recomputed;",
                     "first the ball falls (about a second); then it bounces;",
                     "Needs the set {a, b, c}", "what holds for x in {0, 1}",
                     "see result.h and error.h;", "return to the start;",
                     "the density is p(x) up to a factor;",
                     "where the chain is at rest (as 2.4.1 says);", "for example {", "---", "",
                     "a state that \"can't happen\" must not reach an archive;"):
            with self.subTest(line):
                self.assertEqual(list(commented_code.lines(Source("// " + line + "\n"))), [])

    def test_examples_stand_indented_below_prose(self):
        example = "// Use it so:\n//\n//   Panel panel;\n//   panel.draw(1);\n"
        self.assertEqual(list(commented_code.lines(Source(example))), [])
        bare = "int a;\n//   panel.draw(1);\n//   panel.draw(2);\n"
        self.assertEqual(list(commented_code.lines(Source(bare))), [2, 3])
        beside = "// Prose.\n// panel.draw(1);\n"
        self.assertEqual(list(commented_code.lines(Source(beside))), [2])

    def test_code_with_a_comment_behind_it(self):
        self.assertEqual(list(commented_code.lines(Source("f();  // g();\n"))), [])


class Sizes(TidyTest):
    def test_long_files(self):
        line = "int x;\n"
        self.assert_finds({"common/a.cpp": line * 601}, "sizes", ("common/a.cpp:601", "601 lines"))
        self.assert_clean({"common/a.cpp": line * 600, "data.csv": line * 9999}, "sizes")

    def test_headers(self):
        self.assert_finds({"common/a.h": "// Idea.\nint x;\n"}, "sizes",
                          ("common/a.h:1", "#pragma once"))
        self.assert_finds({"common/a.h": "#pragma once\nint x;\n"}, "sizes",
                          ("common/a.h:1", "opens with a comment"))
        self.assert_clean({"common/a.h": HEADER, "common/b.h": "/* Idea. */\n#pragma once\n"},
                          "sizes")

    def test_tests_say_their_goal(self):
        self.assert_finds({"a_test.cpp": "\nTEST(A, b) {\n  EXPECT_EQ(1, 1);\n}\n"}, "sizes",
                          ("a_test.cpp:2", "goal"))
        self.assert_finds(
            {"a_test.cpp": "TEST_P(A,\n       b) {\n  f();\n  // Too late.\n}\n"}, "sizes",
            ("a_test.cpp:1", "goal"))
        self.assert_clean(
            {"a_test.cpp": "// Goal: a.\nTEST(A, b) {\n  f();\n}\n"
                           "TEST_F(A, c) {\n\n  // Goal: b.\n  f();\n}\n"
                           "TYPED_TEST(A,\n           d) {  // Goal: c.\n  f();\n}\n",
             "b_test.cpp": "// Goal: all of them.\n// Method: as is.\n#include <a>\nTEST(A, b) { f(); }\n",
             "support.cpp": "TEST(A, b) { f(); }\n"}, "sizes")


class Text(TidyTest):
    def test_paths_of_one_machine(self):
        for path in ("/wo" "rk/main/a", "/tm" "p/w1/a", "/home" "/ann/a", "/ro" "ot/a"):
            with self.subTest(path):
                self.assert_finds({"docs/a.md": f"one\nsee {path}\n"}, "text",
                                  ("docs/a.md:2", "the path of one machine"))
        self.assert_clean({"docs/a.md": "build/wo" "rk/a and ${dir}/wo" "rk/ and /usr/bin\n"}, "text")

    def test_compiled_programs(self):
        self.assert_finds({"a": "\x7fELF\n"}, "text", ("a:1", "a compiled program"))
        self.assert_clean({"a": "ELF\n"}, "text")

    def test_hosts_of_registries(self):
        for host in ("deb.deb" "ian.org", "registry.npm" "js.org", "ghcr" ".io", "pypi" ".org"):
            with self.subTest(host):
                self.assert_finds({"deploy/a.txt": f"https://{host}/x\n"}, "text",
                                  ("deploy/a.txt:1", "the host of a registry"))
        self.assert_clean({"deploy/a.txt": "a registry of packages, Debian's, www.example.org\n"},
                          "text")

    def test_lock_files(self):
        lock = '{\n  "a": {\n    "resolved": "x",\n    "integrity": "y"\n  }\n}\n'
        self.assert_finds({"clients/gallery/package-lock.json": lock}, "text",
                          ("clients/gallery/package-lock.json:3", "without addresses"))
        self.assert_clean({"clients/gallery/package-lock.json": lock.replace("resolved", "version"),
                           "other.json": lock}, "text")

    def test_unfinished_business(self):
        for word in ("TO" "DO", "FIX" "ME", "XX" "X"):
            self.assert_finds({"common/a.cpp": f"int a;  // {word}: later\n"}, "text",
                              ("common/a.cpp:1", "finish it"))
        self.assert_clean({"common/a.sh": "#!/bin/sh\nmktemp dir.XXXX" "XX\n"}, "text")

    def test_scripts(self):
        self.assert_finds({"deploy/a": "#!/bin/sh\nif true; then\n"}, "text", ("deploy/a:", "sh -n"))
        self.assert_finds({"tests/a": "#!/usr/bin/env bash\necho )\n"}, "text",
                          ("tests/a:2", "bash -n"))
        self.assert_finds({"deploy/a.sh": "echo not executable\n"}, "text",
                          ("deploy/a.sh:1", "chmod +x"))
        self.assert_clean({"deploy/a": "#!/bin/sh\nif true; then echo; fi\n",
                           "deploy/b": "#!/usr/bin/env bash\na=(1 2)\n"}, "text")

    def assert_finds(self, files, check, *expected):
        # The line of a syntax error is the shell's affair where the place names none.
        if any(place.endswith(":") for place, _ in expected):
            found = self.findings(files, check)
            self.assertEqual(len(found), len(expected), found)
            for said, (place, words) in zip(found, expected):
                self.assertTrue(said.startswith(place), said)
                self.assertIn(words, said)
        else:
            super().assert_finds(files, check, *expected)


class Documents(TidyTest):
    # Put together here, so that the check doesn't take them for citations of this project's own.
    GUIDE = "docs/" + "GUIDE"

    def documents(self):
        """A glossary that knows the code, links that lead somewhere, a comment that cites."""
        return {
            "README.md": f"[guide]({self.GUIDE}.md#how-it-works-so) and [code](common/base), "
                         "![picture](docs/a.svg), [home](https://example.com/x), `[no](link)`\n"
                         "```\n[no](link)\n```\n",
            "docs/a.svg": "<svg/>\n",
            f"{self.GUIDE}.md": "# Guide\n[here](#how-it-works-so), [up](../README.md)\n"
                                "## How it works: `so`\n",
            "docs/GLOSSARY.md": "| clock | `base::Clock` | `common/base/clock.h` |\n",
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

    def test_folders_that_the_glossary_lacks(self):
        self.assert_finds_in("worker/maps/CMakeLists.txt", "# Maps.\nsleight_library()\n",
                             ("worker/maps/CMakeLists.txt:1", "names nothing of this folder"))


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
            "docs/notebook/b.md":
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


class Waivers(TidyTest):
    FAULT = "std::unordered_map<int, int> m;  // tidy: {}\n"

    def all_findings(self, files):
        with tempfile.TemporaryDirectory() as root:
            write(root, {**project(), ".clang-format": "DisableFormat: true\n", **files})
            return [str(f) for f in rules.run(Tree(root))]

    def test_a_good_reason_excuses_its_line(self):
        good = self.FAULT.format("iterated only in tests")
        self.assertEqual(self.all_findings({"worker/run/a.cpp": good}), [])
        self.assertEqual(len(self.all_findings({"worker/run/a.cpp": good + "std::unordered_set<int> s;\n"})),
                         1)

    def test_a_short_reason_excuses_nothing(self):
        found = self.all_findings({"worker/run/a.cpp": self.FAULT.format("it is")})
        self.assertEqual(len(found), 2, found)
        self.assertIn("worker/run/a.cpp:1: an excuse needs a reason", " ".join(found))

    def test_an_excuse_for_nothing_is_found(self):
        found = self.all_findings({"worker/run/a.cpp": "int a;  // tidy: there once was something\n"})
        self.assertEqual(found, ["worker/run/a.cpp:1: this excuse excuses nothing; remove it "
                                 "[waivers]"])

    def test_they_are_listed(self):
        with tempfile.TemporaryDirectory() as root:
            write(root, {"worker/a.cpp": self.FAULT.format("asked for membership alone"),
                         "CMakeLists.txt": "\nset(A -ffast-math)  # tidy: a test of the checker\n"})
            out = subprocess.run([sys.executable, HERE / "tidy", "--waivers", root],
                                 capture_output=True, text=True, check=True).stdout
        self.assertEqual(out, "CMakeLists.txt:2: a test of the checker\n"
                              "worker/a.cpp:1: asked for membership alone\n")


class Program(unittest.TestCase):
    def run_tidy(self, *arguments, **options):
        return subprocess.run([sys.executable, HERE / "tidy", *arguments], capture_output=True,
                              text=True, check=False, **options)

    def test_exit_codes(self):
        with tempfile.TemporaryDirectory() as root:
            write(root, {"common/a.h": HEADER, "common/CMakeLists.txt": "sleight_library()\n",
                         "build/generated.h": "int a;\n"})
            self.assertEqual(self.run_tidy(root).returncode, 0, self.run_tidy(root).stdout)
            write(root, {"common/a.h": "// Idea.\n"})
            run = self.run_tidy(root)
            self.assertEqual(run.returncode, 1)
            self.assertEqual(run.stdout, "common/a.h:1: no #pragma once [sizes]\n")
            self.assertIn("1 finding (", run.stderr)
            self.assertEqual(self.run_tidy(root, "--only", "text").returncode, 0)
            self.assertEqual(self.run_tidy(root + "/nowhere").returncode, 2)

    def test_without_clang_format_it_says_what_to_do(self):
        with tempfile.TemporaryDirectory() as root:
            write(root, {"a.h": HEADER})
            run = self.run_tidy(root, env={**os.environ, "PATH": root})
            self.assertEqual(run.returncode, 2)
            self.assertIn("deploy/install-deps", run.stderr)

    def test_git_decides_what_is_looked_at(self):
        with tempfile.TemporaryDirectory() as root:
            write(root, {"kept.h": HEADER, "new.h": HEADER, "ignored.h": "int a;\n",
                         ".gitignore": "ignored.h\n"})
            for command in (["init", "-q"], ["add", "kept.h"]):
                subprocess.run(["git", "-C", root, *command], check=True, capture_output=True,
                               env=without_git(os.environ))
            self.assertEqual(Tree(root).files, [".gitignore", "kept.h", "new.h"])

    def test_every_check_is_tested_here(self):
        self.assertEqual(set(rules.CHECKS), {case.__name__.lower() for case in
                                             (Dependencies, Shells, Formatting, Constructs, Sizes,
                                              Text, Documents, Provenance)})


class SourceTest(unittest.TestCase):
    def test_code_and_comments_are_told_apart(self):
        source = Source('a("// no");  // yes\nx = 1\'000; /* two\nlines */ y;\nR"(// raw\n)" z;\n')
        self.assertEqual([line.strip() for line in source.code],
                         ['a("");', "x = 1'000;", "y;", '""', "z;", ""])
        self.assertEqual([comment.strip() for comment in source.comments],
                         ["// yes", "/* two", "lines */", "", "", ""])


if __name__ == "__main__":
    unittest.main()
