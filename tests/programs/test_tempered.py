"""Goal: properties of plain chains hold for every method: an archive is a function of only request, seed and
version, and killed or stopped runs resume to the same bits. Method: run each method's request in other ways
and compare archives byte for byte. Compare draws with the archive's own statistics."""

import random
import subprocess
import time

import h5py
import numpy

import harness
from harness import ProgramTest

METHODS = {
    "parallel_tempering": "",
    "simulated_tempering": "burn_in_rounds = 3",
    "tempered_transitions": "burn_in_rounds = 3\nsteps_per_level = 3",
    "annealed_importance": "burn_in_rounds = 3\nlanes = 3\nsteps_per_level = 2",
}
# Three rounds of burn-in, and the annealing before them.
BURN_IN = 40 * 7 + 25


class Tempered(ProgramTest):
    def request(self, method, scans, name="request.toml", iterations=4, extra=""):
        path = self.path(name)
        path.write_text(f"""
[world]
name = "ball_2d"
[sampler]
method = "{method}"
chains = 2
seed = 5
iterations_per_scan = {iterations}
round_scans = 40
anneal_scans = 25
{METHODS[method]}
{extra}
[stop]
scans = {scans}
[output]
thin = 3
""")
        return path

    def asked_scans(self, archive):
        """The scans of the request that reproduces an archive."""
        text = self.info(archive)["request"]
        return int(text.split("[stop]\nscans = ")[1].split("\n")[0])

    def test_threads_ranks_and_processors(self):
        for method in METHODS:
            with self.subTest(method):
                request = self.request(method, 700)
                one = self.path("one.h5")
                self.direct(request, one, "--threads", "1", "--fresh")
                self.succeed(harness.sleight("archive", "verify", one))
                others = {}
                self.direct(request, self.path("threads.h5"), "--threads", "5", "--fresh")
                others["threads"] = self.path("threads.h5")
                ranks = self.path("ranks.h5")
                self.succeed(harness.run(harness.batch(3, request, ranks, "-q", "--fresh",
                                                       folder=self.folder)))
                others["ranks"] = ranks
                self.direct(request, self.path("plain.h5"), "--fresh",
                            env={"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA"})
                others["processor"] = self.path("plain.h5")
                for way, output in others.items():
                    self.assertEqual(output.read_bytes(), one.read_bytes(), way)

    def test_killed_runs_go_on(self):
        generator = random.Random(harness.arguments.seed)
        print(f"seed {harness.arguments.seed}")
        for method in METHODS:
            with self.subTest(method):
                request = self.request(method, 1200, iterations=20)
                whole = self.path("whole.h5")
                begin = time.monotonic()
                self.direct(request, whole, "--fresh")
                took = time.monotonic() - begin
                output = self.path(f"{method}.h5")
                kills = 0
                for _ in range(4):
                    process = harness.start([harness.program("sleight"), "direct", request, "-o",
                                             output, "-q"])
                    try:
                        process.communicate(timeout=0.02 + generator.random() * took / 2)
                        self.assertEqual(process.returncode, 0)
                    except subprocess.TimeoutExpired:
                        harness.kill_group(process)
                        kills += 1
                self.direct(request, output)
                self.assertGreater(kills, 0)
                self.assertEqual(output.read_bytes(), whole.read_bytes())

    def test_a_time_limited_run_is_the_run_asked_for_as_many_scans(self):
        for method in METHODS:
            with self.subTest(method):
                cut = self.path(f"{method}.h5")
                self.direct(self.request(method, 100000000), cut, "--time-limit", "2s")
                scans = self.asked_scans(cut)
                self.assertGreater(scans, BURN_IN)
                self.assertLess(scans, 100000000)
                whole = self.path("whole.h5")
                self.direct(self.request(method, scans, "whole.toml"), whole, "--fresh")
                self.assertEqual(cut.read_bytes(), whole.read_bytes())

    def test_solo_steps(self):
        # Results of balls alone are held between iterations. Which process computes them, and whether they are computed
        # again, changes nothing.
        request = self.path("solo.toml")
        request.write_text("""
[world]
name = "spelling"
word = "HI"
[constraint]
log_lambda = 6
[sampler]
method = "parallel_tempering"
chains = 2
round_scans = 20
change_all = 0
change_vertices = 0.04
change_ball = 0.1
disable_balls = 0.03
enable_balls = 0.03
aim_ball = 0.4
scatter_ball = 0.4
solo_steps = 8
[stop]
rounds = 3
""")
        one = self.path("one.h5")
        self.direct(request, one, "--threads", "1")
        self.succeed(harness.sleight("archive", "verify", one))
        others = {}
        for threads in ["2", "5"]:
            others[threads] = self.path(f"threads{threads}.h5")
            self.direct(request, others[threads], "--threads", threads)
        others["ranks"] = self.path("ranks.h5")
        self.succeed(harness.run(harness.batch(3, request, others["ranks"], "-q",
                                               folder=self.folder)))
        others["sessions"] = self.path("sessions.h5")
        scans = 20 * 7  # of three rounds
        limit_s = 0.3
        for sessions in range(1, 40):
            self.direct(request, others["sessions"], "--time-limit", f"{limit_s:.2f}s")
            limit_s *= 1.1  # so that a slow machine gets on, too
            if others["sessions"].exists() and self.info(others["sessions"])["scans"] == scans:
                break
        self.assertGreater(sessions, 1)
        for way, output in others.items():
            self.assertEqual(output.read_bytes(), one.read_bytes(), way)

    def test_the_first_ladder_is_as_asked(self):
        # Later rounds have learnt their levels.
        for power, even in [("", False), ("ladder_power = 1", True)]:
            request = self.request("parallel_tempering", 40 * 3 + 25, name="ladder.toml",
                                   extra=f"replicas = 5\n{power}")
            archive = self.path("ladder.h5")
            self.direct(request, archive, "--fresh")
            with h5py.File(archive) as file:
                first = file["tempering/inverse_temperature"][0, 0].tolist()
            asked = [i / 4 if even else (i / 4) ** 6 for i in range(5)]
            self.assertEqual(first, asked)

    def test_the_index_process_is_the_ladders(self):
        # Levels of replicas match the temperatures of their last states, change by at most one, and contain
        # the counted round trips.
        archive = self.path("index.h5")
        self.direct(self.request("parallel_tempering", 40 * 15 + 25), archive, "--fresh")
        with h5py.File(archive) as file:
            tempering = {name: data[()] for name, data in file["tempering"].items()}
            replicas = {name: data[()] for name, data in file["replicas"].items()}
        trips_seen = 0
        for chain in range(2):
            scans = tempering["index_scan"][chain]
            levels = tempering["index_level"][chain]
            self.assertEqual(scans.tolist(), list(range(25, 40 * 15 + 25)))
            begins = [int(begin) for begin in tempering["first_scan"][chain]]
            ends = [*begins[1:], 40 * 15 + 25]
            way = [None] * levels.shape[1]
            for number, (begin, end) in enumerate(zip(begins, ends)):
                count = int(tempering["levels"][chain, number])
                rows = levels[begin - 25:end - 25]
                trips = 0
                for row in rows:
                    held = row[~numpy.isnan(row)]
                    self.assertEqual(sorted(held.tolist()), list(range(count)))
                    for replica, level in enumerate(row):
                        if level == 0:
                            trips += way[replica] == "down"
                            way[replica] = "up"
                        elif level == count - 1 and way[replica] == "up":
                            way[replica] = "down"
                steps = numpy.abs(numpy.diff(rows, axis=0))
                self.assertLessEqual(numpy.nanmax(steps), 1)
                self.assertEqual(trips, tempering["round_trips"][chain, number])
                trips_seen += trips
            for replica, scan in enumerate(replicas["scan"][chain]):
                level = levels[int(scan) - 25, replica] if scan >= 25 else numpy.nan
                if numpy.isnan(level):
                    continue
                number = max(i for i, begin in enumerate(begins) if begin <= scan)
                self.assertEqual(tempering["inverse_temperature"][chain, number, int(level)],
                                 replicas["inverse_temperature"][chain, replica])
        self.assertGreater(trips_seen, 5)


if __name__ == "__main__":
    harness.main()
