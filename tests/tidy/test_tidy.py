#!/usr/bin/env python3
"""Goal: each check of tidy finds its kind of fault, at its place, and accepts correct code.

Method: for each check, make small trees in a temporary folder: one with a single fault, and one without.
Compare file, line and message of the finding.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import built_bare  # noqa: E402
import rules  # noqa: E402
from rules import commented_code, shells  # noqa: E402
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
        """Findings of a check for a tree of these files, without the check's name."""
        with tempfile.TemporaryDirectory() as root:
            write(root, files)
            return [str(f).rsplit(" [", 1)[0] for f in rules.run(Tree(root), [check])]

    def assert_finds(self, files, check, *expected):
        """Each finding starts with `file:line: ` and contains the words, in order."""
        found = self.findings(files, check)
        self.assertEqual(len(found), len(expected), found)
        for said, (place, words) in zip(found, expected):
            self.assertTrue(said.startswith(place + ": "), f"{said} is not at {place}")
            self.assertIn(words, said)

    def assert_clean(self, files, check):
        self.assertEqual(self.findings(files, check), [])


def project():
    """A small project that obeys all rules."""
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

    def test_parts_of_programs_are_mains(self):
        # A library shared by programs' mains may join sides like a main. A library that links it may not.
        files = self.with_files({
            "worker/run/CMakeLists.txt":
                "sleight_library(LINKS worker_physics)\n"
                "sleight_program_parts(mains SOURCES main_run.cpp LINKS worker_run service_core)\n"
                "sleight_program(batch SOURCES main.cpp LINKS mains)\n",
            "worker/run/main_run.cpp": '#include "service/core/step.h"\n'})
        self.assert_clean(files, "dependencies")
        files["worker/run/options.cpp"] = '#include "service/core/step.h"\n'
        self.assert_finds(files, "dependencies", ("worker/run/options.cpp:1", "must not include service"))

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

    # For each outside library: a header, a link, its folder, and the names of both.
    EXAMPLES = (
        ("mpi.h", "MPI::MPI_C", "worker/run/mpi", "MPI"),
        ("hdf5.h", "sleight_hdf5", "common/archive/hdf5", "HDF5"),
        ("sqlite3.h", "SQLite::SQLite3", "common/store", "SQLite"),
        ("xxhash.h", "PkgConfig::XXHASH", "common/store", "xxHash"),
        ("capnp/message.h", "CapnProto::capnp", "common/schema/wire", "Cap'n Proto"),
        ("openssl/evp.h", "OpenSSL::Crypto", "common/hash", "OpenSSL"),
        ("nlohmann/json.hpp", "nlohmann_json::nlohmann_json", "common/json", "the JSON library"),
        ("spdlog/spdlog.h", "spdlog::spdlog", "common/logging", "spdlog"),
        ("librsvg/rsvg.h", "PkgConfig::RSVG", "clients/plot", "librsvg"),
        ("libpng16/png.h", "PkgConfig::PNG", "clients/plot", "libpng"),
        ("seccomp.h", "PkgConfig::SECCOMP", "common/archive/reader_program", "libseccomp"),
        ("sys/mman.h", None, "common/base", "memory mapping"),
    )

    def test_every_library_has_an_example(self):
        self.assertEqual({name for *_, name in self.EXAMPLES},
                         {name for name, *_ in shells.LIBRARIES})

    def test_shells_where_they_belong_pass(self):
        files = {"worker/run/main.cpp": "#include <mpi.h>\n#include <chrono>\n",
                 "common/schema/wire/read.cpp": "#include <kj/io.h>\n",
                 "tests/unit/common/archive/archive_test.cpp": "#include <hdf5.h>\n"}
        for header, link, folder, _ in self.EXAMPLES:
            files[f"{folder}/a.cpp"] = f"#include <{header}>\n"
            if link:
                files[f"{folder}/CMakeLists.txt"] = f"sleight_library(LINKS {link})\n"
        self.assert_clean(self.with_files(files), "shells")

    def test_pure_folders_include_no_shell(self):
        headers = [header for header, *_ in self.EXAMPLES] + ["hdf5_hl.h", "kj/async.h"]
        for header in headers:
            for folder in ("worker/physics", "worker/sampling", "worker/worlds/dice",
                           "service/core", "common/plan", "common/math", "common/random",
                           "tests/unit/worker/physics", "tests/unit/service/core"):
                with self.subTest(folder + " " + header):
                    self.assert_finds(self.with_files({f"{folder}/a.cpp": f"\n#include <{header}>\n"}),
                                      "shells", (f"{folder}/a.cpp:2", "algorithms do without"))

    def test_pure_folders_touch_no_effects(self):
        for header, effect in (("chrono", "the clock"), ("fstream", "files"),
                               ("filesystem", "files"), ("sys/socket.h", "sockets")):
            for folder in ("worker/physics", "service/core"):
                with self.subTest(folder + " " + header):
                    self.assert_finds(
                        self.with_files({f"{folder}/a.cpp": f"#include <{header}>\n"}),
                        "shells", (f"{folder}/a.cpp:1", f"only shells touch {effect}"))

    def test_bare_folders_link_no_shell_even_through_others(self):
        for folder in ("worker/physics", "worker/run", "service/core", "common/schema",
                       "common/archive"):
            for _, link, owner, library in self.EXAMPLES:
                if link is None:
                    continue
                name = owner.replace("/", "_")
                with self.subTest(folder + " " + link):
                    files = {f"{owner}/CMakeLists.txt": f"sleight_library(LINKS {link})\n",
                             f"{folder}/CMakeLists.txt":
                                 f"sleight_library(\n  LINKS common_math\n  {name})\n"}
                    if folder != "worker/run":
                        files["worker/run/CMakeLists.txt"] = ""
                    found = self.findings(self.with_files(files), "shells")
                    self.assertIn(f"{folder}/CMakeLists.txt:3: {folder} is built without {library}: "
                                  f"links {link} through {name}", found)

    def test_generated_code_counts_as_its_library(self):
        self.assert_finds(
            self.with_files({
                "common/schema/wire/CMakeLists.txt":
                    "sleight_library(LINKS sleight_schema_generated)\n",
                "service/core/CMakeLists.txt": "sleight_library(LINKS common_schema_wire)\n"}),
            "shells", ("service/core/CMakeLists.txt:1", "built without Cap'n Proto"))

    def test_each_library_has_its_folder(self):
        for header, _, owner, _ in self.EXAMPLES:
            for path in ("common/request/a.cpp", "clients/cli/a.cpp"):
                with self.subTest(path + " " + header):
                    self.assert_finds(self.with_files({path: f"#include <{header}>\n"}),
                                      "shells", (f"{path}:1", f"belongs to {owner}"))

    def test_each_link_has_its_folder(self):
        for _, link, owner, library in self.EXAMPLES:
            if link:
                with self.subTest(link):
                    self.assert_finds(
                        self.with_files(
                            {"clients/cli/CMakeLists.txt": f"sleight_library(LINKS {link})\n"}),
                        "shells", ("clients/cli/CMakeLists.txt:1", f"{library} belongs to {owner}"))


class BuiltBare(unittest.TestCase):
    DEPS = ("worker/physics/CMakeFiles/worker_physics.dir/a.cpp.o: #deps 2, deps mtime 1 (VALID)\n"
            "    /source/worker/physics/a.cpp\n"
            "    {}\n\n"
            "common/hash/CMakeFiles/common_hash.dir/b.cpp.o: #deps 1, deps mtime 1 (VALID)\n"
            "    /usr/include/openssl/evp.h\n\n"
            "worker/run/mpi/CMakeFiles/worker_run_mpi.dir/c.cpp.o: #deps 1, deps mtime 1 (VALID)\n"
            "    /usr/lib/openmpi/include/mpi.h\n")

    def found(self, header):
        return list(built_bare.strangers(built_bare.headers_by_object(self.DEPS.format(header))))

    def test_headers_by_way_of_others_are_found(self):
        for header in ("/usr/include/openssl/evp.h", "/usr/include/spdlog/fmt/fmt.h",
                       "/usr/include/hdf5/serial/H5public.h", "/usr/include/sqlite3.h",
                       "/usr/include/capnp/common.h", "/usr/include/kj/io.h",
                       "/build/common/schema/wire/worker.capnp.h", "/usr/lib/openmpi/include/mpi.h"):
            with self.subTest(header):
                self.assertEqual([place for *_, place in self.found(header)], [header])

    def test_others_are_left_alone(self):
        for header in ("/usr/include/fmt/format.h", "/usr/include/x86_64-linux-gnu/sys/mman.h",
                       "../common/hash_map.h", "/usr/include/eigen3/Eigen/src/plugins/a.h"):
            with self.subTest(header):
                self.assertEqual(self.found(header), [])

    def test_nothing_built_is_no_answer(self):
        with tempfile.TemporaryDirectory() as root:
            write(root, {"build.ninja": ""})
            run = subprocess.run([sys.executable, "-B", HERE / "built_bare.py", root],
                                 capture_output=True, text=True, check=False)
        self.assertEqual(run.returncode, 2, run.stderr)


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
        """Finds the line behind strings and comments with the same text, which don't count."""
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
        # The shell reports the line of a syntax error, if the place names none.
        if any(place.endswith(":") for place, _ in expected):
            found = self.findings(files, check)
            self.assertEqual(len(found), len(expected), found)
            for said, (place, words) in zip(found, expected):
                self.assertTrue(said.startswith(place), said)
                self.assertIn(words, said)
        else:
            super().assert_finds(files, check, *expected)


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
        cases = {name.lower() for path in HERE.glob("test_*.py") for name in
                 re.findall(r"(?m)^class (\w+)\(TidyTest\)", path.read_text(encoding="utf-8"))}
        self.assertEqual(set(rules.CHECKS), cases - {"waivers"})


class SourceTest(unittest.TestCase):
    def test_code_and_comments_are_told_apart(self):
        source = Source('a("// no");  // yes\nx = 1\'000; /* two\nlines */ y;\nR"(// raw\n)" z;\n')
        self.assertEqual([line.strip() for line in source.code],
                         ['a("");', "x = 1'000;", "y;", '""', "z;", ""])
        self.assertEqual([comment.strip() for comment in source.comments],
                         ["// yes", "/* two", "lines */", "", "", ""])


if __name__ == "__main__":
    unittest.main()
