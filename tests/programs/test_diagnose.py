"""Goal: `sleight diagnose` tells chains that have mixed from chains that have not, and says why.
Method: real archives of the 2D ball, some mixed, some not, and some that were tampered with."""

import json

import h5py
import harness
import numpy
from harness import ProgramTest, sleight

# A wide target and long scans: the draws are all but independent.
EASY = """
[world]
name = "ball_2d"
[constraint]
sigma_diameters = 3
[sampler]
method = "metropolis_hastings"
iterations_per_scan = 50
[stop]
scans = 4000
"""

# A narrow target and few scans: each chain is still on its own way to it.
HARD = """
[world]
name = "ball_2d"
[constraint]
sigma_diameters = 0.02
[sampler]
method = "metropolis_hastings"
[stop]
scans = 60
"""

TEMPERED = """
[world]
name = "ball_2d"
[constraint]
sigma_diameters = 0.5
[sampler]
method = "parallel_tempering"
chains = 2
iterations_per_scan = 10
round_scans = 400
[stop]
rounds = 3
"""


# After annealing and a burn-in by parallel tempering: 20 scans, and 60 + 120 + 240.
BURNT_IN = """
[world]
name = "ball_2d"
[constraint]
sigma_diameters = 0.5
[sampler]
method = "{method}"
chains = 2
iterations_per_scan = 40
round_scans = 60
burn_in_rounds = 3
anneal_scans = 20
{keys}
[stop]
scans = {scans}
"""
BURN_IN = 20 + 60 * 7


def burnt_in(method, draws, keys=""):
    return BURNT_IN.format(method=method, keys=keys, scans=BURN_IN + draws)


class DiagnoseTest(ProgramTest):
    def archived(self, request, name="a.h5"):
        self.path("r.toml").write_text(request)
        self.direct(self.path("r.toml"), self.path(name))
        return self.path(name)

    def diagnosed(self, archive, code):
        """The report for people and the JSON, which must agree."""
        people = sleight("diagnose", archive)
        self.assertEqual(people.returncode, code, people.stdout + people.stderr)
        machine = sleight("diagnose", archive, "--json")
        self.assertEqual(machine.returncode, code, machine.stderr)
        found = json.loads(machine.stdout)
        self.assertEqual(found["mixed"], code == 0)
        self.assertEqual(found["mixed"], found["reasons"] == [])
        heading = "Not enough:" if "weights" in found else "Not mixed:"
        self.assertEqual(heading in people.stdout, code == 7)
        return people.stdout, found


class Plain(DiagnoseTest):
    def test_mixed_chains_are_0(self):
        text, found = self.diagnosed(self.archived(EASY), 0)
        self.assertIn("Judged are scans 2,000 to 3,999 of each chain: the second half.", text)
        self.assertEqual(found["judged"], {"what": "second_half", "first_scan": 2000,
                                           "scans": 2000, "states": 2000})
        self.assertEqual([entry["name"] for entry in found["scalars"][:2]],
                         ["lp", "log_constraint"])
        for entry in found["scalars"] + found["variables"][0]["listed"]:
            self.assertLessEqual(entry["r_hat"], 1.01, entry)
            self.assertGreaterEqual(min(entry["ess_bulk"], entry["ess_tail"]), 400, entry)
            self.assertIn(entry["name"], text)
        # Four starts, and 50 proposals in each later scan.
        self.assertEqual(found["simulations"], 4 * (1 + 50 * 3999))
        self.assertEqual(found["proposal_kinds"][0]["proposed"], 4 * 50 * 2000)
        self.assertLessEqual(found["independent_solutions"], 4)

    def test_one_chain_that_left_for_elsewhere_is_7(self):
        # The checker must be able to fail: a mixed archive with one chain moved aside.
        archive = self.archived(EASY)
        with h5py.File(archive, "r+") as file:
            normals = file["posterior/normal_rad"]
            normals[2, :, 3] = normals[2, :, 3] + 0.2
        text, found = self.diagnosed(archive, 7)
        self.assertRegex(found["reasons"][0], r"^normal_rad\[3\]: R-hat is 1\.\d+, above 1\.01")
        self.assertEqual(len(found["reasons"]), 1)
        self.assertIn(found["reasons"][0], text)

    def test_chains_under_way_are_7_with_reasons(self):
        text, found = self.diagnosed(self.archived(HARD), 7)
        self.assertRegex(text, r"lp: .*R-hat is \d+\.\d+, above 1\.01")
        self.assertRegex(text, r"lp: the bulk effective sample size is \d+, below 400")
        self.assertRegex(text, r"each chain has too few judged scans: 30;")
        self.assertGreater(found["variables"][0]["failing"], 0)

    def test_one_scan_is_too_few(self):
        text, found = self.diagnosed(self.archived(HARD.replace("scans = 60", "scans = 1")), 7)
        self.assertEqual(found["reasons"],
                         ["each chain has too few judged scans to judge by: 1, and it takes 6"])
        self.assertNotIn("nan", text)
        self.assertEqual(found["scalars"][0]["r_hat"], None)

    def test_no_archived_state_is_too_few(self):
        text, found = self.diagnosed(self.archived(HARD + "[output]\nthin = 100\n"), 7)
        self.assertIn("each chain has too few archived states (see thin) in the judged scans to "
                      "judge by: 0, and it takes 6", found["reasons"])
        self.assertEqual(found["variables"][0]["listed"][0]["mean"], None)
        self.assertRegex(text, r"normal_rad\[0\] +- +- +- +- +- +-\n")

    def test_one_chain_is_compared_with_itself(self):
        request = EASY.replace("[sampler]", "[sampler]\nchains = 1")
        _, found = self.diagnosed(self.archived(request), 0)
        self.assertIn("R-hat compares its two halves", found["notes"][0])

    def test_states_without_probability(self):
        archive = self.archived(EASY)
        with h5py.File(archive, "r+") as file:
            for name in ["log_constraint", "lp"]:
                file["sample_stats"][name][1, 2000:2003] = -float("inf")
        _, found = self.diagnosed(archive, 7)
        self.assertEqual(len(found["reasons"]), 1)
        self.assertIn("log_constraint: 3 of 8000 draws are -inf", found["reasons"][0])
        self.assertEqual(found["scalars"][1]["minus_infinite"], 3)
        self.assertLessEqual(found["scalars"][1]["r_hat"], 1.01)


class Tempered(DiagnoseTest):
    def test_the_longest_round_is_judged_and_ladders_are_shown(self):
        text, found = self.diagnosed(self.archived(TEMPERED), 0)
        self.assertEqual(found["judged"]["first_scan"], 1200)
        self.assertEqual(found["judged"]["scans"], 1600)
        self.assertIn("Ladders in round 3 of 3", text)
        for ladder in found["tempering"]["ladders"]:
            self.assertGreater(ladder["round_trips"], 10)
            betas = ladder["inverse_temperature"]
            self.assertEqual((betas[0], betas[-1]), (0, 1))
            self.assertEqual(betas, sorted(betas))
            self.assertEqual(len(ladder["swap_acceptance"]), len(betas) - 1)

    def test_no_round_trip_is_7(self):
        archive = self.archived(TEMPERED)
        with h5py.File(archive, "r+") as file:
            file["tempering/round_trips"][:, 2] = 0
        _, found = self.diagnosed(archive, 7)
        self.assertEqual(found["reasons"],
                         ["2 of 2 ladders made no round trip in the judged round"])

    def test_info_says_how_rare_it_is(self):
        archive = self.archived(TEMPERED)
        info = self.info(archive)["tempering"]
        self.assertEqual(info["log_p_satisfied"]["round"], 3)
        text = self.succeed(sleight("archive", "info", archive)).stdout
        self.assertRegex(text, r"by chance    one throw in [\d.,]+ \([\d.,]+ to [\d.,]+\)\n")
        self.assertRegex(text, r"log Z        -\d+\.\d+ \+- \d+\.\d+ \(2 ladders, ")
        self.assertEqual(info["ladders_without_round_trip"], 0)
        self.assertNotIn("round trip", text)
        self.assertTrue(info["known"])
        # One ladder's states are on their way yet.
        with h5py.File(archive, "r+") as file:
            file["tempering/round_trips"][1, 2] = 0
        info = self.info(archive)["tempering"]
        self.assertEqual(info["ladders_without_round_trip"], 1)
        self.assertFalse(info["known"])
        self.assertIsNone(info["log10_throws"])
        self.assertIsNone(info["log_p_satisfied"]["error"])
        self.assertGreater(info["to_know"]["rounds"], 3)
        text = self.succeed(sleight("archive", "info", archive)).stdout
        self.assertNotIn("one throw in", text.split("The request")[0])
        self.assertIn("  by chance    unknown\n               1 of 2 ladders made no round trip in "
                      "round 3 of 3: each has to make 5\n", text)
        self.assertRegex(text, r"to know it: at least rounds = \d under \[stop\]")
        # Nothing satisfied in the last round, then never.
        with h5py.File(archive, "r+") as file:
            file["tempering/log_p_satisfied"][:, 2] = -float("inf")
        self.assertEqual(self.info(archive)["tempering"]["log_p_satisfied"]["round"], 2)
        self.assertIn("nothing satisfied in 2 of 2 ladders in round 3 of 3",
                      sleight("archive", "info", archive).stdout)
        with h5py.File(archive, "r+") as file:
            file["tempering/log_p_satisfied"][:] = -float("inf")
        self.assertIn("unknown: nothing satisfied in any round",
                      sleight("archive", "info", archive).stdout)
        self.assertEqual(self.info(archive)["tempering"]["log10_throws"], None)

    def test_annealing_comes_before_the_rounds(self):
        request = TEMPERED.replace("round_scans = 400", "round_scans = 400\nanneal_scans = 30")
        request = request.replace("iterations_per_scan = 10", "iterations_per_scan = 20")
        archive = self.archived(request)
        text, found = self.diagnosed(archive, 0)
        # Scans of the run that are no draws are not counted: the third round is the same draws.
        self.assertEqual(found["judged"]["first_scan"], 1200)
        self.assertEqual(found["judged"]["scans"], 1600)
        self.assertFalse(found["tempering"]["burn_in"])
        self.assertIn("Ladders in round 3 of 3\n", text)
        self.assertEqual(self.info(archive)["tempering"]["rounds"], 3)

    def test_annealed_plain_chains(self):
        request = EASY.replace("[sampler]", "[sampler]\nanneal_scans = 100")
        _, found = self.diagnosed(self.archived(request), 0)
        self.assertEqual(found["judged"]["first_scan"], 1950)
        self.assertEqual(found["judged"]["scans"], 1950)
        self.assertEqual(found["simulations"], 4 * (1 + 50 * 3999))


class BurntIn(DiagnoseTest):
    def test_all_draws_of_simulated_tempering_are_judged(self):
        archive = self.archived(burnt_in("simulated_tempering", 8000))
        text, found = self.diagnosed(archive, 0)
        with h5py.File(archive) as file:
            draws = file["sample_stats/lp"].shape[1]
            visits = file["tempering/walk_visits"][()]
            trips = file["tempering/walk_round_trips"][()]
            self.assertEqual(file["tempering/draw_scan"].shape, (2, draws))
        self.assertEqual(found["judged"], {"what": "all", "first_scan": 0, "scans": draws,
                                           "states": draws})
        self.assertIn("all after the burn-in", text)
        self.assertEqual([walk["round_trips"] for walk in found["walks"]], list(trips))
        self.assertRegex(text, r"Walks over temperatures\n.*round trips")
        self.assertRegex(text, r"Walk of chain 1 by inverse temperature")
        self.assertIn("Ladders in round 3 of 3 of the burn-in", text)
        for chain in range(2):
            walk = found["walks"][chain]
            betas = walk["inverse_temperature"]
            self.assertEqual((betas[0], betas[-1]), (0, 1))
            self.assertEqual(sum(walk["visits"]), 8000)
            self.assertEqual(walk["visits"], list(visits[chain][:len(betas)]))
            self.assertEqual(walk["acceptance"][-1], None)
        # That it can fail: no trips; trips of the burn-in alone are no reason.
        with h5py.File(archive, "r+") as file:
            file["tempering/round_trips"][:] = 0
            file["tempering/walk_round_trips"][1] = 0
        _, found = self.diagnosed(archive, 7)
        self.assertEqual(found["reasons"], ["1 of 2 chains made no round trip to the prior and "
                                            "back: chain 1 among them"])

    def test_all_draws_of_tempered_transitions_are_judged(self):
        archive = self.archived(burnt_in("tempered_transitions", 2000, "steps_per_level = 2"))
        text, found = self.diagnosed(archive, 0)
        self.assertEqual(found["judged"], {"what": "all", "first_scan": 0, "scans": 2000,
                                           "states": 2000})
        with h5py.File(archive) as file:
            acceptance = file["tempering/excursion_acceptance"][()]
            lineage = file["sample_stats/lineage"][()]
        shares = [chain["acceptance"] for chain in found["tempered_transitions"]]
        self.assertEqual(shares, list(acceptance))
        for chain in range(2):
            # Each that was accepted brought a lineage; the first scan's shows not.
            moves = (lineage[chain][1:] != lineage[chain][:-1]).sum()
            self.assertAlmostEqual(shares[chain], moves / 2000, delta=1.5 / 2000)
            self.assertGreater(shares[chain], 0.05)
        self.assertRegex(text, r"Tempered transitions\n +temperatures down +accepted\n")

    def test_weighted_draws_are_judged_by_their_effective_size(self):
        archive = self.archived(burnt_in("annealed_importance", 1200, "steps_per_level = 2"))
        text, found = self.diagnosed(archive, 0)
        with h5py.File(archive) as file:
            log_weight = file["tempering/log_weight"][()]
            size = file["tempering/ais_effective_size"][()]
            log_p = file["tempering/ais_log_p_satisfied"][()]
        self.assertEqual(found["scalars"], [])
        self.assertEqual(found["variables"], [])
        self.assertNotIn("R-hat", text)
        self.assertEqual(found["judged"]["what"], "weighted")
        weights = numpy.exp(log_weight)
        self.assertAlmostEqual(found["weights"]["effective_size"],
                               weights.sum() ** 2 / (weights ** 2).sum(), places=6)
        self.assertEqual([chain["effective_size"] for chain in found["weights"]["chains"]],
                         list(size))
        self.assertRegex(text, r"chain 1 +\d[\d,]* +\d+\.\d +\d+ +-\d\.\d+ \+- \d\.\d+ ")
        self.assertIn("The draws are worth enough.", text)
        # What `archive info` says of chance is by the weights, too.
        info = self.info(archive)["tempering"]
        self.assertEqual(info["from"], "weights")
        self.assertAlmostEqual(info["log_p_satisfied"]["value"], log_p.mean(), places=12)
        self.assertRegex(sleight("archive", "info", archive).stdout,
                         r"by chance +one throw in .*\n +log P -\d\.\d+ \+- \d\.\d+ \(2 chains, ")

    def test_too_few_weighted_draws_are_7(self):
        archive = self.archived(burnt_in("annealed_importance", 40))
        text, found = self.diagnosed(archive, 7)
        self.assertLess(found["weights"]["effective_size"], 100)
        self.assertRegex(found["reasons"][0], r"^the weighted draws of all chains are worth [\d.]+ "
                                              r"draws of equal weight, and it takes 100:")
        # One weight that outweighs all others.
        archive = self.archived(burnt_in("annealed_importance", 1200), "b.h5")
        self.diagnosed(archive, 0)
        with h5py.File(archive, "r+") as file:
            file["tempering/log_weight"][1, 3] = 1e4
        _, found = self.diagnosed(archive, 7)
        self.assertAlmostEqual(found["weights"]["effective_size"], 1)


class Damage(DiagnoseTest):
    def refused(self, archive, words):
        result = sleight("diagnose", archive)
        self.assertEqual(result.returncode, 6, result.stderr)
        self.assertEqual(result.stdout, "")
        self.assertIn(words, result.stderr)

    def test_no_archive_and_half_an_archive_are_6(self):
        self.path("t.h5").write_text("not an archive")
        self.refused(self.path("t.h5"), "t.h5")
        whole = self.archived(EASY)
        half = self.path("half.h5")
        half.write_bytes(whole.read_bytes()[:whole.stat().st_size // 2])
        self.refused(half, "half.h5")

    def test_ladders_that_cannot_be_are_6(self):
        archive = self.archived(TEMPERED)
        for table, value in [("first_scan", -1), ("first_scan", 1e300), ("scans", 0.5),
                             ("scans", 1e9), ("first_scan", -float("inf"))]:
            with h5py.File(archive, "r+") as file:
                before = file["tempering"][table][1, 1]
                file["tempering"][table][1, 1] = value
            self.refused(archive, "/tempering/" + table)
            with h5py.File(archive, "r+") as file:
                file["tempering"][table][1, 1] = before
        self.diagnosed(archive, 0)

    def test_tables_of_other_shapes_are_6(self):
        archive = self.archived(burnt_in("annealed_importance", 200))
        for table in ["log_weight", "ais_log_z", "ascent_inverse_temperature"]:
            with h5py.File(archive, "r+") as file:
                file["tempering"].move(table, "aside")
                file["tempering"].create_dataset(table, data=[[[1.0]]])
            self.refused(archive, table)
            with h5py.File(archive, "r+") as file:
                del file["tempering"][table]
                file["tempering"].move("aside", table)


if __name__ == "__main__":
    harness.main()
