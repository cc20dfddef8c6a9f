"""Goal: a run ends soon after the request, reports correctly how it ended, leaves results, and refuses before
computing what it couldn't write. Method: real runs with slow scans, many chains and unusable outputs."""

import json
import os
import pathlib
import re
import signal
import subprocess
import time

import harness
from harness import ProgramTest, sleight


class Stopping(ProgramTest):
    def limited(self, request, limit, *args):
        result = self.succeed(sleight("direct", request, "-o", self.path("a.h5"), "--time-limit",
                                      limit, "--json", *args))
        return json.loads(result.stdout)

    def test_slow_scans_do_not_delay_a_time_limit(self):
        # A scan of 1,000,000 proposals takes a third of a second or more. Scan 0 takes no time, and must not
        # lead to units of hundreds of scans.
        request = self.write_request(scans=1000000, iterations_per_scan=1000000)
        summary = self.limited(request, "1s")
        self.assertEqual(summary["end"], "time_limit")
        self.assertLess(summary["session_scans"], 200)

    def test_one_signal_is_enough(self):
        # A search first throws a die this fast a hundred times, in one piece that takes minutes.
        request = self.path("fast.toml")
        request.write_text('[world]\nname = "dice"\n[[world.die]]\nvelocity_x_mps = 99\n'
                           'spin_x_sd_radps = 900\n[[constraint.face]]\nup = 6\n')
        output = self.path("fast.h5")
        process = subprocess.Popen([harness.program("sleight"), "direct", request, "-o", output,
                                    "-q"])
        # The run is in that piece once it has computed for a second.
        end = time.monotonic() + 60
        ticks = os.sysconf("SC_CLK_TCK")
        times = pathlib.Path(f"/proc/{process.pid}/stat")
        while int(times.read_text().rsplit(")", 1)[1].split()[11]) < ticks:
            self.assertLess(time.monotonic(), end)
            time.sleep(0.05)
        process.terminate()
        self.assertEqual(process.wait(timeout=60), 130)
        self.limited(request, "1s")

    def test_many_chains_have_something_to_show(self):
        # Slow machines and sanitizers get more time. A run that took one chain after another would not reach
        # all of them in that time either.
        request = self.write_request(scans=1000000000, chains=3000)
        for limit in ["2s", "18s", "54s"]:
            summary = self.limited(request, limit, "--fresh")
            if summary["scans"] > 10:
                break
        self.assertGreater(summary["scans"], 10)

    def test_chains_stay_near_one_another(self):
        request = self.write_request(scans=1000000000, chains=16, iterations_per_scan=100)
        summary = self.limited(request, "2s", "--threads", "3")
        self.assertLess(summary["session_scans"], 3 * 16 * summary["scans"])


class WhileItWrites(ProgramTest):
    def ended_by_signal(self, process):
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, errors)

    def test_it_says_how_far_it_is_and_stops(self):
        # An archive of this many scans takes seconds.
        output = self.path("a.h5")
        request = self.write_request(chains=1, scans=400000)
        direct = [harness.program("sleight"), "direct", request, "-o", output]
        process = harness.start(direct)
        log = self.path("a.h5.run/events.log")
        counted = re.compile(r"[0-9,]+ of 400,000 draws \([0-9]+%\)")
        while not (log.exists() and counted.search(log.read_text())):
            self.assertIsNone(process.poll(), "it has ended, and nothing was counted")
            time.sleep(0.02)
        self.ended_by_signal(process)
        self.assertEqual([p.name for p in self.folder.iterdir() if ".tmp." in p.name], [])

        # The computed results are there: an archive of fewer scans is written at once.
        few = self.succeed(sleight("direct", self.write_request("few.toml", chains=1, scans=1000),
                                   "-o", output, "--json"))
        summary = json.loads(few.stdout)
        self.assertEqual((summary["end"], summary["session_scans"]), ("finished", 0))

        # Once more, with an archive that stays. Derive one by hand too.
        before = output.read_bytes()
        other = self.path("other.h5")
        for command, place in [(direct, output),
                               ([harness.program("sleight"), "archive", "derive",
                                 self.path("a.h5.run"), "-o", other], other)]:
            process = harness.start(command)
            while not any(p.name.startswith(place.name + ".tmp.") for p in self.folder.iterdir()):
                self.assertIsNone(process.poll(), "it has ended")
                time.sleep(0.02)
            self.ended_by_signal(process)
        self.assertEqual(output.read_bytes(), before)
        self.assertFalse(other.exists())


class UnusableOutputs(ProgramTest):
    def refused(self, output, code):
        request = self.write_request(scans=1000000000)
        result = sleight("direct", request, "-o", output, "-q")
        self.assertEqual(result.returncode, code, (output, result.stderr))

    def test_they_are_refused_before_the_run(self):
        self.refused("", 2)
        self.refused(self.folder, 2)
        self.refused(f"{self.folder}/", 2)
        self.refused(self.path("x" * 250 + ".h5"), 5)
        self.refused(self.path("no/such/folder.h5"), 5)
        self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["request.toml"])

    def test_an_output_inside_another_run(self):
        self.direct(self.write_request(), self.path("v.h5"))
        self.refused(self.path("v.h5.run/store.sqlite-wal"), 4)
        self.refused(self.path("v.h5.run/in.h5"), 4)

    def test_a_lock_that_points_elsewhere_is_not_followed(self):
        victim = self.path("victim")
        victim.write_text("kept")
        folder = self.path("a.h5.run")
        folder.mkdir()
        os.symlink(victim, folder / "lock")
        self.assertEqual(sleight("direct", self.write_request(), "-o", self.path("a.h5"),
                                 "-q").returncode, 5)
        self.assertEqual(victim.read_text(), "kept")


class Batch(ProgramTest):
    def test_a_missing_request_is_code_5(self):
        result = harness.run(harness.batch(3, self.path("none.toml"), self.path("a.h5"),
                                           folder=self.folder))
        self.assertEqual(result.returncode, 5, result.stderr)
        self.assertIn("none.toml", result.stderr)

    def test_a_bad_request_is_code_3_and_said_once(self):
        request = self.path("bad.toml")
        request.write_text('[world]\nname = "ball_2d"\nrestitution = 2\n[stop]\nscans = 10\n')
        result = harness.run(harness.batch(3, request, self.path("a.h5"), folder=self.folder))
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertEqual(result.stderr.count("bad.toml:3:"), 1, result.stderr)

    def test_a_refused_output_is_code_4(self):
        self.direct(self.write_request(), self.path("a.h5"))
        other = self.write_request("other.toml", seed=2)
        result = harness.run(harness.batch(2, other, self.path("a.h5"), folder=self.folder))
        self.assertEqual(result.returncode, 4, result.stderr)


class LostStreams(ProgramTest):
    def test_exit_codes_survive_a_lost_stderr(self):
        bad = self.path("bad.toml")
        bad.write_text('[world]\nname = "ball_2d"\nrestitution = 2\n[stop]\nscans = 10\n')
        good = self.write_request()
        with open("/dev/full", "w") as full:
            for command, code in [(["direct", bad, "-o", self.path("a.h5")], 3),
                                  (["archive", "info", self.path("none.h5")], 5),
                                  (["direct", good, "-o", self.path("b.h5")], 5),
                                  (["check", good], 5)]:
                process = subprocess.run([harness.program("sleight"), *command], stdout=full,
                                         stderr=full, env=harness.environment(), timeout=60)
                self.assertEqual(process.returncode, code, command)


if __name__ == "__main__":
    harness.main()
