"""Goal: the odds of a word that was searched for are told, the same by any number of threads. Method: a request for
odds and solutions, by one thread and by two; the archive and what `sleight archive info` says of it."""

import re

import h5py
import harness
from harness import ProgramTest, sleight

ODDS = """
[world]
name = "spelling"
word = "I"
font = "5 rows"
[stop]
odds = 0.8
found = 2
"""


class SearchOdds(ProgramTest):
    def test_islands_tell_them(self):
        request = self.path("odds.toml")
        request.write_text(ODDS)
        output = self.path("odds.h5")
        self.direct(request, output, "-j", "1")
        self.direct(request, self.path("two.h5"), "-j", "2")
        self.assertEqual(self.digest(self.path("two.h5")), self.digest(output))
        with h5py.File(output) as archive:
            first = archive["tempering/odds_from_island"][:]
            self.assertTrue((first > 0).all())
        info = sleight("archive", "info", output)
        self.assertIn("by chance", info.stdout)
        self.assertEqual(self.info(output)["tempering"]["from"], "islands")
        # Every draw after the burn-in has proposals.
        accepted = re.search(r"accepted +([\d.]+)% of proposals", info.stdout)
        self.assertLessEqual(float(accepted[1]), 100)


if __name__ == "__main__":
    harness.main()
