"""Shared by tests of the service: a daemon in a folder of its own, and time limits."""

import json
import os
import pathlib
import signal
import subprocess
import time

import harness
from harness import ProgramTest


class ServiceTest(ProgramTest):
    """Each test has a state folder and starts its daemon when needed. At the end, the daemon and its jobs are
    killed."""

    def setUp(self):
        super().setUp()
        self.state = self.path("state")
        self.daemon = None
        self.addCleanup(self.end_everything)

    def environment(self):
        return {"SLEIGHT_STATE": str(self.state), "XDG_CONFIG_HOME": str(self.path("config"))}

    def serve(self, *options, wrapper=(), **more):
        """Starts a daemon and waits until it answers."""
        log = open(self.path("sleightd.log"), "a")
        self.daemon = subprocess.Popen(
            [*wrapper, harness.program("sleightd"), *[str(option) for option in options]],
            stdout=log, stderr=log, stdin=subprocess.DEVNULL,
            env={**harness.environment(), **self.environment(), **more.get("env", {})})
        log.close()
        self.until(lambda: self.ask("server", "status").returncode == 0 or self.dead_daemon(), 30)
        return self.daemon

    def dead_daemon(self):
        if self.daemon.poll() is None:
            return False
        self.fail(f"the daemon ended with {self.daemon.returncode}:\n"
                  f"{self.path('sleightd.log').read_text()}")

    def ask(self, *args, **options):
        return harness.sleight(*args, env=self.environment(), **options)

    def ask_json(self, *args):
        return json.loads(self.succeed(self.ask(*args, "--json")).stdout)

    def submit(self, request, *args):
        return self.ask_json("submit", request, *args)["id"]

    def job(self, number):
        return self.ask_json("status", number)

    def wait(self, number, code=0):
        result = self.ask("wait", number)
        self.assertEqual(result.returncode, code,
                         f"{result.stdout}{result.stderr}\n{json.dumps(self.job(number), indent=1)}"
                         f"\n{self.path('sleightd.log').read_text()}")

    def until(self, holds, seconds=60):
        end = time.monotonic() + seconds
        while not holds():
            self.assertLess(time.monotonic(), end, "waited in vain; the daemon says:\n"
                            + self.path("sleightd.log").read_text())
            time.sleep(0.02)

    def until_running(self, number):
        self.until(lambda: self.job(number)["scans_done"] > 0)

    def folder_of(self, number):
        return self.state / "jobs" / str(number)

    def attempt(self, number):
        return json.loads((self.folder_of(number) / "attempt.json").read_text())

    def keeper(self, number):
        return self.attempt(number)["keeper"]["pid"]

    def kill_daemon(self, number=signal.SIGKILL):
        self.daemon.send_signal(number)
        self.daemon.wait(timeout=30)

    def end_everything(self):
        if self.daemon and self.daemon.poll() is None:
            self.kill_daemon()
        # The exit of a wrapper is not the daemon's.
        try:
            pid = int((self.state / "lock").read_text())
            if pathlib.Path(f"/proc/{pid}/comm").read_text().strip() == "sleightd":
                os.kill(pid, signal.SIGKILL)
        except (OSError, ValueError):
            pass
        for record in self.state.glob("jobs/*/attempt.json"):
            try:
                os.kill(json.loads(record.read_text())["keeper"]["pid"], signal.SIGKILL)
            except (OSError, ValueError, KeyError):
                pass

    def quiet_digest(self, request, *args):
        """Digest of the same run by hand."""
        output = self.path(f"quiet-{time.monotonic_ns()}.h5")
        self.direct(request, output, *args)
        return self.digest(output)


class TlsServiceTest(ServiceTest):
    """A daemon that also listens over TLS, on a port of its own choice, which it uses again after a
    restart."""

    def setUp(self):
        super().setUp()
        self.address = "127.0.0.1:0"

    def serve_over_tls(self, **more):
        self.serve("--listen", self.address, "--cores", 1, **more)
        status = self.ask_json("server", "status")
        self.address, self.fingerprint = status["address"], status["fingerprint"]
        return self.daemon

    def token(self, name, *options):
        """Creates a token as a file. Returns the file and the token's id."""
        path = self.path(f"{name}.token")
        made = self.ask_json("token", "create", "--name", name, "-o", path, *options)
        return path, made["id"]

    def far(self, home, *args, **options):
        """Runs `sleight` as on another machine, with its data about servers in `home`."""
        return harness.sleight(*args, env=self.far_environment(home), **options)

    def far_environment(self, home):
        return {"XDG_CONFIG_HOME": str(self.path(home)), "SLEIGHT_SERVER": self.address,
                "SLEIGHT_STATE": str(self.path("no state here"))}

    def log_in(self, home, token):
        return self.far(home, "login", self.address, "--token-file", token, "--fingerprint", self.fingerprint)


def processes_of(folder):
    """Running processes whose working folder is the job's."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if os.readlink(process / "cwd") == str(folder):
                state = (process / "stat").read_text().rpartition(")")[2].split()[0]
                name = (process / "comm").read_text().strip()
                if state != "Z":
                    found.append((int(process.name), name))
        except OSError:
            continue
    return found
