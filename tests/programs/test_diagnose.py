"""Goal: `sleight diagnose` distinguishes chains that have mixed from chains that haven't, and explains why.
Method: use real archives of the 2D ball: some mixed, some not, and some manipulated."""

import json

import h5py
import harness
import numpy
from harness import ProgramTest, sleight

# A wide target and long scans: the draws are almost independent.
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
        heading = "too small:\n" if "weights" in found else "Not mixed:"
        self.assertEqual(heading in people.stdout, code == 7)
        return found


class Plain(DiagnoseTest):
    def test_mixed_chains_are_0(self):
        found = self.diagnosed(self.archived(EASY), 0)
        self.assertEqual(found["judged"], {"what": "second_half", "first_scan": 2000,
                                           "scans": 2000, "states": 2000})
        self.assertEqual([entry["name"] for entry in found["scalars"][:2]],
                         ["lp", "log_constraint"])
        for entry in found["scalars"] + found["variables"][0]["listed"]:
            self.assertLessEqual(entry["r_hat"], 1.01, entry)
            self.assertGreaterEqual(min(entry["ess_bulk"], entry["ess_tail"]), 400, entry)
        # Four starts, and 50 proposals in each later scan.
        self.assertEqual(found["simulations"], 4 * (1 + 50 * 3999))
        self.assertEqual(found["proposal_kinds"][0]["proposed"], 4 * 50 * 2000)
        self.assertLessEqual(found["independent_solutions"], 4)

    def test_one_chain_that_left_for_elsewhere_is_7(self):
        # The checker can fail: use a mixed archive with one chain shifted.
        archive = self.archived(EASY)
        with h5py.File(archive, "r+") as file:
            normals = file["posterior/normal_rad"]
            normals[2, :, 3] = normals[2, :, 3] + 0.2
        found = self.diagnosed(archive, 7)
        self.assertEqual([reason.split(":")[0] for reason in found["reasons"]], ["normal_rad[3]"])


class Tempered(DiagnoseTest):
    def test_the_longest_round_is_judged_and_ladders_are_shown(self):
        found = self.diagnosed(self.archived(TEMPERED), 0)
        self.assertEqual(found["judged"]["first_scan"], 1200)
        self.assertEqual(found["judged"]["scans"], 1600)
        for ladder in found["tempering"]["ladders"]:
            self.assertGreater(ladder["round_trips"], 10)
            betas = ladder["inverse_temperature"]
            self.assertEqual((betas[0], betas[-1]), (0, 1))
            self.assertEqual(betas, sorted(betas))
            self.assertEqual(len(ladder["swap_acceptance"]), len(betas) - 1)


class BurntIn(DiagnoseTest):
    def test_all_draws_of_simulated_tempering_are_judged(self):
        archive = self.archived(burnt_in("simulated_tempering", 8000))
        found = self.diagnosed(archive, 0)
        with h5py.File(archive) as file:
            draws = file["sample_stats/lp"].shape[1]
            visits = file["tempering/walk_visits"][()]
            trips = file["tempering/walk_round_trips"][()]
            self.assertEqual(file["tempering/draw_scan"].shape, (2, draws))
        self.assertEqual(found["judged"], {"what": "all", "first_scan": 0, "scans": draws,
                                           "states": draws})
        self.assertEqual([walk["round_trips"] for walk in found["walks"]], list(trips))
        for chain in range(2):
            walk = found["walks"][chain]
            betas = walk["inverse_temperature"]
            self.assertEqual((betas[0], betas[-1]), (0, 1))
            self.assertEqual(sum(walk["visits"]), 8000)
            self.assertEqual(walk["visits"], list(visits[chain][:len(betas)]))
            self.assertEqual(walk["acceptance"][-1], None)
        # The check can fail: without round trips. Those of the burn-in don't count.
        with h5py.File(archive, "r+") as file:
            file["tempering/round_trips"][:] = 0
            file["tempering/walk_round_trips"][1] = 0
        found = self.diagnosed(archive, 7)
        self.assertEqual(len(found["reasons"]), 1)
        self.assertRegex(found["reasons"][0], r"^1 of 2 chains .*round trip.*\bchain 1\b")

    def test_all_draws_of_tempered_transitions_are_judged(self):
        archive = self.archived(burnt_in("tempered_transitions", 2000, "steps_per_level = 2"))
        found = self.diagnosed(archive, 0)
        self.assertEqual(found["judged"], {"what": "all", "first_scan": 0, "scans": 2000,
                                           "states": 2000})
        with h5py.File(archive) as file:
            acceptance = file["tempering/excursion_acceptance"][()]
            lineage = file["sample_stats/lineage"][()]
        shares = [chain["acceptance"] for chain in found["tempered_transitions"]]
        self.assertEqual(shares, list(acceptance))
        for chain in range(2):
            # Each accepted excursion began a lineage; that of the first scan isn't visible.
            moves = (lineage[chain][1:] != lineage[chain][:-1]).sum()
            self.assertAlmostEqual(shares[chain], moves / 2000, delta=1.5 / 2000)
            self.assertGreater(shares[chain], 0.05)

    def test_weighted_draws_are_judged_by_their_effective_size(self):
        archive = self.archived(burnt_in("annealed_importance", 1200, "steps_per_level = 2"))
        found = self.diagnosed(archive, 0)
        with h5py.File(archive) as file:
            log_weight = file["tempering/log_weight"][()]
            size = file["tempering/ais_effective_size"][()]
            log_p = file["tempering/ais_log_p_satisfied"][()]
        self.assertEqual(found["scalars"], [])
        self.assertEqual(found["variables"], [])
        self.assertEqual(found["judged"]["what"], "weighted")
        weights = numpy.exp(log_weight)
        self.assertAlmostEqual(found["weights"]["effective_size"],
                               weights.sum() ** 2 / (weights ** 2).sum(), places=6)
        self.assertEqual([chain["effective_size"] for chain in found["weights"]["chains"]],
                         list(size))
        # `archive info` also computes log P(satisfied) from the weights.
        info = self.info(archive)["tempering"]
        self.assertEqual(info["from"], "weights")
        self.assertAlmostEqual(info["log_p_satisfied"]["value"], log_p.mean(), places=12)

    def test_too_few_weighted_draws_are_7(self):
        archive = self.archived(burnt_in("annealed_importance", 40))
        found = self.diagnosed(archive, 7)
        self.assertLess(found["weights"]["effective_size"], 100)
        self.assertRegex(found["reasons"][0], r"\bweighted draws .*effective size \D*[\d.]+\D+\b100\b")
        # One weight that outweighs all others.
        archive = self.archived(burnt_in("annealed_importance", 1200), "b.h5")
        self.diagnosed(archive, 0)
        with h5py.File(archive, "r+") as file:
            file["tempering/log_weight"][1, 3] = 1e4
        found = self.diagnosed(archive, 7)
        self.assertAlmostEqual(found["weights"]["effective_size"], 1)


class Damage(DiagnoseTest):
    def refused(self, archive, words):
        result = sleight("diagnose", archive)
        self.assertEqual(result.returncode, 6, result.stderr)
        self.assertEqual(result.stdout, "")
        self.assertIn(words, result.stderr)

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
