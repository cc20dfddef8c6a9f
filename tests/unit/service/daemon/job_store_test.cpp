// Goal: a save is stored completely or not at all. If another program changed a store, the store is
// refused and stays as it is. Method: make random saves. Compare the stored jobs with a simple
// model of the tables. Change rows and formats with SQL.
#include "service/daemon/job_store.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "common/base/error.h"
#include "common/random/stream.h"
#include "tests/unit/service/daemon/example_jobs.h"

namespace sleight::daemon {
namespace {

using testing::full_job;

class JobStoreTest : public ::testing::Test {
 protected:
  JobStoreTest() {
    folder_ = std::filesystem::temp_directory_path() /
              ("job-store-" + std::to_string(::getpid()) + "-" +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
    path_ = folder_ / "jobs.sqlite";
  }
  ~JobStoreTest() override { std::filesystem::remove_all(folder_); }

  void change(const std::string& sql) {
    store::Database database(path_, store::Access::read_write);
    database.execute(sql);
  }

  std::filesystem::path folder_;
  std::string path_;
};

void save(JobStore& store, const Save& one) {
  const Save* saves[] = {&one};
  store.save(saves);
}

Save save_of(std::uint64_t id) {
  Save one;
  one.jobs.jobs.push_back(full_job(id));
  one.jobs.changes.push_back({.id = jobs::JobId{id}, .words = "first"});
  one.jobs.clock_s = 1.0 / 3;
  one.jobs.next_id = id + 1;
  one.requests.push_back({.job = jobs::JobId{id}, .text = "[world]\n", .world = "toy"});
  return one;
}

TEST_F(JobStoreTest, FindsWhatWasSaved) {
  random::Stream stream({.seed = 7, .purpose = random::Purpose::scene}, 0);
  const auto below = [&](std::uint64_t bound) { return stream.bits() % bound; };
  std::map<std::uint64_t, jobs::Job> expected;
  std::map<std::uint64_t, std::uint64_t> changes;
  double clock_s = 0;
  {
    JobStore store(path_);
    for (int step = 0; step < 200; ++step) {
      const std::uint64_t id = 1 + below(20);
      Save one = save_of(id);
      jobs::Job& job = one.jobs.jobs.front();
      job.core_seconds = stream.uniform() * 1e6;
      clock_s = one.jobs.clock_s = static_cast<double>(step) / 3;
      expected[id] = job;
      ++changes[id];
      if (below(5) == 0) {
        one.jobs.erased.push_back(jobs::JobId{id});
        expected.erase(id);
        changes.erase(id);
      }
      save(store, one);
    }
  }
  JobStore store(path_);
  const StoredJobs loaded = store.load();
  ASSERT_EQ(loaded.jobs.size(), expected.size());
  for (const jobs::Job& job : loaded.jobs)
    EXPECT_EQ(job, expected.at(job.id.value));
  EXPECT_EQ(loaded.clock_s, clock_s);
  EXPECT_EQ(loaded.requests.size(), expected.size());
  for (const auto& [job, count] : loaded.change_counts)
    EXPECT_EQ(count, changes.at(job.value));
}

TEST_F(JobStoreTest, ReadersSeeTextsAndHistories) {
  JobStore store(path_);
  save(store, save_of(4));
  Save next = save_of(4);
  next.requests.front().revision = 2;
  next.requests.front().text = "[world]\nlonger\n";
  save(store, next);
  JobReader reader(store.to_read());
  EXPECT_EQ(reader.request(jobs::JobId{4}, 2)->text, "[world]\nlonger\n");
  EXPECT_EQ(reader.request(jobs::JobId{4}, 1)->world, "toy");
  EXPECT_FALSE(reader.request(jobs::JobId{4}, 3).has_value());
  const auto changes = reader.changes(jobs::JobId{4}, 2, 10);
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes.front().number, 2U);
  EXPECT_EQ(changes.front().change.words, "first");
}

TEST_F(JobStoreTest, RefusesChangedRows) {
  {
    JobStore store(path_);
    save(store, save_of(1));
    save(store, save_of(2));
  }
  for (const char* sql :
       {"UPDATE job SET record = replace(record, 'words', 'wards') WHERE id = 1",
        "UPDATE job SET id = 7 WHERE id = 2", "UPDATE request SET asked = '{}'",
        "UPDATE job SET record = '{}'", "UPDATE state SET value = '5' WHERE key = 'next_id'"}) {
    std::filesystem::copy_file(path_, folder_ / "kept");
    change(sql);
    JobStore store(path_);
    EXPECT_THROW(store.load(), base::Error) << sql;
    std::filesystem::remove(path_ + "-wal");
    std::filesystem::remove(path_ + "-shm");
    std::filesystem::rename(folder_ / "kept", path_);
  }
}

TEST_F(JobStoreTest, RefusesOtherFormatsAndFiles) {
  { JobStore store(path_); }
  {
    store::Database database(path_, store::Access::read_write);
    database.execute("DROP TABLE state");
    database.execute("CREATE TABLE state(key TEXT, value TEXT, checksum INTEGER)");
  }
  EXPECT_THROW(JobStore{path_}, base::Error);
  EXPECT_TRUE(std::filesystem::exists(path_));
}

}  // namespace
}  // namespace sleight::daemon
