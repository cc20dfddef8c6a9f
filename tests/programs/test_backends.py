"""Goal: backends by other programs do what every backend must do. Method: run the cases of
backend_conformance.py through tests/backends, with a separate process for each call. The program is the
documented example, deploy/backends/sleight-example. Scripts break the protocol in all ways that a program
must not. test_slurm_backend.py tests the backend for Slurm."""

import json
import os
import pathlib
import unittest

import backend_conformance
import harness
from harness import ProgramTest
from service_harness import ServiceTest


def engine(*arguments):
    return [pathlib.Path(harness.arguments.bin).parent / "tests/sleight-backend", *arguments]


class Example(backend_conformance.Conformance, ProgramTest):

    def command(self):
        program = pathlib.Path(harness.arguments.source).resolve() / "deploy/backends/sleight-example"
        return engine("--kind", "program", "--program", program)

    def environment(self):
        return {**super().environment(), "SLEIGHT_EXAMPLE": str(self.path("example"))}

    def wait_options(self):
        return {"delay": "1000"}

    def make_away(self):
        self.path("example").rename(self.path("elsewhere"))
        self.path("example").touch()

    def come_back(self):
        self.path("example").unlink()
        self.path("elsewhere").rename(self.path("example"))

    def test_options_that_it_does_not_know_are_refused(self):
        for options, words in (({"colour": "red"}, "'colour'"), ({"delay": "soon"}, "'delay'"), ({"delay": "nan"}, "'delay'")):
            order = {**self.order(), "options": options}
            result = self.ask_raw("launch", json.dumps({"version": 1, **order}))
            self.assertNotIn(result.returncode, (0, backend_conformance.AWAY))
            self.assertIn(words, result.stderr)
            self.assertEqual(self.state(order)["state"], "absent")


@unittest.skipUnless(os.environ.get("SLEIGHT_SOAK"), "for deploy/soak slurm")
class ExampleAlone(Example):
    """The example without the service."""

    def command(self):
        return [pathlib.Path(harness.arguments.source).resolve() / "deploy/backends/sleight-example"]


class Service(ServiceTest):
    """The daemon with such a program, to the end of a job."""

    def environment(self):
        return {**super().environment(), "SLEIGHT_EXAMPLE": str(self.path("example"))}

    def test_a_job_waits_and_runs_beside_a_daemon_that_is_killed(self):
        request = self.write_request(scans=2000)
        options = ["--backend", pathlib.Path(harness.arguments.source).resolve() / "deploy/backends/sleight-example"]
        self.serve(*options)
        job = self.submit(request, "--option", "delay=3")
        self.until(lambda: self.job(job)["reason"].endswith(" is waiting: delay"))
        self.kill_daemon()
        self.serve(*options)
        self.wait(job)
        seen = self.job(job)
        self.assertEqual((seen["starts"], seen["digest"]), (1, self.quiet_digest(request)))
        record = self.attempt(job)
        self.assertIn("--end-report", record["command"])
        self.assertEqual(record["end"]["exit_code"], 0)


class WrongPrograms(ProgramTest):
    """The service's handling of a program that breaks the protocol."""

    def ask(self, script, verb="list", *options):
        program = self.path("program")
        program.write_text(f"#!/bin/bash\n{script}\n")
        program.chmod(0o755)
        question = {"version": 1, "daemon": "abcdefgh", "attempt": {"daemon": "abcdefgh", "job": 1, "epoch": 1}}
        return harness.run([*engine("--kind", "program", "--program", program, *options), verb],
                           input=json.dumps(question))

    def test_what_counts_as_away(self):
        for script in ("exit 75", "kill -9 $$", "echo nonsense", "echo '{}'", "true",
                       """echo '{"version": 2, "attempts": []}'""", """echo '{"version": 1}'""",
                       """echo '{"version": 1, "attempts": 3}'"""):
            result = self.ask(script)
            self.assertEqual(result.returncode, backend_conformance.AWAY, script)
            self.assertNotEqual(result.stderr, "")

    def test_one_that_does_not_end_is_killed(self):
        for script in ("sleep 1000", "exec >&- 2>&-; sleep 1000", "sleep 1000 & exit 0"):
            result = self.ask(script, "list", "--seconds", "0.3")
            self.assertEqual(result.returncode, backend_conformance.AWAY, script)

    def test_refusals_are_told(self):
        result = self.ask("echo no such project >&2; exit 3")
        self.assertNotIn(result.returncode, (0, backend_conformance.AWAY))
        self.assertIn("no such project", result.stderr)

    def test_others_attempts_are_not_listed(self):
        entry = {"attempt": {"daemon": "strangers", "job": 1, "epoch": 1}, "state": "running"}
        result = self.ask(f"echo '{json.dumps({'version': 1, 'attempts': [entry]})}'")
        self.assertEqual(json.loads(self.succeed(result).stdout)["attempts"], [])

    def test_one_that_reads_nothing(self):
        result = self.ask("""exec <&-; echo '{"version": 1, "attempts": [], "more": 1}'""")
        self.assertEqual(json.loads(self.succeed(result).stdout)["attempts"], [])


if __name__ == "__main__":
    harness.main()
