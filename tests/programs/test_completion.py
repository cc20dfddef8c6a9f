"""Goal: completion works in common shells, and manual pages have no faults. Method: request completions from
real bash (with and without bash-completion), zsh and fish. The lines are of a toy program that has every kind
of argument, and of the real programs. mandoc checks the pages.
"""

import os
import pathlib
import re
import shutil

import harness
import shells
from harness import ProgramTest, program, run, sleight

BASH_COMPLETION = "/usr/share/bash-completion/bash_completion"

REQUESTS = {"a.toml", "c d.toml", "sub/", "x.h5.run/"}
ARCHIVES = {"b.h5", "sub/", "x.h5.run/"}

# Candidates at the end of each line.
TOY = {
    "toy ": {"archive", "run", "wait"},
    "toy -v ru": {"run"},
    "toy run ": REQUESTS,
    "toy run c\\ ": {"c d.toml"},
    "toy run -o ": ARCHIVES,
    "toy run --output=": ARCHIVES,
    "toy run --output=b": {"b.h5"},
    # A value is neither a command nor a positional.
    "toy run -o archive ": REQUESTS,
    "toy run --set world.word=HI ": REQUESTS,
    "toy run --output=b.h5 ": REQUESTS,
    "toy run -n 3 -- ": REQUESTS,
    "toy archive ": {"export"},
    "toy archive export ": ARCHIVES,
    "toy archive export --table ": {"posterior", "stats"},
    "toy archive export --table=p": {"posterior"},
    "toy wait ": {"17", "18"},
    "toy wait 17 1": {"17", "18"},
    # No candidate is better than a wrong one. These lines come last: after an empty list, bash inserts its
    # next candidate instead of listing it, if that is a single word.
    "toy run -n ": set(),
    "toy run --set ": set(),
    "toy run a.toml ": set(),
}
TABLES = {"trace", "paths", "animations", "plausibility"}
REAL = {
    "sleight archive ": {"info", "digest", "verify", "export", "derive"},
    "sleight plot b.h5 --what ": TABLES,
    "sleight direct --word HI ": REQUESTS,
    "sleight archive derive ": {"sub/", "x.h5.run/"},
    "sleight completion ": {"bash", "zsh", "fish"},
    "sleight-batch ": REQUESTS,
    "sleight-batch -o ": ARCHIVES,
}


def built(folder):
    """A folder of the build, beside the programs. Absolute, because shells have folders of their own."""
    return pathlib.Path(harness.arguments.bin).resolve().parent / folder


def words_of(rows):
    """Words of a listing. Columns are separated by two spaces, and a word's explanation follows it."""
    found = set()
    for row in rows:
        row = re.split(r"\t| +-- ", row)[0]
        found.update(re.sub(r"\\(.)", r"\1", word).strip()
                     for word in re.split(r" {2,}|(?<=/) (?=\S)", row))
    return {word.partition("=")[2] if word.startswith("--") and "=" in word else word
            for word in found}


class Completion(ProgramTest):
    def setUp(self):
        super().setUp()
        self.home = self.path("home")
        self.work = self.path("work")
        for folder in (self.home, self.work, self.work / "sub", self.work / "x.h5.run"):
            folder.mkdir()
        for name in ("a.toml", "c d.toml", "b.h5", "z.txt"):
            (self.work / name).touch()
        self.env = {name: value for name, value in harness.environment().items()
                    if not name.startswith("XDG_")}
        self.env.update(HOME=str(self.home), LC_ALL="C.UTF-8",
                        PATH=f"{built('bin')}:{built('tests')}:{self.env['PATH']}")

    def shell(self, make, setup):
        for name in ("bash", "zsh", "fish", "mandoc"):
            self.assertIsNotNone(shutil.which(name), f"{name} is missing; see deploy/install-deps")
        started = make(setup, self.work, self.env)
        self.addCleanup(started.close)
        return started

    def write_script(self, path, shell, name):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(self.succeed(sleight("completion", shell, name)).stdout)

    def lists(self, shell, line):
        words = words_of(shell.listed(line))
        # If nothing else is possible, zsh offers options before they are begun.
        return {word for word in words if not word.startswith("-")}

    def judge(self, shell, expected):
        for line, words in expected.items():
            with self.subTest(line=line):
                self.assertEqual(self.lists(shell, line), words)

    def judge_options(self, shell):
        for line, some in {"toy run --": {"--output", "--set", "--help"},
                           "sleight direct --": {"--word", "--set", "--threads"}}.items():
            words = words_of(shell.listed(line))
            self.assertLessEqual(some, words, line)
            self.assertNotIn("--secret", words)
        commands = words_of(shell.listed("sleight "))
        self.assertLessEqual({"direct", "check", "archive", "completion", "config"}, commands)
        self.assertNotIn("man", commands)

    def judge_without_server(self, shell, command):
        shell.command(command)
        self.assertEqual(shell.listed("toy wait "), [])

    def test_bash(self):
        """Tests bash without bash-completion."""
        shell = self.shell(shells.bash, ["unset -f _init_completion",
                                         "source <(toy completion bash)",
                                         "source <(sleight completion bash)",
                                         "source <(sleight completion bash sleight-batch)"])
        self.judge(shell, {**TOY, **REAL})
        self.judge_options(shell)
        self.judge_without_server(shell, "export NO_SERVER=1")

    def test_bash_beside_bash_completion(self):
        """bash-completion loads the scripts itself, from where packages install them."""
        for name in ("sleight", "sleight-batch", "sleightd"):
            self.write_script(self.home / ".local/share/bash-completion/completions" / name, "bash",
                              name)
        shell = self.shell(shells.bash, [f"source {BASH_COMPLETION}",
                                         "source <(toy completion bash)"])
        self.judge(shell, {**REAL, **TOY})
        self.judge_options(shell)

    def test_bash_inserts_names_as_the_shell_reads_them(self):
        """Goal: names with blanks are completed with quotes. Method: press Tab, and let echo show the
        words."""
        shell = self.shell(shells.bash, ["source <(toy completion bash)",
                                         "bind 'TAB: complete'",
                                         "toy() { printf '<%s>' \"$@\"; }"])
        self.assertIn("<run><c d.toml>", shell.command("toy run c\t"))
        self.assertIn("<run><--output=b.h5>", shell.command("toy run --output=b\t"))
        self.assertIn("<run><-o><sub/>", shell.command("toy run -o su\t"))

    def test_zsh(self):
        shell = self.shell(shells.zsh, ["compinit -u -D", "source <(toy completion zsh)",
                                        "source <(sleight completion zsh)",
                                        "source <(sleight completion zsh sleight-batch)"])
        self.judge(shell, {**TOY, **REAL})
        self.judge_options(shell)
        self.judge_without_server(shell, "export NO_SERVER=1")

    def test_zsh_from_its_function_path(self):
        for name in ("sleight", "sleight-batch", "sleightd"):
            self.write_script(self.home / "functions" / f"_{name}", "zsh", name)
        shell = self.shell(shells.zsh, [f"fpath=({self.home}/functions $fpath)", "compinit -u -D"])
        self.judge(shell, REAL)

    def test_fish(self):
        for name in ("sleight", "sleight-batch", "sleightd"):
            self.write_script(self.home / "completions" / f"{name}.fish", "fish", name)
        shell = self.shell(shells.Fish, ["toy completion fish | source",
                                         f"set -p fish_complete_path {self.home}/completions"])
        expected = {**TOY, **REAL}
        for (line, words), rows in zip(expected.items(), shell.all_listed(expected)):
            with self.subTest(line=line):
                self.assertEqual(words_of(rows), words)
        self.judge_options(shell)
        self.judge_without_server(shell, "set -gx NO_SERVER 1")

    def test_judge_sees_a_shell_without_completion(self):
        """Runs the same lines in shells without completion, which list files instead of commands."""
        for make, setup in ((shells.bash, []), (shells.zsh, ["compinit -u -D"]), (shells.Fish, [])):
            shell = self.shell(make, setup)
            self.assertNotEqual(self.lists(shell, "toy "), TOY["toy "])
            self.assertNotEqual(self.lists(shell, "toy run -o "), TOY["toy run -o "])


class ManPages(ProgramTest):
    def lint(self):
        """Runs mandoc in the pages' folder, where it looks for the pages that they name."""
        return run(["mandoc", "-T", "lint", *sorted(os.listdir(self.folder))], cwd=self.folder)

    def test_pages_are_without_fault(self):
        self.succeed(sleight("man", "--directory", self.folder, env={"SOURCE_DATE_EPOCH": "0"}))
        pages = set(os.listdir(self.folder))
        self.assertLessEqual({"sleight.1", "sleight-direct.1", "sleight-archive.1",
                              "sleight-archive-export.1", "sleight-config.1", "sleight-batch.1",
                              "sleightd.1"},
                             pages)
        self.assertNotIn("sleight-man.1", pages)
        self.assertEqual(self.lint().stdout, "")
        shown = self.succeed(run(["mandoc", "-T", "utf8", self.path("sleight-direct.1")])).stdout
        shown = re.sub(".\b", "", shown)
        self.assertIn("--set KEY=VALUE", shown)
        self.assertIn("sleight direct --word SLEIGHT -o s.h5", shown)
        self.assertIn("January 1, 1970", shown)
        self.assertIn("EXIT STATUS", self.path("sleight.1").read_text())

        # The judge detects a fault.
        with open(self.path("sleight-direct.1"), "a") as page:
            page.write(".Xr sleight-dirext 1\n.Zz\n")
        self.assertIn("sleight-dirext", self.lint().stdout)

    def test_the_programs_own_page_on_stdout(self):
        page = self.succeed(sleight("man")).stdout
        self.assertIn(".Dt SLEIGHT 1\n", page)

    def test_build_has_pages_and_scripts(self):
        """Pages and scripts are where man and the shells look below a prefix."""
        for path, words in {"man/man1/sleight-batch.1": ["sleight-batch"],
                            "bash-completion/completions/sleight": ["completion", "bash"],
                            "zsh/site-functions/_sleight": ["completion", "zsh"],
                            "fish/vendor_completions.d/sleight.fish": ["completion", "fish"]}.items():
            with self.subTest(path=path), open(built("share") / path) as file:
                text = file.read()
                if words[0] == "completion":
                    self.assertEqual(text, self.succeed(run([program("sleight"), *words])).stdout)
                else:
                    self.assertIn(words[0], text)


if __name__ == "__main__":
    harness.main()
