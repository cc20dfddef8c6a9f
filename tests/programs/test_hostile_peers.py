"""Goal: over TLS, unauthorized peers get no service, odd names are refused in printable words, expensive
requests are refused with their total, and neither silent peers nor a killed daemon block others. Method: run
a daemon that listens over TLS, real `sleight` processes that log in as from another machine, and silent
sockets."""

import contextlib
import json
import os
import pathlib
import re
import resource
import signal
import socket
import subprocess

import harness
from service_harness import TlsServiceTest

CLIENTS = 200 if os.environ.get("SLEIGHT_SOAK") else 60


class Tokens(TlsServiceTest):
    def test_wrong_expired_and_revoked_ones_let_nobody_in(self):
        self.serve_over_tls()
        unknown, _ = self.token("unknown")
        # A daemon that doesn't know the token, at the same place with the same certificate.
        self.kill_daemon(signal.SIGTERM)
        (self.state / "tokens.json").unlink()
        self.serve_over_tls()
        good, _ = self.token("good")
        revoked, revoked_id = self.token("revoked")
        self.succeed(self.ask("token", "revoke", revoked_id))
        self.succeed(self.log_in("good", good))
        expired, _ = self.token("expired", "--expires", "4s")
        # A token that expires during a session is refused from then on.
        self.succeed(self.log_in("late", expired))
        self.until(lambda: self.far("late", "list").returncode == 9)
        words = set()
        for home, token in [("unknown", unknown), ("revoked", revoked), ("expired", expired)]:
            refused = self.log_in(home, token)
            self.assertEqual(refused.returncode, 9, refused.stderr)
            words.add(refused.stderr)
            self.assertFalse(self.path(home).exists(), "a token that is not valid is kept")
        # The error doesn't reveal which tokens exist.
        self.assertEqual(len(words), 1, words)
        # Text that isn't a token is never sent.
        bad = self.path("bad.token")
        for text in ["", "sleight_" + "0" * 70, good.read_text()[:-2], "../" * 1000, "\x1b[2J"]:
            bad.write_text(text)
            refused = self.log_in("bad", bad)
            self.assertEqual(refused.returncode, 2, refused.stderr)
        self.succeed(self.far("good", "list"))


class Clients(TlsServiceTest):
    def test_many_at_once_are_answered_and_outlive_a_killed_daemon(self):
        self.serve_over_tls()
        token, _ = self.token("many")
        self.succeed(self.log_in("many", token))
        held = self.submit(self.write_request(chains=1, scans=100_000_000))
        self.succeed(self.ask("hold", held))
        environment = {**harness.environment(), **self.far_environment("many")}
        watchers = []
        with contextlib.ExitStack() as ends:
            for _ in range(CLIENTS):
                watchers.append(ends.enter_context(subprocess.Popen(
                    [harness.program("sleight"), "watch", str(held), "--json"], stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL, env=environment)))
            ends.callback(lambda: [watcher.kill() for watcher in watchers])

            def watching():
                return self.ask_json("server", "status")["watchers"]

            self.until(lambda: watching() == CLIENTS)
            self.succeed(self.far("many", "list"))
            self.kill_daemon()
            self.serve_over_tls()
            self.until(lambda: watching() == CLIENTS)
            self.succeed(self.ask("cancel", held))
            self.assertEqual({watcher.wait(timeout=60) for watcher in watchers}, {11})

    def test_silent_peers_keep_nobody_out(self):
        """Goal: more silent peers than allowed don't lock others out. Method: 100 strangers over TLS, where
        64 are allowed, and 550 on the socket, where 512 are. They stay silent or send half a word."""
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
        self.addCleanup(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        self.serve_over_tls()
        token, _ = self.token("honest")
        self.succeed(self.log_in("honest", token))
        host, port = self.address.split(":")
        with contextlib.ExitStack() as ends:
            def peer(family, place, words):
                one = ends.enter_context(socket.socket(family, socket.SOCK_STREAM))
                one.settimeout(10)
                # The daemon's backlog may be full for a moment.
                self.until(lambda: one.connect_ex(place) == 0, 10)
                one.sendall(words)
                return one

            def served():
                self.succeed(self.ask("list"))
                self.succeed(self.far("honest", "list"))

            strangers = [peer(socket.AF_INET, (host, int(port)), b"\x16\x03\x01"[:i % 4]) for i in range(100)]
            served()
            here = [peer(socket.AF_UNIX, str(self.state / "socket"), b"abc"[:i % 3]) for i in range(550)]
            served()
            # It was an attack: some peers were disconnected, and some are still connected.
            self.assertGreater(self.ask_json("server", "status")["connections"], 200)
            ended = 0
            for one in strangers + here:
                one.setblocking(False)
                try:
                    one.recv(1)
                except BlockingIOError:
                    continue
                except ConnectionResetError:
                    pass
                ended += 1
            self.assertGreater(ended, 0)
            self.assertLess(ended, 600)


class Names(TlsServiceTest):
    ODD = ["../../../../tmp/sleight-evil", "/etc/passwd", "\x1b[2J\x1b]0;evil\x07", "a\nb\r", "\x7f", "..", "%s%n",
           "\udcff\udcfe", "\u202e", "x" * 100_000, "-1", "99999999999999999999999", "g", "1..", "3..1", " ", ""]

    def refused(self, codes, result):
        """Refused in words that a terminal can show, of limited length."""
        self.assertIn(result.returncode, codes, result.stderr[:1000])
        self.assertRegex(result.stderr, r"\S")
        self.assertLess(len(result.stderr), 5000)
        for line in result.stderr.splitlines():
            self.assertIsNone(re.search(r"[\x00-\x08\x0b-\x1f\x7f\x80-\x9f\u202e]", line), repr(line[:300]))

    def listing(self):
        """Everything that this test's processes could have written, except for the service's own files."""
        notes = ("state/audit", "sleightd.log", "state/jobs.")
        found = sorted(str(path.relative_to(self.folder)) for path in self.folder.rglob("*"))
        return [name for name in found if not name.startswith(notes)]

    def text(self, name):
        return name.encode(errors="surrogateescape")

    def raw(self, env, *args):
        """Runs `sleight` with arguments of any bytes; the output must be text."""
        result = subprocess.run([self.text(harness.program("sleight")), *map(self.text, args)], capture_output=True,
                                env={**harness.environment(), **env}, timeout=60, cwd=self.folder)
        return subprocess.CompletedProcess(args, result.returncode, result.stdout.decode(), result.stderr.decode())

    def test_servers_are_refused(self):
        """Goal: a server's name is part of a file name, but never leaves the folder."""
        self.serve_over_tls()
        token, _ = self.token("any")
        before = self.listing()
        here = {"XDG_CONFIG_HOME": str(self.path("home"))}
        for odd in self.ODD:
            if odd.strip():
                far = {**self.far_environment("home"), "SLEIGHT_SERVER": self.text(odd)}
                self.refused({2, 12}, self.raw(far, "list"))
            self.refused({2, 9, 12}, self.raw(here, "login", "--token-file", str(token), "--", odd))
        # Nothing is deleted for a name that leads nowhere.
        for odd in self.ODD[:4]:
            self.refused({2}, self.raw(here, "logout", "--", odd))
        self.assertEqual(self.listing(), before)

    def test_names_of_jobs_and_tokens_are_texts_alone(self):
        self.serve_over_tls()
        request = self.write_request(chains=1, scans=10)
        kept = {}
        for odd in [*self.ODD[:5], "x" * 100_000]:
            made = self.raw(self.environment(), "submit", str(request), "--json", "--name", odd)
            if made.returncode == 0:
                kept[odd] = json.loads(made.stdout)["id"]
            else:
                self.refused({2, 3}, made)
        for odd in self.ODD:
            named = self.raw(self.environment(), "token", "create", "--name", odd)
            if named.returncode != 0:
                self.refused({2, 3}, named)
        # Printable names are valid and lead nowhere: the job's number is its folder.
        self.assertIn("../../../../tmp/sleight-evil", kept)
        self.assertIn("/etc/passwd", kept)
        self.assertNotIn("x" * 100_000, kept)
        for number in kept.values():
            self.wait(number)
        for job in self.ask_json("list")["jobs"]:
            self.assertIsNone(re.search(r"[\x00-\x1f\x7f]", job["name"]), job["name"])
        self.assertEqual(sorted(int(path.name) for path in (self.state / "jobs").iterdir()), sorted(kept.values()))
        self.assertFalse(pathlib.Path("/tmp/sleight-evil").exists())
        # Shown to people, no name affects the terminal.
        for shown in [["list"], ["token", "list"], ["status", *map(str, kept.values())]]:
            text = self.raw(self.environment(), *shown).stdout
            self.assertIsNone(re.search(r"[\x00-\x08\x0b-\x1f\x7f]", text), repr(text))
        # Fetched without a name, the file has the job's number.
        fetched = self.path("fetched")
        fetched.mkdir()
        evil = str(kept["../../../../tmp/sleight-evil"])
        self.succeed(harness.sleight("fetch", evil, env=self.environment(), cwd=fetched))
        self.assertEqual([path.name for path in fetched.iterdir()], [f"job-{evil}.h5"])
        self.refused({5}, self.raw(self.environment(), "fetch", evil, "-o", "no/such/../folder/x.h5"))
        self.refused({4, 5}, self.raw(self.environment(), "fetch", evil, "-o", "/"))

    def test_a_request_that_is_too_dear_is_refused_with_its_sum(self):
        self.serve_over_tls()
        dear = self.ask("submit", self.write_request(chains=65536))
        self.refused({5}, dear)
        self.assertRegex(dear.stderr, r"65,536 chains = 65,536 states.*\b16,384 states")
        self.assertIn("limits.states", dear.stderr)
        long = self.ask("submit", self.write_request(chains=1000, scans=1_000_000_000, iterations_per_scan=1000))
        self.refused({5}, long)
        self.assertRegex(long.stderr, r"\b1,000 chains x 1,000 .* x 1,000,000,000 scans = "
                                      r"1,000,000,000,000,000 simulations")
        self.assertIn("limits.simulations", long.stderr)
        # One too expensive request of a group refuses all.
        group = self.ask("submit", self.write_request(chains=4), "--set", "sampler.chains={4,65536}")
        self.refused({5}, group)
        self.assertEqual(self.ask_json("list")["jobs"], [])


if __name__ == "__main__":
    harness.main()
