"""Goal: a service works from another machine over TLS as on its own: with a token that is created, stored,
limited and revoked. An untrusted server receives no token. Method: a daemon that listens on loopback, clients
without access to its socket, and certificates by openssl. test_hostile_peers tests hostile peers."""

import json
import re
import stat
import subprocess

import harness
from service_harness import TlsServiceTest

TINY = {"chains": 1, "scans": 20, "thin": 1}


class Remote(TlsServiceTest):
    def logged_in(self, home="laptop", *options):
        """Returns the token's file and id."""
        file, number = self.token(home, *options)
        self.succeed(self.log_in(home, file))
        return file, number

    def submit_from(self, home, request, *args):
        return json.loads(self.succeed(self.far(home, "submit", request, "--json", *args)).stdout)["id"]

    def audit(self):
        return [json.loads(line) for line in (self.state / "audit.log").read_text().splitlines()]

    def test_used_as_on_its_own_machine(self):
        self.serve_over_tls()
        self.logged_in()
        request = self.write_request(**TINY)
        job = self.submit_from("laptop", request)
        self.assertEqual(self.far("laptop", "wait", job).returncode, 0)
        self.succeed(self.far("laptop", "fetch", job, "-o", self.path("there.h5")))
        self.direct(request, self.path("here.h5"))
        self.assertEqual(self.digest(self.path("there.h5")), self.digest(self.path("here.h5")))
        for command in (["list"], ["status", job], ["logs", job], ["watch", job], ["server", "status"]):
            self.succeed(self.far("laptop", *command))
        self.assertIn("submit", [line["call"] for line in self.audit() if line.get("token")])

    def test_what_is_kept_is_its_owners_alone(self):
        self.serve_over_tls()
        file, _ = self.logged_in()
        kept, = (self.path("laptop") / "sleight" / "servers").iterdir()
        self.assertEqual(stat.S_IMODE(kept.stat().st_mode), 0o600)
        self.assertEqual(stat.S_IMODE(kept.parent.stat().st_mode), 0o700)
        kept.chmod(0o644)
        result = self.far("laptop", "list")
        self.assertEqual(result.returncode, 5)
        # The service stores the token's hash, and the log only its id.
        secret = file.read_text().split("_")[2]
        for one in self.state.rglob("*"):
            if one.is_file():
                self.assertNotIn(secret[:20].encode(), one.read_bytes(), one)
        for private in (file, self.state / "tls" / "key.pem", self.state / "tokens.json", self.state / "audit.log"):
            self.assertEqual(stat.S_IMODE(private.stat().st_mode), 0o600, private)

    def test_logging_in_and_out(self):
        self.serve_over_tls()
        file, number = self.token("laptop")
        again = self.ask("token", "create", "--name", "laptop", "-o", file)
        self.assertEqual(again.returncode, 4, again.stderr)
        # A token on standard input, as from a pipe of ssh.
        self.succeed(self.far("laptop", "login", self.address, "--fingerprint", self.fingerprint,
                              input=file.read_text()))
        self.succeed(self.far("laptop", "list"))
        self.succeed(self.far("laptop", "logout", self.address))
        result = self.far("laptop", "list")
        self.assertEqual(result.returncode, 2)
        self.succeed(self.ask("token", "revoke", number))
        self.assertEqual(self.ask_json("token", "list"), [])
        self.assertEqual([token["state"] for token in self.ask_json("token", "list", "--all")], ["revoked"])
        for wrong in ("0d", "soon", "20000d", "-1s"):
            self.assertEqual(self.ask("token", "create", "--name", "x", f"--expires={wrong}").returncode, 2)

    def test_servers_that_can_not_be_trusted(self):
        self.serve_over_tls()
        file, _ = self.token("laptop")
        # Without a fingerprint the server is not trusted, and the error prints what to compare.
        result = self.far("laptop", "login", self.address, "--token-file", file)
        self.assertEqual(result.returncode, 9)
        self.assertIn(self.fingerprint, result.stderr)
        result = self.far("laptop", "login", self.address, "--token-file", file,
                          "--fingerprint", "SHA256:" + 64 * "0")
        self.assertEqual(result.returncode, 9)
        self.succeed(self.log_in("laptop", file))
        # A service with a new certificate receives no token.
        self.daemon.terminate()
        self.daemon.wait()
        for one in (self.state / "tls").iterdir():
            one.unlink()
        self.serve_over_tls()
        logins = len([line for line in self.audit() if line["call"] == "login"])
        result = self.far("laptop", "list")
        self.assertEqual(result.returncode, 9)
        self.assertEqual(len([line for line in self.audit() if line["call"] == "login"]), logins)
        self.succeed(self.log_in("laptop", file))
        self.succeed(self.far("laptop", "list"))

    def test_a_certificate_of_an_authority(self):
        """Certificates made like an organisation's: an authority, and a certificate by it for a host."""
        folder = self.path("authority")
        folder.mkdir()
        script = """
            openssl req -x509 -newkey rsa:2048 -nodes -keyout ca.key -out ca.pem -days 2 -subj /CN=Ours &&
            openssl req -x509 -newkey rsa:2048 -nodes -keyout other.key -out other.pem -days 2 -subj /CN=Theirs &&
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
        (folder / "key.pem").chmod(0o600)
        self.serve("--listen", "127.0.0.1:0", *files)
        number = self.ask_json("server", "status")["address"]
        file, _ = self.token("laptop")
        self.address = number.replace("127.0.0.1", "localhost")
        by_authority = ["--token-file", file, "--ca", folder / "ca.pem"]
        self.succeed(self.far("laptop", "login", self.address, *by_authority))
        self.succeed(self.far("laptop", "list"))
        # The same certificate, for a host that it doesn't name.
        result = self.far("laptop", "login", number, *by_authority)
        self.assertEqual(result.returncode, 9, result.stderr)
        # The certificate can be anywhere in a bundle.
        for bundle in (["other.pem", "ca.pem"], ["ca.pem", "other.pem"]):
            (folder / "bundle.pem").write_text("".join((folder / name).read_text() for name in bundle))
            self.succeed(self.far("laptop", "login", self.address, "--token-file", file, "--ca", folder / "bundle.pem"))
            self.succeed(self.far("laptop", "list"))
        # A fingerprint is for certificates that the service makes itself.
        result = self.far("laptop", "login", self.address, "--token-file", file, "--fingerprint",
                          self.ask_json("server", "status")["fingerprint"])
        self.assertEqual(result.returncode, 2, result.stderr)
        # If the system trusts the authority, nothing else is necessary.
        trusting = {**self.far_environment("laptop"), "SSL_CERT_FILE": str(folder / "ca.pem")}
        self.succeed(harness.sleight("login", self.address, "--token-file", file, env=trusting))
        self.succeed(harness.sleight("list", env=trusting))
        self.assertEqual(self.far("laptop", "list").returncode, 9)

    def test_a_certificate_that_vouches_for_itself(self):
        """The operator's own certificate, for a host or for a time, is identified by its fingerprint, for any
        host."""
        folder = self.path("own")
        folder.mkdir()
        make = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-subj", "/CN=render.example.org"]
        for name, when in (("now", []), ("old", ["faketime", "2020-01-01"])):
            subprocess.run([*when, *make, "-keyout", f"{name}.key", "-out", f"{name}.pem", "-days", "2"], cwd=folder,
                           check=True, capture_output=True)
            (folder / f"{name}.key").chmod(0o600)
        self.serve("--listen", "127.0.0.1:0", "--tls-certificate", folder / "now.pem", "--tls-key", folder / "now.key")
        status = self.ask_json("server", "status")
        self.address, self.fingerprint = status["address"], status["fingerprint"]
        file, _ = self.token("laptop")
        openssl = subprocess.run(["openssl", "x509", "-in", folder / "now.pem", "-noout", "-sha256", "-fingerprint"],
                                 check=True, capture_output=True, text=True).stdout.strip()
        for fingerprint in (self.fingerprint, self.fingerprint.upper(), openssl):
            self.succeed(self.far("laptop", "login", self.address, "--token-file", file, "--fingerprint", fingerprint))
        self.succeed(self.far("laptop", "list"))
        for wrong in ("SHA256:00", "here", self.fingerprint[:-1], self.fingerprint[:-1] + "g"):
            result = self.far("laptop", "login", self.address, "--token-file", file, "--fingerprint", wrong)
            self.assertEqual(result.returncode, 2, result.stderr)
        # The same with a wrong clock on this machine: the error is about the time, not about an impostor.
        result = harness.run(["faketime", "+10 days", harness.program("sleight"), "list"],
                             env=self.far_environment("laptop"))
        self.assertEqual(result.returncode, 9)
        self.assertIn("certificate has expired", result.stderr)
        self.daemon.terminate()
        self.daemon.wait()
        self.serve("--listen", "127.0.0.1:0", "--tls-certificate", folder / "old.pem", "--tls-key", folder / "old.key")
        self.assertIn("has expired", self.path("sleightd.log").read_text())

    def test_old_protocols_are_refused(self):
        self.serve_over_tls()
        for protocol, works in [("-tls1_3", True), ("-tls1_2", True), ("-tls1_1", False), ("-tls1", False)]:
            result = subprocess.run(["openssl", "s_client", "-connect", self.address, protocol,
                                     "-cipher", "ALL:@SECLEVEL=0"], input="", capture_output=True,
                                    text=True, timeout=30)
            agreed = re.search(r"Cipher is (\S+)", result.stdout)
            self.assertEqual(bool(agreed) and agreed[1] != "(NONE)", works, (protocol, result.stdout))


if __name__ == "__main__":
    harness.main()
