"""Goal: a machine's daemon serves the members of a group, identifies them by the uid that the kernel reports,
and shows no user the jobs of another. It refuses to run as root, and its unit is valid. Method: run a daemon
as its own user, and clients as three other users, two of them in the group. All are real processes. Users are
only numbers, which only root can assume, so others skip the test."""

import json
import os
import pathlib
import shutil
import stat
import subprocess
import tempfile

import harness
from service_harness import ServiceTest

DAEMON, ADA, BOB, EVE = 64001, 64002, 64003, 64004
GROUP, GROUP_ID = "games", 60  # one that every Debian has


def become(user, *groups):
    groups = ["--groups", ",".join(map(str, groups))] if groups else ["--clear-groups"]
    return ["setpriv", "--reuid", str(user), "--regid", str(user), *groups]


class Shared(ServiceTest):
    def setUp(self):
        super().setUp()
        if os.geteuid() != 0 or harness.run([*become(ADA), harness.program("sleight"), "--version"]).returncode:
            self.skipTest("this user can't become others")
        # Accessible to all, like /run/sleight and the users' homes.
        self.machine = pathlib.Path(tempfile.mkdtemp(prefix="sleight-shared-"))
        self.addCleanup(shutil.rmtree, self.machine, ignore_errors=True)
        self.machine.chmod(0o755)
        for name, user in [("run", DAEMON), ("state", DAEMON), ("ada", ADA), ("bob", BOB), ("eve", EVE)]:
            (self.machine / name).mkdir(mode=0o755)
            os.chown(self.machine / name, user, user)
        self.state = self.machine / "state"
        self.socket = self.machine / "run" / "socket"

    def environment(self):
        return {**super().environment(), "SLEIGHT_SOCKET": str(self.socket), "SLEIGHT_ALLOW_ROOT": "0"}

    def serve_group(self):
        return self.serve("--group", GROUP, wrapper=become(DAEMON, GROUP_ID))

    def as_user(self, user, *args, groups=(GROUP_ID,)):
        home = self.machine / {ADA: "ada", BOB: "bob", EVE: "eve"}[user]
        return harness.run([*become(user, *groups), os.path.abspath(harness.program("sleight")), *args], cwd=home,
                           env={"SLEIGHT_SOCKET": str(self.socket), "HOME": str(home),
                                "XDG_CONFIG_HOME": str(home)})

    def request_of(self, user, **changes):
        path = self.machine / {ADA: "ada", BOB: "bob"}[user] / "request.toml"
        path.write_text(harness.request_text(**changes))
        return path

    def submitted(self, user, **changes):
        result = self.succeed(self.as_user(user, "submit", self.request_of(user, **changes), "--json"))
        return str(json.loads(result.stdout)["id"])

    def listed(self, user):
        jobs = json.loads(self.succeed(self.as_user(user, "list", "--json")).stdout)
        return sorted(str(job["id"]) for job in jobs["jobs"])

    def test_users_have_their_own_jobs(self):
        self.serve_group()
        socket = self.socket.stat()
        self.assertEqual((stat.S_IMODE(socket.st_mode), socket.st_uid, socket.st_gid), (0o660, DAEMON, GROUP_ID))
        self.assertEqual(stat.S_IMODE(self.state.stat().st_mode), 0o700)
        of_ada = self.submitted(ADA, chains=2, scans=400)
        of_bob = self.submitted(BOB, chains=1, scans=100_000_000)
        self.succeed(self.as_user(ADA, "wait", of_ada))
        self.assertEqual((self.listed(ADA), self.listed(BOB)), ([of_ada], [of_bob]))
        # For another user, the job doesn't exist.
        never = self.as_user(ADA, "status", "999")
        for command in [["status"], ["logs"], ["cancel"], ["hold"], ["resume"], ["pin"], ["watch"], ["wait"],
                        ["fetch"], ["extend", "--scans", "9"], ["delete", "-y"], ["priority", "--to", "3"]]:
            refused = self.as_user(ADA, command[0], of_bob, *command[1:])
            self.assertNotEqual(refused.returncode, 0, command)
            self.assertIn(never.stderr.replace("999", of_bob).strip(), refused.stderr, command)
        # The job's program runs as the daemon's user, in the daemon's folder.
        self.until(lambda: json.loads(self.as_user(BOB, "status", of_bob, "--json").stdout)["state"] == "running")
        self.until(lambda: (self.folder_of(of_bob) / "attempt.json").exists())
        self.assertEqual(pathlib.Path(f"/proc/{self.keeper(of_bob)}").stat().st_uid, DAEMON)
        # The archive becomes its user's file, with the digest of the run by hand.
        self.succeed(self.as_user(ADA, "fetch", of_ada, "-o", "mine.h5"))
        mine = self.machine / "ada" / "mine.h5"
        self.assertEqual(mine.stat().st_uid, ADA)
        self.assertEqual(self.digest(mine), self.quiet_digest(self.request_of(ADA, chains=2, scans=400)))
        # Users may neither drain nor stop the daemon. Its own user and root may.
        for command in ["drain", "stop"]:
            refused = self.as_user(BOB, "server", command)
            self.assertEqual(refused.returncode, 9, refused.stderr)
        self.assertEqual(len(self.ask_json("list")["jobs"]), 2)
        self.succeed(self.as_user(BOB, "cancel", of_bob))
        self.assertEqual(self.as_user(BOB, "wait", of_bob).returncode, 11)
        self.succeed(self.ask("server", "stop"))

    def test_others_are_not_let_in(self):
        self.serve_group()
        for user, groups in [(EVE, ()), (ADA, ())]:
            refused = self.as_user(user, "list", groups=groups)
            self.assertEqual(refused.returncode, 9, refused.stderr)
        self.succeed(self.as_user(ADA, "list"))

    def test_what_can_not_be_shared_is_said(self):
        """Errors: root, an unknown group, a group without the daemon's user, an unreachable socket."""
        daemon = harness.program("sleightd")
        env = self.environment()

        def refused(code, words, *command):
            result = subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=30,
                                    env={**harness.environment(), **env})
            self.assertEqual(result.returncode, code, result.stderr)
            self.assertIn(words, result.stderr)

        refused(9, "--allow-root", daemon)
        refused(9, "--allow-root", harness.program("sleight"), "server", "start", "--foreground")
        of_its_user = [*become(DAEMON, GROUP_ID), daemon]
        refused(2, "--group: no group no-such-group", *of_its_user, "--group", "no-such-group")
        refused(5, "can't listen", *become(DAEMON), daemon, "--group", GROUP)
        inside = self.state / "socket"
        refused(2, "the socket must be outside", *of_its_user, "--group", GROUP, "--socket", inside)
        self.assertEqual(list(self.state.glob("jobs/*")), [])


class Unit(harness.ProgramTest):
    """The unit that starts such a daemon under systemd, checked without a running systemd."""

    def test_systemd_finds_nothing_wrong_and_little_that_is_exposed(self):
        unit = self.path("sleightd.service")
        text = (pathlib.Path(harness.arguments.source) / "deploy/systemd/sleightd.service").read_text()
        # The unit must name an existing program, not one installed on this machine.
        self.assertIn("ExecStart=/usr/bin/sleightd ", text)
        unit.write_text(text.replace("/usr/bin/sleightd ", os.path.abspath(harness.program("sleightd")) + " "))
        verified = self.succeed(harness.run(["systemd-analyze", "verify", "--man=no", unit]))
        # Messages about this machine's own units don't matter.
        self.assertNotIn("sleightd", verified.stdout + verified.stderr)
        judged = self.succeed(harness.run(["systemd-analyze", "security", "--offline=yes", "--threshold=20", unit]))
        level = float(judged.stdout.split("Overall exposure level for sleightd.service: ")[1].split()[0])
        self.assertLessEqual(level, 2)
        # The daemon accepts the unit's command line, and jobs outlive the daemon.
        options = text.split("ExecStart=/usr/bin/sleightd ")[1].splitlines()[0].split()
        self.assertEqual(options[0::2], ["--state", "--socket", "--group"])
        self.assertIn("\nKillMode=process\n", text)


if __name__ == "__main__":
    harness.main()
