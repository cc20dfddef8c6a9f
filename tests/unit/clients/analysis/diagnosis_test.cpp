// Goal: the diagnosis judges the right draws of the right scalars, and reports every reason why
// chains have not mixed. If a hostile archive has invalid ladders, the error names their table.
// Method: diagnose fake in-memory runs of plain chains and of ladders. Use a judge that records its
// input and complains about selected scalars.
#include "clients/analysis/diagnosis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "clients/analysis/diagnosis_report.h"
#include "common/archive/digest/digest.h"
#include "common/archive/format.h"
#include "common/json/value.h"
#include "tests/archive/memory_archive.h"
#include "tests/support/facts.h"
#include "tests/support/numbers.h"
#include "tests/support/refusals.h"
#include "tests/unit/common/archive/fake_world.h"

namespace sleight::analysis::diagnosis_test {

using archive::MemoryArchive;
using archive::testing::FakeReader;
using archive::testing::FakeRun;
using archive::testing::FakeRunOptions;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::uint32_t k_chains = 3;

/// A fake tempered run. The caller gives the first scan of each round.
class TemperedRun final : public archive::RunView {
 public:
  TemperedRun(const FakeRunOptions& options, std::vector<double> first_scans)
      : run_(options), scans_(options.scans), first_scans_(std::move(first_scans)) {}
  std::uint32_t chains() const override { return run_.chains(); }
  std::uint64_t draws() const override { return run_.draws(); }
  void for_each_draw(
      base::ChainId chain,
      const std::function<void(base::ScanIndex, const plan::ScanRecord&)>& visit) const override {
    run_.for_each_draw(chain, visit);
  }
  plan::Report report() const override {
    const std::size_t rounds = first_scans_.size();
    plan::Report report;
    const auto table = [&](const char* name, const auto& value) {
      plan::Table made{.name = name,
                       .meaning = "m",
                       .dims = {{"chain", k_chains}, {"round", rounds}},
                       .values = {}};
      for (std::size_t c = 0; c < k_chains; ++c) {
        for (std::size_t r = 0; r < rounds; ++r)
          made.values.push_back(value(c, r));
      }
      report.tables.push_back(std::move(made));
    };
    table("first_scan", [&](std::size_t, std::size_t r) { return first_scans_[r]; });
    table("scans", [&](std::size_t, std::size_t r) {
      const auto end = static_cast<double>(scans_);
      return (r + 1 < rounds ? first_scans_[r + 1] : end) - first_scans_[r];
    });
    table("levels", [](std::size_t, std::size_t) { return 2.0; });
    table("round_trips", [](std::size_t c, std::size_t) { return c == 1 ? 0.0 : 5.0; });
    return report;
  }

 private:
  FakeRun run_;
  std::uint64_t scans_;
  std::vector<double> first_scans_;
};

struct Shown {
  std::size_t chains = 0;
  std::size_t draws = 0;
  double first = 0;
};

class DiagnosisTest : public ::testing::Test {
 protected:
  static FakeRunOptions options(std::uint64_t scans) {
    return {.chains = k_chains, .scans = scans, .thin = 10};
  }
  void archive_plain(const FakeRunOptions& options) {
    archive_ = MemoryArchive();
    archive::write_digested(archive_, archive::testing::filler(options));
  }
  void archive_tempered(const FakeRunOptions& options, std::vector<double> first_scans) {
    archive_ = MemoryArchive();
    archive::write_digested(archive_, [&](archive::Sink& sink) {
      archive::write_archive(TemperedRun(options, std::move(first_scans)), FakeReader(),
                             archive::testing::options_for(options), sink);
    });
  }
  std::vector<double>& values(std::string_view group, std::string_view name) {
    return std::get<std::vector<double>>(archive_.values(group, name));
  }
  Diagnosis diagnose() {
    shown_.clear();
    return diagnosis_of(archive_, rules_);
  }

  MemoryArchive archive_;
  std::map<std::string, Shown> shown_;
  std::set<std::string> disliked_;
  Rules rules_{.draws_min = 6,
               .ess_wanted = [](std::size_t) { return 10.0; },
               .judge =
                   [this](std::string_view name, const ScalarDraws& draws) {
                     shown_[std::string(name)] = {draws.chains, draws.draws,
                                                  draws.values.empty() ? k_nan : draws.values[0]};
                     Verdict verdict{.r_hat = 1.0, .complaints = {}};
                     if (disliked_.contains(std::string(name))) {
                       verdict.complaints = {std::string(name) + ": disliked"};
                     }
                     return verdict;
                   }};
};

TEST_F(DiagnosisTest, OfPlainChainsTheSecondHalfIsJudged) {
  archive_plain(options(201));
  values(archive::k_sample_stats, "lp")[100] = 1234;
  values(archive::k_posterior, "height_m")[10] = 4321;
  const Diagnosis diagnosis = diagnose();
  EXPECT_EQ(diagnosis.judged.first_scan, 100U);
  EXPECT_EQ(diagnosis.judged.scans, 101U);
  EXPECT_EQ(diagnosis.which, JudgedDraws::second_half);
  EXPECT_EQ(shown_.at("lp").draws, 101U);
  EXPECT_EQ(shown_.at("lp").chains, k_chains);
  EXPECT_EQ(shown_.at("lp").first, 1234);
  // The judged states belong to scans 100, 110, ... 200.
  EXPECT_EQ(shown_.at("height_m").draws, 11U);
  EXPECT_EQ(shown_.at("height_m").first, 4321);
  EXPECT_TRUE(shown_.contains("landing_m"));
  EXPECT_TRUE(shown_.contains("spin_radps[2, 1]"));
  EXPECT_EQ(shown_.size(), 2U + 2U + 10U);
}

TEST_F(DiagnosisTest, OfLaddersTheLongestRoundIsJudged) {
  archive_tempered(options(210), {0, 30, 90});
  values(archive::k_sample_stats, "lp")[90] = 1234;
  const Diagnosis diagnosis = diagnose();
  EXPECT_EQ(diagnosis.which, JudgedDraws::round);
  EXPECT_EQ(diagnosis.judged.first_scan, 90U);
  EXPECT_EQ(diagnosis.tempering->round, 3U);
  EXPECT_EQ(shown_.at("lp").draws, 120U);
  EXPECT_EQ(shown_.at("lp").first, 1234);
  EXPECT_EQ(shown_.at("height_m").draws, 12U);
  // The third round has only begun, so the longer second round is judged.
  archive_tempered(options(100), {0, 30, 90});
  EXPECT_EQ(diagnose().judged.first_scan, 30U);
  EXPECT_EQ(shown_.at("lp").draws, 60U);
  EXPECT_EQ(shown_.at("height_m").draws, 6U);
}

TEST_F(DiagnosisTest, ToursAreNeverSaidToHaveMixed) {
  // Goal: a run of tours is never reported as mixed, because independent draws pass all measures
  // even if tours are too short. Means are still shown. Method: diagnose one run twice. One judge
  // complains about a scalar; the other judge accepts all scalars.
  archive::ArchiveOptions of_tours = archive::testing::options_for(options(201));
  of_tours.request_text = "[sampler]\nmethod = \"sequential\"\ntour_scans = 16\n";
  archive::write_digested(archive_, [&](archive::Sink& sink) {
    archive::write_archive(FakeRun(options(201)), FakeReader(), of_tours, sink);
  });
  disliked_ = {"lp"};
  const Diagnosis diagnosis = diagnose();
  EXPECT_EQ(diagnosis.which, JudgedDraws::tours);
  EXPECT_EQ(shown_.at("lp").draws, 201U);
  ASSERT_FALSE(diagnosis.reasons.empty());
  EXPECT_THAT(diagnosis.reasons[0], tests::HasFacts("tour|16 scans"));
  EXPECT_THAT(diagnosis.reasons, Contains("lp: disliked"));
  EXPECT_THAT(for_people("a.h5", diagnosis),
              HasSubstr("judged:\n  " + diagnosis.reasons[0].substr(0, 20)));
  EXPECT_EQ(as_json("a.h5", diagnosis)["judged"]["what"], "tours");
  disliked_.clear();
  EXPECT_THAT(diagnose().reasons.at(0), tests::HasFacts("tour"));
}

TEST_F(DiagnosisTest, DrawsBeginWithTheFirstRound) {
  // The first twenty scans are annealing and don't count as draws.
  archive_tempered(options(210), {20, 50, 110});
  values(archive::k_sample_stats, "lp")[90] = 1234;
  const Diagnosis diagnosis = diagnose();
  EXPECT_EQ(diagnosis.judged.first_scan, 90U);
  EXPECT_EQ(diagnosis.judged.scans, 100U);
  EXPECT_EQ(shown_.at("lp").first, 1234);
}

TEST_F(DiagnosisTest, LaddersWithoutARoundTripAreAReason) {
  archive_tempered(options(210), {0, 30, 90});
  values(archive::k_sample_stats, "log_constraint").assign(k_chains * 210, 0);
  EXPECT_THAT(diagnose().reasons,
              ElementsAre(AllOf(HasSubstr("1 of 3 ladders"), HasSubstr("ladder 1"))));
  values(archive::k_tempering, "round_trips").assign(9, 1);
  EXPECT_THAT(diagnose().reasons, IsEmpty());
}

TEST_F(DiagnosisTest, StatesWithoutProbabilityAreCountedAndAReason) {
  archive_plain(options(201));
  std::vector<double>& log_constraint = values(archive::k_sample_stats, "log_constraint");
  log_constraint.assign(log_constraint.size(), -1);
  EXPECT_THAT(diagnose().reasons, IsEmpty());
  log_constraint[5] = -std::numeric_limits<double>::infinity();  // not judged
  EXPECT_THAT(diagnose().reasons, IsEmpty());
  log_constraint[150] = -std::numeric_limits<double>::infinity();
  const Diagnosis diagnosis = diagnose();
  ASSERT_EQ(diagnosis.reasons.size(), 1U);
  EXPECT_THAT(diagnosis.reasons[0], tests::HasFacts("log_constraint: |1 of 303|-inf"));
  EXPECT_EQ(diagnosis.scalars[1].verdict.mean, -1);
  EXPECT_TRUE(std::isnan(diagnosis.scalars[1].verdict.mcse));
  EXPECT_THAT(for_people("a.h5", diagnosis), HasSubstr("1 are -inf"));
}

TEST_F(DiagnosisTest, EveryComplaintIsAReasonAndAVariableGivesOne) {
  archive_plain(options(201));
  values(archive::k_sample_stats, "log_constraint").assign(k_chains * 201, 0);
  disliked_ = {"lp", "bounces", "spin_radps[0, 1]", "spin_radps[2, 0]"};
  const Diagnosis diagnosis = diagnose();
  EXPECT_FALSE(diagnosis.mixed());
  EXPECT_THAT(diagnosis.reasons,
              ElementsAre("lp: disliked", "bounces: disliked",
                          tests::LinesHaveFacts("spin_radps[0, 1]: disliked|1 more|6")));
  EXPECT_EQ(diagnosis.variables.at(2).failing, 2U);
}

TEST_F(DiagnosisTest, TooFewDrawsAreSaidOnce) {
  archive_plain(options(1));
  disliked_ = {"lp", "height_m"};
  EXPECT_THAT(diagnose().reasons, ElementsAre(tests::HasFacts("judged scans: |1|6")));
  // Only every tenth scan has a state, so the judge gets five states per chain.
  disliked_ = {"height_m"};
  archive_plain(options(100));
  values(archive::k_sample_stats, "log_constraint").assign(k_chains * 100, 0);
  EXPECT_THAT(diagnose().reasons, ElementsAre(tests::HasFacts("archived states|thin|5|6")));
}

TEST_F(DiagnosisTest, OneChainIsSaidToBeHalved) {
  archive_plain({.chains = 1, .scans = 201});
  EXPECT_THAT(diagnose().notes, ElementsAre(HasSubstr("R-hat compares its two halves")));
}

TEST_F(DiagnosisTest, SolutionsAreLineagesOfTheWholeRun) {
  const FakeRunOptions run = options(201);
  archive_plain(run);
  const Diagnosis diagnosis = diagnose();
  std::set<std::pair<std::uint32_t, std::uint64_t>> lineages;
  std::uint64_t satisfied = 0;
  for (std::uint32_t c = 0; c < k_chains; ++c) {
    FakeRun(run).for_each_draw({c}, [&](base::ScanIndex, const plan::ScanRecord& record) {
      if (!record.satisfied) return;
      lineages.emplace(c, record.lineage);
      ++satisfied;
    });
  }
  EXPECT_EQ(diagnosis.solutions, lineages.size());
  EXPECT_EQ(diagnosis.satisfied, satisfied);
  EXPECT_LT(diagnosis.satisfied_judged, satisfied);
}

TEST_F(DiagnosisTest, NumbersThatCantBeAreRefused) {
  const auto refused = [&](const char* table, std::size_t place, double value) {
    archive_tempered(options(210), {0, 30, 90});
    values(archive::k_tempering, table)[place] = value;
    return tests::failure_of([&] { diagnose(); }, table);
  };
  for (const double wrong : {-1.0, 0.5, 211.0, 1e300, -std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(refused("first_scan", 0, wrong), base::ExitCode::bad_archive) << wrong;
    EXPECT_EQ(refused("scans", 4, wrong), base::ExitCode::bad_archive) << wrong;
  }
  EXPECT_EQ(refused("first_scan", 4, 31), base::ExitCode::bad_archive);
}

TEST_F(DiagnosisTest, JsonHasEveryReasonAndNullForWhatIsNotKnown) {
  archive_tempered(options(210), {0, 30, 90});
  const json::Value json = as_json("a.h5", diagnose());
  EXPECT_FALSE(json.at("mixed").get<bool>());
  EXPECT_EQ(json.at("judged").at("what"), "round");
  EXPECT_EQ(json.at("tempering").at("ladders").size(), k_chains);
  EXPECT_EQ(json::Value::parse(json.dump()).at("simulations"), nullptr);
}

}  // namespace sleight::analysis::diagnosis_test
