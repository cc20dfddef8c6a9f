"""Goal: the commands of docs/OPERATING.md work as printed. Method: run every block marked `sh`, in order,
in one shell, with the names of machine, port, group and folders replaced by the test's. After each start
of a daemon, wait until it answers."""

import pathlib
import re
import socket
import subprocess

import harness
from service_harness import ServiceTest

FINGERPRINT = "sleight server status --json | jq -r .fingerprint"


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class OperatorsPage(ServiceTest):
    def script(self):
        page = (pathlib.Path(harness.arguments.source) / "docs" / "OPERATING.md").read_text()
        blocks = re.findall(r"^```sh\n(.*?)^```$", page, re.S | re.M)
        self.assertGreater(len(blocks), 6)
        text = "\n".join(blocks)
        names = {"/var/lib/sleight": str(self.state), "/run/sleight/socket": str(self.path("socket")),
                 "--group sleight": "--group games", "0.0.0.0": "127.0.0.1", "render.example.org": "localhost",
                 "7423": str(free_port())}
        for name, ours in names.items():
            self.assertIn(name, text)
            text = text.replace(name, ours)
        lines = []
        for line in text.splitlines():
            command = line.split("  #")[0].rstrip()
            if command.startswith(FINGERPRINT):
                line = f"FINGERPRINT=$({command}); test -n \"$FINGERPRINT\""
            lines.append(line)
            if command.endswith("&"):
                lines.append("until sleight server status > /dev/null 2>&1; do sleep 0.05; done")
        return "set -euo pipefail\nset -x\n" + "\n".join(lines) + "\n"

    def test_commands(self):
        home = self.path("home")
        home.mkdir()
        (self.folder / "requests").symlink_to(pathlib.Path(harness.arguments.source).resolve() / "requests")
        bin_folder = str(harness.program("sleight")).rsplit("/", 1)[0]
        environment = {**harness.environment(), "HOME": str(home), "SLEIGHT_SOCKET": str(self.path("socket")),
                       "PATH": f"{bin_folder}:{harness.environment()['PATH']}"}
        for name in ("XDG_CONFIG_HOME", "XDG_STATE_HOME", "SLEIGHT_STATE", "SLEIGHT_SERVER"):
            environment.pop(name, None)
        result = subprocess.run(["bash"], input=self.script(), text=True, cwd=self.folder, env=environment,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=100)
        self.assertEqual(result.returncode, 0, result.stdout)
        # Check that the commands had their effects.
        self.assertRegex(self.succeed(harness.sleight("archive", "info", self.path("ball.h5"))).stdout, "ball_2d")
        self.assertRegex(result.stdout, r"limits\.states +4096 +file")
        self.assertRegex(result.stdout, r"slurm\.partition +batch +file")
        self.assertRegex(result.stdout, r"\tlogin\t.*done")
        self.assertRegex(result.stdout, r"\trevoke_token\t|is revoked")
        self.assertTrue((self.path("state.copy") / "jobs.sqlite").exists())


if __name__ == "__main__":
    harness.main()
