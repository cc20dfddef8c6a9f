"""Goal: keys set on the command line and settings of the service are applied, and errors in them are as
helpful as errors in a file. Method: check the programs' output and exit codes. Digests of runs by a file and
by --set must be equal."""

import json
import re

import harness
from harness import ProgramTest, program, run, sleight


class Sets(ProgramTest):
    def test_a_run_is_that_of_a_file_with_these_keys(self):
        wanted = self.write_request("wanted.toml", chains=2, seed=7, scans=50)
        given = self.write_request("given.toml", chains=4, seed=1, scans=1000)
        sets = ["--set", "sampler.chains=2", "--set", "sampler.seed=7", "--set=stop.scans=50"]
        self.direct(wanted, self.path("wanted.h5"))
        self.direct(given, self.path("given.h5"), *sets)
        self.succeed(run([program("sleight-batch"), given, "-o", self.path("batch.h5"), "-q", *sets]))
        digest = self.digest(self.path("wanted.h5"))
        self.assertEqual(self.digest(self.path("given.h5")), digest)
        self.assertEqual(self.digest(self.path("batch.h5")), digest)
        checked = self.succeed(sleight("check", given, *sets)).stdout
        self.assertEqual(checked, self.succeed(sleight("check", wanted)).stdout)
        self.assertNotEqual(checked, self.succeed(sleight("check", given)).stdout)

    def test_a_word_takes_sets_too(self):
        shown = self.succeed(sleight("direct", "--word", "HI", "--set", "sampler.seed=7",
                                     "--print-request")).stdout
        self.assertIn("seed = 7\n", shown)
        self.assertIn('word = "HI"\n', shown)

    def errors(self, *words, code=3):
        result = sleight(*words)
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertEqual(result.stdout, "")
        return result.stderr

    def test_errors_name_the_set(self):
        request = self.write_request()
        output = self.path("x.h5")
        for command in (["check", request], ["direct", request, "-o", output]):
            self.assertRegex(self.errors(*command, "--set", "sampler.sed=1"),
                             r"^--set sampler\.sed=1: .*'sed' in \[sampler\].*'seed'.*\n\Z")
            self.assertRegex(self.errors(*command, "--set", "sampler.seed=1..20"),
                             r"^--set sampler\.seed=1\.\.20: .*range.*`sleight submit`.*\n\Z")
        self.assertFalse(output.exists())
        direct = ["direct", request, "-o", output]
        self.assertRegex(self.errors(*direct, "--seed", "2", "--set", "sampler.seed=1"),
                         r"^--set sampler\.seed=1: .*--seed\b.*\n\Z")
        self.assertRegex(self.errors(*direct, "-n", "2", "--set", "stop.scans=9"),
                         r"^--set stop\.scans=9: .*-n 2\b.*\n\Z")
        self.assertRegex(self.errors("direct", "--word", "HI", "--print-request", "--set",
                                     "world.word=HO"),
                         r"^--set world\.word=HO: .*--word\b.*\n\Z")
        result = run([program("sleight-batch"), request, "-o", output, "--set", "samplr.seed=1"])
        self.assertEqual(result.returncode, 3)
        self.assertRegex(result.stderr, r"^--set samplr\.seed=1: .*\[samplr\].*\[sampler\].*\n\Z")


class Config(ProgramTest):
    def config(self, *words, file=None, **variables):
        folder = self.path("config")
        (folder / "sleight").mkdir(parents=True, exist_ok=True)
        path = folder / "sleight" / "config.toml"
        path.unlink(missing_ok=True)
        if file is not None:
            path.write_text(file)
        env = {"HOME": str(self.folder), "XDG_CONFIG_HOME": str(folder), "XDG_STATE_HOME": "",
               "SLEIGHT_STATE": "", "SLEIGHT_SOCKET": "", "SLEIGHT_ALLOW_ROOT": "", **variables}
        return path, sleight("config", *words, env=env)

    def test_tells_where_each_setting_comes_from(self):
        path, result = self.config("--json", file="cores = 1\nslice = '1.5m'\n[limits]\njobs = 5\n",
                                   SLEIGHT_SOCKET="/tmp/s")
        told = json.loads(self.succeed(result).stdout)
        self.assertEqual(told["file"], str(path))
        self.assertTrue(told["file_is_there"])
        settings = told["settings"]
        self.assertEqual(settings["cores"], {"value": 1, "unit": "cores", "from": "file",
                                             "given_by": f"{path}:1:1"})
        self.assertEqual(settings["slice"]["value"], 90)
        self.assertEqual(settings["limits.jobs"]["value"], 5)
        self.assertIsNone(settings["limits.bytes"]["value"])
        self.assertEqual(settings["socket"], {"value": "/tmp/s", "unit": "", "from": "environment",
                                              "given_by": "SLEIGHT_SOCKET"})
        self.assertEqual(settings["keep_days"]["from"], "default")
        # A job's process has the same cache as by hand.
        help_text = self.succeed(sleight("direct", "--help")).stdout
        self.assertRegex(help_text, rf"--cache MB\S*.*={settings['cache_mb']['value']}\n")

    def test_errors_have_their_places(self):
        path, result = self.config(file="cors = 1\n", SLEIGHT_STATE="here")
        self.assertEqual(result.returncode, 2)
        self.assertEqual(result.stdout, "")
        self.assertIn("SLEIGHT_STATE: expected an absolute path", result.stderr)
        self.assertRegex(result.stderr, rf"(?m)^ *{re.escape(str(path))}:1:1: .*'cors'.*'cores'")


if __name__ == "__main__":
    harness.main()
