"""Goal: runs work on a cluster's NFS, without flock, file locks and shared memory, on several nodes. If two
nodes start the same run, one writes, and the other reports which node writes. Killed runs resume to the
digest of a run on a local disk. Method: run real programs with a library that makes every disk act as NFS and
gives each node its name (other_node.cpp)."""

import pathlib
import signal
import time

import harness
from harness import ProgramTest, sleight


class NetworkDisk(ProgramTest):
    def on(self, node):
        """A node's environment."""
        library = pathlib.Path(harness.arguments.bin).parent / "tests/libsleight_other_node.so"
        self.assertTrue(library.exists(), library)
        return {"LD_PRELOAD": str(library), "SLEIGHT_TEST_HOST": node}

    def start(self, node, request, output):
        assignments = [f"{key}={value}" for key, value in self.on(node).items()]
        return harness.start(["env", *assignments, harness.program("sleight"), "direct", request, "-o",
                              output, "-q"])

    def await_archive(self, process, output):
        deadline = time.monotonic() + 60
        while not output.exists():
            self.assertIsNone(process.poll(), "it ended before its first checkpoint")
            self.assertLess(time.monotonic(), deadline)
            time.sleep(0.02)

    def names(self, output):
        return {path.name for path in pathlib.Path(f"{output}.run").iterdir()}

    def test_killed_and_gone_on_with(self):
        request = self.write_request(chains=2, scans=15000, iterations_per_scan=20, thin=50)
        self.direct(request, self.path("local.h5"))
        output = self.path("a.h5")
        process = self.start("one", request, output)
        store = pathlib.Path(f"{output}.run/store.sqlite")
        while not store.exists():
            self.assertIsNone(process.poll(), "it ended before it had a store")
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        self.direct(request, output, env=self.on("one"))
        self.assertEqual(self.digest(output), self.digest(self.path("local.h5")))
        names = self.names(output)
        self.assertTrue(any(name.startswith("lease.") for name in names), names)
        self.assertTrue(names.isdisjoint({"lock", "store.sqlite-shm"}), names)

    def test_of_two_nodes_one_writes(self):
        output = self.path("a.h5")
        request = self.write_request(chains=2, scans=200_000_000, iterations_per_scan=20, thin=50)
        process = self.start("one", request, output)
        self.await_archive(process, output)
        for node in ["one", "two"]:
            refused = sleight("direct", request, "-o", output, "-q", env=self.on(node))
            self.assertEqual(refused.returncode, 4, refused.stderr)
            self.assertIn(f"process ({process.pid}) on one, since 20", refused.stderr)
        refused = sleight("archive", "derive", f"{output}.run", "-o", self.path("b.h5"),
                          env=self.on("two"))
        self.assertEqual(refused.returncode, 4, refused.stderr)

        # A run that ends in order releases its lease: another node can resume or read it at once.
        process.send_signal(signal.SIGTERM)
        self.assertIn(process.wait(timeout=60), [0, 130])
        self.succeed(sleight("archive", "derive", f"{output}.run", "-o", self.path("b.h5"),
                             env=self.on("two")))
        self.assertEqual(self.digest(self.path("b.h5")), self.digest(output))
        before = self.info(output)["scans"]
        # The limit includes reading the stored results.
        self.direct(request, output, "--time-limit", "5s", env=self.on("two"))
        self.assertGreater(self.info(output)["scans"], before)


if __name__ == "__main__":
    harness.main()
