"""Goal: a service is used from another machine over TLS as it is on its own: by a token, which is made, kept,
limited and revoked; nobody is served without, and a wrong server gets none. Method: a daemon that listens on
loopback, clients with a home of their own and no way to its socket, a certificate by openssl."""

import json
import os
import re
import stat
import subprocess
import time

import harness
from harness import sleight
from service_harness import ServiceTest

TINY = {"chains": 1, "scans": 20, "thin": 1}
ENDLESS = {"chains": 2, "scans": 200_000_000, "thin": 1_000_000}


class Remote(ServiceTest):
    def serve_over_tls(self, *options):
        self.serve("--listen", "127.0.0.1:0", *options)
        server = self.ask_json("server", "status")
        self.address, self.fingerprint = server["address"], server["fingerprint"]

    def token(self, *options):
        """Made on the service's machine; its text and its id."""
        made = self.ask_json("token", "create", "--name", "laptop", *options)
        return made["token"], made["id"]

    def there(self, *args, name="laptop", **options):
        """A command on the other machine."""
        home = self.path(name)
        home.mkdir(exist_ok=True)
        return sleight(*args, env={"HOME": str(home), "XDG_CONFIG_HOME": "", "XDG_STATE_HOME": "",
                                   "SLEIGHT_STATE": "", "SLEIGHT_SOCKET": "",
                                   "SLEIGHT_SERVER": self.address, **options.pop("env", {})}, **options)

    def log_in(self, token, name="laptop", **options):
        return self.there("login", self.address, "--fingerprint", self.fingerprint, name=name,
                          input=token + "\n", **options)

    def logged_in(self, *options, name="laptop"):
        text, number = self.token(*options)
        self.succeed(self.log_in(text, name))
        return number

    def audit(self):
        return [json.loads(line) for line in (self.state / "audit.log").read_text().splitlines()]

    def test_used_as_on_its_own_machine(self):
        self.serve_over_tls()
        self.logged_in()
        request = self.write_request(**TINY)
        job = json.loads(self.succeed(self.there("submit", request, "--json")).stdout)["id"]
        self.assertEqual(self.there("wait", job).returncode, 0)
        self.succeed(self.there("fetch", job, "-o", self.path("there.h5")))
        self.direct(request, self.path("here.h5"))
        self.assertEqual(self.digest(self.path("there.h5")), self.digest(self.path("here.h5")))
        for command in (["list"], ["status", job], ["logs", job], ["watch", job], ["server", "status"]):
            self.succeed(self.there(*command))
        self.assertIn("submit", [line["call"] for line in self.audit() if line.get("token")])

    def test_what_is_kept_is_its_owners_alone(self):
        self.serve_over_tls()
        text, _ = self.token()
        self.succeed(self.log_in(text))
        kept, = (self.path("laptop") / ".config" / "sleight" / "servers").iterdir()
        self.assertEqual(stat.S_IMODE(kept.stat().st_mode), 0o600)
        self.assertEqual(stat.S_IMODE(kept.parent.stat().st_mode), 0o700)
        kept.chmod(0o644)
        result = self.there("list")
        self.assertEqual(result.returncode, 5)
        self.assertIn("others can read this token", result.stderr)
        # The service keeps its hash, and the log no more than its id.
        secret = text.split("_")[2]
        for file in self.state.rglob("*"):
            if file.is_file():
                self.assertNotIn(secret[:20].encode(), file.read_bytes(), file)
        key = self.state / "tls" / "key.pem"
        self.assertEqual(stat.S_IMODE(key.stat().st_mode), 0o600)

    def test_files_of_tokens(self):
        self.serve_over_tls()
        file = self.path("laptop.token")
        self.succeed(self.ask("token", "create", "--name", "laptop", "-o", file))
        self.assertEqual(stat.S_IMODE(file.stat().st_mode), 0o600)
        again = self.ask("token", "create", "--name", "laptop", "-o", file)
        self.assertEqual(again.returncode, 4, again.stderr)
        self.succeed(self.there("login", self.address, "--fingerprint", self.fingerprint,
                                "--token-file", file))
        self.succeed(self.there("list"))
        self.succeed(self.there("logout", self.address))
        result = self.there("list")
        self.assertEqual(result.returncode, 2)
        self.assertIn("was not logged in to", result.stderr)

    def test_wrong_tokens_and_servers(self):
        self.serve_over_tls()
        text, number = self.token()
        other = text[:-10] + ("0" if text[-10] != "0" else "1") + text[-9:]
        result = self.log_in(other)
        self.assertEqual(result.returncode, 2)
        self.assertIn("was all of it copied?", result.stderr)
        self.assertNotIn(other[20:40], result.stderr)
        # Without a fingerprint nobody vouches for it, and the words say what to compare.
        result = self.there("login", self.address, input=text)
        self.assertEqual(result.returncode, 9)
        self.assertIn(self.fingerprint, result.stderr)
        result = self.there("login", self.address, "--fingerprint", "SHA256:" + 64 * "0", input=text)
        self.assertEqual(result.returncode, 9)
        self.succeed(self.log_in(text))
        # A service that has another certificate now gets no token.
        self.daemon.terminate()
        self.daemon.wait()
        for file in (self.state / "tls").iterdir():
            file.unlink()
        port = self.address.split(":")[1]
        self.serve("--listen", f"127.0.0.1:{port}")
        logins = len([line for line in self.audit() if line["call"] == "login"])
        result = self.there("list")
        self.assertEqual(result.returncode, 9)
        self.assertIn("shows another certificate", result.stderr)
        self.assertEqual(len([line for line in self.audit() if line["call"] == "login"]), logins)
        self.fingerprint = self.ask_json("server", "status")["fingerprint"]
        self.succeed(self.log_in(text))
        self.succeed(self.ask("token", "revoke", number))
        result = self.there("list")
        self.assertEqual(result.returncode, 9)
        self.assertIn("not valid here", result.stderr)
        self.assertEqual(self.audit()[-1]["outcome"], "refused")

    def test_revoking_ends_sessions_within_a_second(self):
        self.serve_over_tls()
        number = self.logged_in()
        job = json.loads(self.succeed(self.there("submit", self.write_request(**ENDLESS),
                                                 "--json")).stdout)["id"]
        self.until_running(job)
        home = self.path("laptop")
        watch = subprocess.Popen([harness.program("sleight"), "watch", str(job)],
                                 stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                 env={**harness.environment(), "HOME": str(home), "XDG_CONFIG_HOME": "",
                                      "SLEIGHT_SERVER": self.address})
        self.addCleanup(watch.kill)
        self.until(lambda: self.ask_json("server", "status")["watchers"] > 0)
        self.succeed(self.ask("token", "revoke", number))
        began = time.monotonic()
        self.until(lambda: self.ask_json("server", "status")["watchers"] == 0)
        ended_s = time.monotonic() - began
        print(f"\nthe watch ended {ended_s:.2f} s after its token was revoked")
        _, words = watch.communicate(timeout=20)
        self.assertEqual(watch.returncode, 9, words)
        self.assertLess(ended_s, 1)
        self.assertEqual(self.job(job)["state"], "running")
        self.succeed(self.ask("cancel", job))

    def test_scopes_and_limits(self):
        self.serve_over_tls()
        self.logged_in("--scope", "read", name="reader")
        self.logged_in("--jobs", "1", "--cores", "1", name="small")
        request = self.write_request(**ENDLESS)
        for command in (["submit", request], ["cancel", "1"], ["server", "stop"], ["token", "list"]):
            result = self.there(*command, name="reader")
            self.assertEqual(result.returncode, 9, (command, result.stderr))
        self.succeed(self.there("list", name="reader"))
        result = self.there("submit", request, "--cores", "2", name="small")
        self.assertEqual(result.returncode, 5)
        self.assertIn("at most 1 core", result.stderr)
        job = json.loads(self.succeed(self.there("submit", request, "--json", name="small")).stdout)["id"]
        self.assertEqual(self.job(job)["cores_wanted"], 1)
        result = self.there("submit", request, name="small")
        self.assertEqual(result.returncode, 5)
        self.assertIn("at most 1; there are 1, and 1 more", result.stderr)
        self.assertEqual(self.there("server", "stop", name="small").returncode, 9)
        self.succeed(self.there("cancel", job, name="small"))

    def test_expiry(self):
        self.serve_over_tls()
        text, _ = self.token("--expires", "1s")
        self.succeed(self.log_in(text))
        time.sleep(1.1)
        self.assertEqual(self.there("list").returncode, 9)
        listed = self.ask_json("token", "list", "--all")
        self.assertEqual([token["state"] for token in listed], ["expired"])
        self.assertEqual(self.ask_json("token", "list"), [])
        for wrong in ("0d", "soon", "20000d", "-1s"):
            self.assertEqual(self.ask("token", "create", "--name", "x", f"--expires={wrong}").returncode, 2)

    def test_a_certificate_of_an_authority(self):
        """Made as an organisation makes its own: an authority, and a certificate by it for a host."""
        folder = self.path("authority")
        folder.mkdir()
        script = """
            openssl req -x509 -newkey rsa:2048 -nodes -keyout ca.key -out ca.pem -days 2 -subj /CN=Ours &&
            openssl req -newkey rsa:2048 -nodes -keyout key.pem -out host.csr -subj /CN=localhost &&
            printf 'subjectAltName=DNS:localhost' > names &&
            openssl x509 -req -in host.csr -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 -extfile names -out host.pem
            """
        subprocess.run(["sh", "-c", script], cwd=folder, check=True, capture_output=True)
        files = ["--tls-certificate", folder / "host.pem", "--tls-key", folder / "key.pem"]
        (folder / "key.pem").chmod(0o644)
        result = harness.run([harness.program("sleightd"), "--listen", "127.0.0.1:0", *files],
                             env=self.environment())
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("chmod 600", result.stderr)
        (folder / "key.pem").chmod(0o600)
        self.serve_over_tls(*files)
        text, _ = self.token()
        self.address = self.address.replace("127.0.0.1", "localhost")
        self.succeed(self.there("login", self.address, "--ca", folder / "ca.pem", input=text))
        self.succeed(self.there("list"))
        # The same certificate, for a host that it doesn't name.
        self.address = self.address.replace("localhost", "127.0.0.1")
        result = self.there("login", self.address, "--ca", folder / "ca.pem", input=text)
        self.assertEqual(result.returncode, 9, result.stderr)
        # Its trust in the system's authorities is tested by one that they vouch for, as it were.
        self.address = self.address.replace("127.0.0.1", "localhost")
        self.succeed(self.there("login", self.address, input=text,
                                env={"SSL_CERT_FILE": str(folder / "ca.pem")}))
        self.succeed(self.there("list", env={"SSL_CERT_FILE": str(folder / "ca.pem")}))
        self.assertEqual(self.there("list").returncode, 9)

    def test_old_protocols_are_refused(self):
        self.serve_over_tls()
        for protocol, works in [("-tls1_3", True), ("-tls1_2", True), ("-tls1_1", False), ("-tls1", False)]:
            result = subprocess.run(["openssl", "s_client", "-connect", self.address, protocol,
                                     "-cipher", "ALL:@SECLEVEL=0"], input="", capture_output=True,
                                    text=True, timeout=30)
            agreed = re.search(r"Cipher is (\S+)", result.stdout)
            self.assertEqual(bool(agreed) and agreed[1] != "(NONE)", works, (protocol, result.stdout))

    def test_goes_on_over_a_killed_daemon(self):
        self.serve_over_tls()
        self.logged_in()
        request = self.write_request(**{**TINY, "scans": 100_000})
        job = json.loads(self.succeed(self.there("submit", request, "--json")).stdout)["id"]
        home = self.path("laptop")
        wait = subprocess.Popen([harness.program("sleight"), "wait", str(job)],
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                env={**harness.environment(), "HOME": str(home), "XDG_CONFIG_HOME": "",
                                     "SLEIGHT_SERVER": self.address})
        self.addCleanup(wait.kill)
        self.until(lambda: self.ask_json("server", "status")["watchers"] > 0)
        self.daemon.kill()
        self.daemon.wait()
        self.serve("--listen", self.address)
        _, words = wait.communicate(timeout=60)
        self.assertEqual(wait.returncode, 0, words)
        self.succeed(self.there("fetch", job, "-o", self.path("there.h5")))

    def test_dear_requests_are_refused_with_their_sum(self):
        self.serve_over_tls()
        self.logged_in()
        result = self.there("submit", self.write_request(), "--set", "sampler.chains=65536",
                            "--set", "sampler.method=parallel_tempering")
        self.assertEqual(result.returncode, 5)
        self.assertIn("= 4,194,304 states, and a job of this service has at most 16,384 states",
                      result.stderr)
        self.assertEqual(self.ask_json("list")["jobs"], [])

    def test_addresses_that_are_none(self):
        self.address = "x"
        for address in ("../../etc/passwd", "a b", "host:99999", "-oProxyCommand=x", ""):
            result = self.there("login", address, input="x")
            self.assertEqual(result.returncode, 2, address)
        for address in ("../../x", "a\nb"):
            self.assertEqual(self.there("list", env={"SLEIGHT_SERVER": address}).returncode, 2)
        self.assertFalse((self.path("laptop") / ".config").exists())


if __name__ == "__main__":
    os.umask(0o022)
    harness.main()
