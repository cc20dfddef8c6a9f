#include "worker/sampling/relaxed_finds.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "common/random/discrete_distributions.h"
#include "tests/support/property.h"
#include "worker/sampling/prior_lanes.h"

namespace sleight::sampling {
namespace {

/// Decides which starts succeed. Decides whether the last state of a relaxed find satisfies the
/// constraint.
struct Odds {
  std::uint64_t seed = 0;
  double of_start = 0;
  double of_chain = 0;
  bool finds(std::uint64_t start) const { return drawn(start, 0) < of_start; }
  bool lasts(std::uint64_t start) const { return drawn(start, 1) < of_chain; }

 private:
  double drawn(std::uint64_t start, std::uint64_t which) const {
    random::Stream stream({.seed = seed, .purpose = random::Purpose::search}, 2 * start + which);
    return stream.uniform();
  }
};

/// A find's state is the number of its start.
base::Bytes state_of(std::uint64_t start) {
  base::ByteWriter writer;
  writer.put(start);
  return writer.take();
}

/// Runs a plan's units like a worker, and records each chain's start.
class Runs {
 public:
  Runs(const Odds& odds, std::uint32_t relax_scans) : odds_(odds), relax_scans_(relax_scans) {}

  std::vector<plan::ScanRecord> run(const plan::Plan& plan, const plan::Unit& unit) {
    std::vector<plan::ScanRecord> records(unit.scans);
    if (unit.draws_prior()) return records;
    const std::uint32_t id = unit.replica.chain.value;
    if (unit.starts && !unit.searches()) {
      const base::BytesView start = plan.start_state(unit.replica);
      starts_[id] = {start.begin(), start.end()};
    }
    for (std::uint32_t nth = 0; nth < unit.scans; ++nth) {
      const std::uint64_t scan = unit.first_scan.value + nth;
      plan::ScanRecord& record = records[nth];
      if (unit.searches()) {
        const std::uint64_t start = plan::start_number(unit.replica.chain, scan);
        record.satisfied = odds_.finds(start);
        if (record.satisfied) record.state = state_of(start);
      } else {
        const std::uint64_t start = base::ByteReader(starts_.at(id)).get<std::uint64_t>().value();
        record.satisfied = scan == relax_scans_ ? odds_.lasts(start) : scan % 2 == 0;
      }
    }
    return records;
  }

 private:
  Odds odds_;
  std::uint32_t relax_scans_;
  std::map<std::uint32_t, base::Bytes> starts_;
};

std::uint64_t below(std::uint64_t count, random::Stream& stream) {
  return random::UniformInteger{.count = count}.draw(stream);
}

using Log = std::map<plan::ReplicaKey, std::vector<plan::ScanRecord>>;

/// Lets `workers` workers run units until nothing is left or `results_max` results are logged.
/// Results arrive in any order.
void work(plan::Plan& plan, Runs& runs, std::size_t workers, random::Stream& stream, Log& log,
          std::uint64_t results_max = UINT64_MAX) {
  std::vector<plan::Unit> out;
  for (std::uint64_t came = 0; came < results_max; ++came) {
    while (out.size() < workers) {
      const auto unit = plan.next_unit(static_cast<std::uint32_t>(1 + below(9, stream)));
      if (!unit) break;
      out.push_back(*unit);
    }
    if (out.empty()) return;
    std::swap(out[below(out.size(), stream)], out.back());
    const plan::Unit& unit = out.back();
    const auto records = runs.run(plan, unit);
    plan.consume(unit.replica, unit.first_scan, records);
    auto& logged = log[unit.replica];
    logged.insert(logged.end(), records.begin(), records.end());
    out.pop_back();
  }
}

struct Takes {
  std::uint64_t wanted = 1;
  std::uint32_t scans = 1;
  WithPriorDraws plan(std::uint64_t draws) const {
    return {std::make_unique<RelaxedFinds>(
                SearchLanes(1, wanted), RelaxedOptions{.seed = 1, .takes = wanted, .scans = scans}),
            draws};
  }
};

TEST(RelaxedFinds, TakesAreTheSameWhoeverRelaxes) {
  // Goal: chain k starts from find k, and each prior draw is made once. The takes are the first
  // chains whose last state satisfies the constraint. Workers, cuts of units, order and sessions
  // have no effect on the result. Method: compare random runs with a loop over the starts.
  for (const std::uint64_t i : property::cases(300)) {
    random::Stream stream({.seed = i, .purpose = random::Purpose::scene}, 0);
    const Odds odds{.seed = i,
                    .of_start = 0.3 + 0.7 * stream.uniform(),
                    .of_chain = 0.3 + 0.7 * stream.uniform()};
    const Takes asked{.wanted = 1 + below(20, stream),
                      .scans = static_cast<std::uint32_t>(1 + below(30, stream))};
    const std::uint64_t draws = below(300, stream);
    const std::size_t workers = 1 + below(30, stream);
    Runs runs(odds, asked.scans);
    Log log;
    WithPriorDraws first = asked.plan(draws);
    WithPriorDraws again = asked.plan(draws);
    const bool in_sessions = stream.uniform() < 0.5;
    work(first, runs, workers, stream, log, in_sessions ? below(500, stream) : UINT64_MAX);
    if (in_sessions) {
      for (const auto& [replica, records] : Log(log))
        again.consume(replica, {}, records);
      EXPECT_EQ(again.prior_draws(), first.prior_draws());
      EXPECT_EQ(again.finds().relaxed, first.finds().relaxed);
      work(again, runs, workers, stream, log);
    }
    const WithPriorDraws& done = in_sessions ? again : first;
    ASSERT_TRUE(done.finished());
    EXPECT_EQ(done.prior_draws(), draws);
    const plan::Finds finds = done.finds();
    EXPECT_EQ(finds.relaxed, asked.wanted);
    EXPECT_EQ(finds.relaxed_wanted, asked.wanted);
    EXPECT_FALSE(finds.gave_up);
    EXPECT_EQ(done.scans_common(), 0U);

    std::uint32_t chain = 0;
    std::uint64_t takes = 0;
    for (std::uint64_t start = 0; takes < asked.wanted; ++start) {
      if (!odds.finds(start)) continue;
      const auto& records = log.at({base::ChainId{chain++}, base::ReplicaId{0}});
      ASSERT_EQ(records.size(), asked.scans + 1U);
      ASSERT_EQ(records.back().satisfied, odds.lasts(start));
      takes += odds.lasts(start) ? 1 : 0;
    }
    EXPECT_EQ(finds.found, chain);
  }
}

TEST(RelaxedFinds, GivesUpWhereNothingLasts) {
  // Goal: if no find satisfies the constraint after relaxation, or if the search finds nothing, the
  // run gives up and ends.
  for (const Odds& odds : {Odds{.of_start = 1.1}, Odds{.of_chain = 1.1}}) {
    random::Stream stream({.seed = 1, .purpose = random::Purpose::scene}, 0);
    const Takes asked{.wanted = 3, .scans = 4};
    Runs runs(odds, asked.scans);
    Log log;
    WithPriorDraws plan = asked.plan(10);
    work(plan, runs, 3, stream, log);
    EXPECT_TRUE(plan.finished());
    EXPECT_TRUE(plan.finds().gave_up);
    EXPECT_EQ(plan.finds().relaxed, 0U);
    EXPECT_EQ(plan.prior_draws(), 10U);
  }
}

TEST(WithPriorDraws, TakesTurnsOnceNothingIsSearched) {
  // Goal: the search runs first, and afterwards chains and prior draws take turns. Method: check
  // the order in which one worker gets units.
  const Takes asked{.wanted = 2, .scans = 5};
  Runs runs({.of_start = 1.1, .of_chain = 1.1}, asked.scans);
  WithPriorDraws plan = asked.plan(4);
  std::string order;
  while (const auto unit = plan.next_unit(1)) {
    order += unit->draws_prior() ? 'p' : unit->searches() ? 's' : 'c';
    plan.consume(unit->replica, unit->first_scan, runs.run(plan, *unit));
  }
  EXPECT_EQ(order, "sspcpcpcpccccccccc");
}

}  // namespace
}  // namespace sleight::sampling
