#include "common/store/stored_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <functional>
#include <limits>
#include <map>
#include <string>

#include "common/base/error.h"
#include "common/store/damage.h"
#include "common/store/run_store.h"
#include "tests/unit/common/store/examples.h"

namespace sleight::store {
namespace {

using testing::example_identity;
using testing::result_of;

class StoredRunOf : public testing::RunFolder {
 protected:
  plan::ScanRecord through_store(const plan::ScanRecord& record) const {
    RunStore store(folder(), example_identity(1));
    plan::UnitResult result = result_of(0, 0, 1);
    result.scans = {record};
    store.put(result);
    store.flush();
    return testing::stored(folder(), 0, 1).at(0);
  }
};

TEST_F(StoredRunOf, KeepsEveryBit) {
  // Goal: a scan's record is read from the store with the exact bits that the worker returned.
  // Method: store a record of extreme values: outcomes that are NaNs with payloads, a density of
  // minus infinity, empty lists, and the largest lineage.
  plan::ScanRecord record;
  record.log_prior = std::numeric_limits<double>::denorm_min();
  record.log_constraint = -std::numeric_limits<double>::infinity();
  record.lineage = std::numeric_limits<std::uint64_t>::max();
  record.proposed = {0xffffffffU, 0};
  for (const std::uint64_t bits : {0x7ff0000000000001U, 0xfff8dead00000000U, 0x8000000000000000U})
    record.outcome.push_back(std::bit_cast<double>(bits));
  EXPECT_TRUE(testing::same_bits(through_store(record), record));
}

TEST_F(StoredRunOf, KeepsTheBitsOfDensities) {
  // Goal: the two densities have their own columns and keep their bits. Method: store doubles that
  // a database might convert: whole numbers, signed zeros, the largest double.
  const std::vector<double> values{-0.0,
                                   0.0,
                                   1.0,
                                   -3.0,
                                   4503599627370497.0,
                                   9007199254740993.0,
                                   1e300,
                                   0.1,
                                   -0.1,
                                   std::numeric_limits<double>::max(),
                                   -std::numeric_limits<double>::infinity(),
                                   std::numeric_limits<double>::infinity()};
  RunStore store(folder(), example_identity(1));
  plan::UnitResult result = result_of(0, 0, static_cast<std::uint32_t>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) {
    result.scans[i].log_prior = values[i];
    result.scans[i].log_constraint = values[values.size() - 1 - i];
  }
  store.put(result);
  store.flush();
  const std::vector<plan::ScanRecord> back = testing::stored(folder(), 0, values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    EXPECT_TRUE(testing::same_bits(back[i], result.scans[i])) << values[i];
}

TEST_F(StoredRunOf, CutsWhereItIsTold) {
  // Goal: if a reader is limited to n scans, it gets exactly the first n scans of each chain.
  // Method: limit one reader to 7 scans and another reader to 0, while the store is open for
  // writing.
  RunStore store(folder(), example_identity(2));
  store.put(result_of(0, 0, 9));
  store.put(result_of(1, 0, 7));
  store.flush();
  const StoredRun run(folder(), {.chains = 2, .scans = 7});
  EXPECT_EQ(run.chains(), 2U);
  EXPECT_EQ(run.draws(), 7U);
  for (const std::uint32_t chain : {0U, 1U}) {
    std::uint64_t next = 0;
    run.for_each_draw(base::ChainId{chain}, [&](base::ScanIndex scan, const auto& record) {
      EXPECT_EQ(scan.value, next);
      EXPECT_TRUE(testing::same_bits(record, testing::record_of(chain, next++)));
    });
    EXPECT_EQ(next, 7U);
  }
  store.put(result_of(0, 9, 1));
  store.flush();
  EXPECT_TRUE(testing::stored(folder(), 1, 0).empty());
}

TEST_F(StoredRunOf, CountsFailuresUpToTheCut) {
  // Goal: failures() counts the failures of all replicas in the scans before the cut, and no
  // others. Method: for each cut, compare the counts with the sum over the example records. Then
  // damage a stored count; failures() must throw.
  RunStore store(folder(), example_identity(2));
  store.put(result_of(0, 0, 40));
  store.put(result_of(1, 0, 40));
  plan::UnitResult other = result_of(1, 0, 40);
  other.unit.replica.replica = base::ReplicaId{3};
  store.put(other);
  store.flush();
  for (std::uint64_t cut = 0; cut <= 40; ++cut) {
    plan::FailureCounts expected;
    for (std::uint64_t scan = 0; scan < cut; ++scan) {
      for (const std::uint32_t chain : {0U, 1U, 1U})
        expected.add(testing::record_of(chain, scan).failures);
    }
    EXPECT_EQ(StoredRun(folder(), {.chains = 2, .scans = cut}).failures(), expected) << cut;
  }
  EXPECT_GT(StoredRun(folder(), {.chains = 2, .scans = 40}).failures().total(), 0U);
  Database database(RunStore::database_path(folder()), Access::read_write);
  database.execute("UPDATE scan SET failures=zeroblob(48) WHERE chain=1 AND replica=3 AND scan=7");
  EXPECT_THROW((void)StoredRun(folder(), {.chains = 2, .scans = 40}).failures(), base::Error);
}

TEST_F(StoredRunOf, ReadsWhoIsAtInverseTemperature1) {
  // Goal: if a chain has several replicas, a reader gets the record of the replica at inverse
  // temperature 1 for each scan. Method: store two replicas that swap inverse temperatures after
  // each scan. The second replica exists only from scan 2 on.
  RunStore store(folder(), example_identity(1));
  plan::UnitResult first = result_of(0, 0, 5);
  plan::UnitResult second = testing::forged(result_of(0, 2, 3));
  second.unit.replica.replica = base::ReplicaId{1};
  for (std::uint64_t scan = 0; scan < 5; ++scan) {
    const bool is_first = scan < 2 || scan % 2 == 0;
    first.scans[scan].inverse_temperature = is_first ? 1 : 0.5;
    if (scan >= 2) second.scans[scan - 2].inverse_temperature = is_first ? 0.5 : 1;
  }
  store.put(second);
  store.put(first);
  store.flush();
  const std::vector<plan::ScanRecord> back = testing::stored(folder(), 0, 5);
  for (std::uint64_t scan = 0; scan < 5; ++scan) {
    const bool is_first = scan < 2 || scan % 2 == 0;
    EXPECT_TRUE(
        testing::same_bits(back[scan], is_first ? first.scans[scan] : second.scans[scan - 2]))
        << scan;
  }
  const StoredRun view(folder(), {.chains = 1, .scans = 5});
  EXPECT_EQ(view.replicas(), 2U);
  std::uint64_t scans = 0;
  view.replay([&](const plan::ReplicaKey& replica, base::ScanIndex begin,
                  std::span<const plan::ScanRecord> records) {
    EXPECT_EQ(begin.value, replica.replica.value == 0 ? 0U : 2U);
    scans += records.size();
  });
  EXPECT_EQ(scans, 8U);
}

TEST_F(StoredRunOf, ReplicasAreReplayedTogether) {
  // Goal: a replay advances dependent replicas together, so that a plan buffers few scans. Each
  // replica's scans come once and in order. Method: store three replicas with more scans than a
  // batch. No replica may get far ahead of another.
  constexpr std::uint64_t k_scans = 10'000;
  constexpr std::uint64_t k_apart_max = 4096;
  RunStore store(folder(), example_identity(1));
  for (std::uint32_t replica = 0; replica < 3; ++replica) {
    plan::UnitResult result = result_of(0, 0, k_scans);
    result.unit.replica.replica = base::ReplicaId{replica};
    store.put(std::move(result));
  }
  store.flush();
  const auto check = [&](const auto& replay) {
    std::map<plan::ReplicaKey, std::uint64_t> next;
    for (std::uint32_t replica = 0; replica < 3; ++replica)
      next[{base::ChainId{0}, base::ReplicaId{replica}}] = 0;
    replay([&](const plan::ReplicaKey& replica, base::ScanIndex first,
               std::span<const plan::ScanRecord> records) {
      EXPECT_EQ(first.value, next.at(replica));
      for (const auto& [other, reached] : next)
        EXPECT_LE(first.value, reached + k_apart_max);
      next.at(replica) += records.size();
    });
    for (const auto& [replica, reached] : next)
      EXPECT_EQ(reached, k_scans);
  };
  const StoredRun view(folder(), {.chains = 1, .scans = k_scans});
  check([&](const auto& visit) { view.replay(visit); });
  check([&](const auto& visit) { store.replay_all(visit); });
}

TEST_F(StoredRunOf, MissingStoreIsAnError) {
  // Goal: if a folder has no store, reading from it throws an error and creates no file.
  EXPECT_THROW(StoredRun(folder(), {.chains = 1, .scans = 1}), base::Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder()));
}

TEST_F(StoredRunOf, MissingScansAreDamage) {
  // Goal: if a reader asks for more scans than are stored, it gets an error, so no archive is
  // silently too short.
  RunStore store(folder(), example_identity(1));
  store.put(result_of(0, 0, 3));
  store.flush();
  EXPECT_THROW((void)testing::stored(folder(), 0, 4), base::Error);
}

TEST_F(StoredRunOf, ChangedRowsAreDamage) {
  // Goal: a damaged row never becomes another animation and never affects a resumed run. Method:
  // change each column of one stored scan in turn. Reading and replaying must throw an error that
  // names the chain and the scan.
  for (const char* change : {"log_prior=log_prior+1", "log_constraint='x'", "satisfied=1-satisfied",
                             "lineage=-1", "proposed=x'00'", "accepted=x''", "outcome=zeroblob(3)",
                             "failures=x'01'", "overlapping_starts=1", "method_values=NULL",
                             "method_values=zeroblob(24)", "state=zeroblob(5)", "checksum=0"}) {
    const std::string place = folder() + "/" + std::to_string(std::hash<std::string>()(change));
    const RunLock lock(place);
    {
      RunStore store(place, example_identity(1));
      store.put(result_of(0, 0, 3));
      store.flush();
    }
    Database database(RunStore::database_path(place), Access::read_write);
    database.execute(std::string("UPDATE scan SET ") + change + " WHERE scan=0");
    try {
      (void)testing::stored(place, 0, 3);
      FAIL() << change;
    } catch (const base::Error& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr("damaged: scan 0 of chain 0")) << change;
      EXPECT_TRUE(tells_of_damage(error.what())) << change;
    }
    try {
      RunStore store(place, example_identity(1));
      store.replay(store.progress().front().replica,
                   [](base::ScanIndex, std::span<const plan::ScanRecord>) {});
      FAIL() << change;
    } catch (const base::Error& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr("damaged: scan 0 of chain 0")) << change;
    }
  }
}

TEST_F(StoredRunOf, ChangedProgressIsDamage) {
  // Goal: a chain never resumes from a wrong state. Method: change the stored state, next scan,
  // chain or epoch, or delete a scan. Resuming the run must throw an error.
  for (const char* change :
       {"UPDATE replica SET state=zeroblob(8)", "UPDATE replica SET next_scan=2",
        "UPDATE replica SET chain=7", "DELETE FROM scan WHERE scan=1",
        "UPDATE run SET value='soon' WHERE key='epoch'"}) {
    const std::string place = folder() + "/" + std::to_string(std::hash<std::string>()(change));
    const RunLock lock(place);
    {
      RunStore store(place, example_identity(1));
      store.put(result_of(0, 0, 3));
      store.flush();
    }
    Database(RunStore::database_path(place), Access::read_write).execute(change);
    const auto go_on = [&] {
      RunStore store(place, example_identity(1));
      for (const ReplicaProgress& replica : store.progress()) {
        store.replay(replica.replica, [](base::ScanIndex, std::span<const plan::ScanRecord>) {});
      }
    };
    EXPECT_THROW(go_on(), base::Error) << change;
  }
}

}  // namespace
}  // namespace sleight::store
