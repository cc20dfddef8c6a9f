"""Goal: the Debian package is sound. lintian finds no error in it, a plain Debian 12 installs it, ordinary
users can use its programs, an upgrade interrupts no job, and removal deletes nobody's work. Method: build the
package, and install it with its dependencies by apt in a Debian 12 made by debootstrap. Nothing there runs
systemd, so start the daemon by hand with the command of its unit. deploy/soak packages runs this test, which
needs root, packages' mirrors and some minutes."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import time
import unittest

import harness


def run(*command, **options):
    result = subprocess.run([str(part) for part in command], capture_output=True, text=True, **options)
    assert result.returncode == 0, f"{command}\n{result.stdout[-3000:]}{result.stderr[-3000:]}"
    return result.stdout


def built(version=None):
    """The package file, or one with another version and the same programs."""
    source = harness.arguments.source
    run("cmake", "--preset", "package", cwd=source)
    run("cmake", "--build", "--preset", "package", cwd=source)
    folder = pathlib.Path(source) / "build" / "package"
    for old in folder.glob("sleight_*.deb"):
        old.unlink()
    more = ["-D", f"CPACK_DEBIAN_PACKAGE_VERSION={version}"] if version else []
    run("cpack", "--preset", "package", *more, cwd=source)
    package, = folder.glob("sleight_*.deb")
    return package.rename(package.parent / f"built_{package.name}")


class Machine:
    """A Debian 12 in a folder, from the same mirror as this machine's Debian."""

    def __init__(self):
        self.daemon = None
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="sleight-debian-"))
        self.root.chmod(0o755)
        mirror = run("apt-get", "indextargets", "--format", "$(REPO_URI)", "Created-By: Packages", "Origin: Debian",
                     "Codename: bookworm").split()[0]
        run("debootstrap", "--variant=minbase", "bookworm", self.root, mirror)
        for place in ["etc/resolv.conf", "etc/hosts"]:
            shutil.copy(pathlib.Path("/", place), self.root / place)
        run("mount", "-t", "proc", "proc", self.root / "proc")
        self.inside("apt-get", "-q", "update")

    def remove(self):
        if self.daemon:
            self.daemon.kill()
        # Processes that still run there: keepers and their jobs.
        for process in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                if os.readlink(process / "root") == str(self.root):
                    os.kill(int(process.name), 9)
            except OSError:
                continue
        time.sleep(0.5)
        run("umount", "-l", self.root / "proc")
        shutil.rmtree(self.root, ignore_errors=True)

    def inside(self, *command):
        return run("chroot", self.root, "env", "DEBIAN_FRONTEND=noninteractive", "PATH=/usr/sbin:/usr/bin:/sbin:/bin",
                   *command)

    def as_user(self, user, *command):
        return run("chroot", f"--userspec={user}", self.root, "env", f"HOME=/home/{user}", "PATH=/usr/bin:/bin",
                   "sh", "-c", f"cd /home/{user} && exec \"$@\"", "sh", *command)

    def put(self, package):
        shutil.copy(package, self.root / "tmp" / package.name)
        return f"/tmp/{package.name}"

    def start_daemon(self):
        """Starts the daemon like the unit: same user, folders and command."""
        unit = (self.root / "usr/lib/systemd/system/sleightd.service").read_text()
        command = re.search(r"^ExecStart=(.*)$", unit, re.MULTILINE)[1].split()
        for folder, mode in [("/var/lib/sleight", "0700"), ("/run/sleight", "0755")]:
            self.inside("install", "-d", "-o", "sleight", "-g", "sleight", "-m", mode, folder)
        self.daemon = subprocess.Popen(["chroot", "--userspec=sleight:sleight", str(self.root), *command],
                                       stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        end = time.monotonic() + 30
        while not (self.root / "run/sleight/socket").exists():
            assert time.monotonic() < end and self.daemon.poll() is None, "the daemon doesn't answer"
            time.sleep(0.05)

    def stop_daemon(self):
        self.daemon.terminate()
        self.daemon.wait(timeout=30)


class Packages(unittest.TestCase):
    def test_it_is_a_package(self):
        package = built()
        said = subprocess.run(["lintian", "--allow-root", "--fail-on", "error", str(package)], capture_output=True,
                              text=True)
        print(said.stdout)
        self.assertEqual(said.returncode, 0, said.stdout + said.stderr)
        fields = run("dpkg-deb", "--field", package)
        for library in ["libhdf5", "libcapnp", "libopenmpi", "libsqlite3"]:
            self.assertIn(library, fields)
        self.assertNotIn("libgtest", fields)

    def test_installed_used_upgraded_removed(self):
        first = built()
        version = run("dpkg-deb", "--field", first, "Version").strip()
        second = built(version + "+2")
        machine = Machine()
        self.addCleanup(machine.remove)
        machine.inside("apt-get", "install", "-y", "--no-install-recommends", machine.put(first))
        for user in ["ada", "bob"]:
            machine.inside("useradd", "-m", "-G", "sleight", user)

        # Without a daemon, like anybody.
        machine.as_user("ada", "sleight", "direct", "--word", "HI", "-o", "hi.h5", "-q")
        machine.as_user("ada", "sleight", "archive", "verify", "hi.h5")
        machine.as_user("ada", "sleight", "plot", "hi.h5", "-o", "hi.svg")
        machine.as_user("ada", "sleight", "gallery", "hi.h5", "--save", "hi_gallery")
        self.assertTrue((machine.root / "home/ada/hi_gallery/index.html").exists())
        self.assertIn(version.split("+g")[1][:7], machine.as_user("ada", "sleight", "--version"))

        # A job continues under its keeper while the package is replaced, and the new daemon adopts it.
        machine.start_daemon()
        request = machine.root / "home/ada/long.toml"
        request.write_text(harness.request_text(chains=2, scans=50_000_000, iterations_per_scan=50))
        job = str(json.loads(machine.as_user("ada", "sleight", "submit", "long.toml", "--json"))["id"])

        def status():
            return json.loads(machine.as_user("ada", "sleight", "status", job, "--json"))

        end = time.monotonic() + 60
        while status()["scans_done"] == 0:
            self.assertLess(time.monotonic(), end)
            time.sleep(0.1)
        attempt = machine.root / "var/lib/sleight/jobs" / job / "attempt.json"
        keeper = json.loads(attempt.read_text())["keeper"]["pid"]
        machine.inside("apt-get", "install", "-y", "--no-install-recommends", machine.put(second))
        self.assertEqual(machine.inside("dpkg-query", "-W", "-f", "${Version}", "sleight"), version + "+2")
        done = status()["scans_done"]
        machine.stop_daemon()
        machine.start_daemon()
        now = status()
        self.assertEqual((now["state"], now["starts"]), ("running", 1))
        self.assertGreaterEqual(now["scans_done"], done)
        self.assertEqual(json.loads(attempt.read_text())["keeper"]["pid"], keeper)
        self.assertEqual(json.loads(machine.as_user("bob", "sleight", "list", "--json"))["jobs"], [])
        machine.as_user("ada", "sleight", "cancel", job)
        while status()["state"] != "cancelled":
            self.assertLess(time.monotonic(), end + 120)
            time.sleep(0.1)
        machine.as_user("ada", "sleight", "fetch", job, "-o", "long.h5")
        machine.as_user("ada", "sleight", "archive", "verify", "long.h5")
        machine.stop_daemon()

        machine.inside("apt-get", "purge", "-y", "sleight")
        self.assertFalse((machine.root / "usr/bin/sleight").exists())
        self.assertTrue(attempt.exists())


if __name__ == "__main__":
    harness.main()
