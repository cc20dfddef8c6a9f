// Goal: if an archive was browsed before, its outline is shown at once and agrees with the whole
// archive. Questions about motions wait for the whole archive. Method: show an archive with a
// stored outline. Delay the gallery's second reading of the file. Damage or replace the file before
// the second reading.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <future>
#include <memory>
#include <string>
#include <thread>

#include "clients/gallery_server/answers.h"
#include "clients/gallery_server/gallery.h"
#include "common/base/version.h"
#include "common/json/value.h"
#include "tests/unit/clients/gallery_server/shown_files.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::gallery {
namespace {

using Json = json::Value;
using testing::made_up;

template <class Holds>
bool holds_soon(const Holds& holds) {
  for (int i = 0; i < 2000 && !holds(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return holds();
}

class OutlinesTest : public archive::testing::Scratch {
 protected:
  void SetUp() override {
    ::setenv("XDG_CACHE_HOME", path("cache").c_str(), 1);
    archive_ = path("a.h5");
    files_.put(archive_, made_up(101, 30));
    keep_outline();
  }
  void TearDown() override {
    held_ = false;
    held_.notify_all();
    ::unsetenv("XDG_CACHE_HOME");
  }

  void keep_outline() {
    const Snapshot whole(archive_, {.open = files_.opener()});
    browse::keep_cached(
        archive_, browse::k_outline_ending, *browse::state_of_file(archive_),
        browse::bytes_of(browse::outline_of(whole.index(), whole.first_groups()), base::version()));
  }

  /// Starts a gallery. The gallery's first opening of the file succeeds at once. Later openings
  /// wait for let_go().
  std::unique_ptr<Gallery> begun() {
    opened_ = 0;
    held_ = true;
    return std::make_unique<Gallery>(
        GalleryOptions{.paths = {archive_},
                       .look_every_s = 0.01,
                       .open = [this, open = files_.opener()](const std::string& file) {
                         if (opened_++ > 0) held_.wait(true);
                         return open(file);
                       }});
  }
  void let_go() {
    held_ = false;
    held_.notify_all();
  }

  /// Returns the answers to a page's first questions about archive 0.
  static std::string first_answers(const Answers& answers, const Snapshot& snapshot) {
    std::string all;
    const std::string at = "/api/archives/0/";
    for (const char* what : {"scene", "looks", "table", "series"})
      all += answers({.path = at + what}).content.text();
    for (std::size_t entry = 0; entry < snapshot.index().entries.size(); entry += 7) {
      const std::string name = browse::short_text(snapshot.index().entries[entry].name);
      const web::Answer animation = answers({.path = at + "animations/" + name});
      EXPECT_EQ(animation.status, 200U) << name;
      all += animation.content.text();
    }
    const web::Answer groups = asked(answers, "/api/groups", groups_of(snapshot, 12));
    EXPECT_EQ(groups.status, 200U);
    return all.append(groups.content.text());
  }
  static Json groups_of(const Snapshot& snapshot, int groups) {
    return {{"id", 0},
            {"generation", snapshot.generation()},
            {"entries", nullptr},
            {"groups", groups},
            {"by", "medoids"}};
  }
  static web::Answer asked(const Answers& answers, const std::string& what, const Json& question) {
    return answers({.method = web::Method::post, .path = what, .body = question.dump()});
  }

  testing::ShownFiles files_;
  std::string archive_;
  std::atomic<int> opened_ = 0;
  std::atomic<bool> held_ = true;
  Notes notes_{""};
  analysis::Rules rules_{};
};

TEST_F(OutlinesTest, SayWhatTheWholeSays) {
  const auto gallery = begun();
  ASSERT_TRUE(holds_soon([&] { return gallery->snapshot(0) != nullptr; }));
  const auto outline = gallery->snapshot(0);
  ASSERT_TRUE(outline->is_outline());
  EXPECT_EQ(gallery->state()["archives"][0]["state"], "ready");
  const Json said = gallery->state()["archives"][0];
  const Answers answers(*gallery, notes_, rules_, "1.2");
  const std::string before = first_answers(answers, *outline);

  const Json find{{"query", "any in x 0..1m"},
                  {"archives", {{{"id", 0}, {"generation", outline->generation()}}}}};
  const Json alike{
      {"id", 0}, {"generation", outline->generation()}, {"to", {0}}, {"entries", nullptr}};
  std::atomic<int> asking = 0;
  std::vector<std::future<web::Answer>> waiting;
  for (const auto& [what, question] : {std::pair("/api/find", find), std::pair("/api/alike", alike),
                                       std::pair("/api/groups", groups_of(*outline, 5))}) {
    waiting.push_back(std::async(std::launch::async, [&, what, question] {
      ++asking;
      return asked(answers, what, question);
    }));
  }
  waiting.push_back(std::async(std::launch::async, [&] {
    ++asking;
    return answers({.path = "/api/archives/0/index"});
  }));
  ASSERT_TRUE(holds_soon([&] { return asking == 4; }));
  for (const auto& one : waiting)
    EXPECT_EQ(one.wait_for(std::chrono::seconds(0)), std::future_status::timeout);
  let_go();
  for (auto& one : waiting)
    EXPECT_EQ(one.get().status, 200U);
  const auto whole = gallery->snapshot(0);
  EXPECT_FALSE(whole->is_outline());
  EXPECT_EQ(whole->generation(), outline->generation());
  EXPECT_EQ(Json(gallery->state()["archives"][0]), said);
  EXPECT_EQ(first_answers(answers, *whole), before);
}

TEST_F(OutlinesTest, AQuestionDoesNotWaitForEver) {
  const auto gallery = begun();
  ASSERT_TRUE(holds_soon([&] { return gallery->snapshot(0) != nullptr; }));
  const Answers answers(*gallery, notes_, rules_, "1.2");
  const web::Answer answer = asked(answers, "/api/groups", groups_of(*gallery->snapshot(0), 5));
  EXPECT_EQ(answer.status, 503U);
  let_go();
  ASSERT_TRUE(holds_soon([&] { return !gallery->snapshot(0)->is_outline(); }));
  EXPECT_EQ(asked(answers, "/api/groups", groups_of(*gallery->snapshot(0), 5)).status, 200U);
}

TEST_F(OutlinesTest, StayWhereTheArchiveGoesOrIsDamaged) {
  // Goal: if the archive can't be read, the outline stays visible, and questions about motions are
  // refused at once. Once the archive is back, everything works. Method: damage or remove the file
  // before the second reading.
  for (const bool is_removed : {false, true}) {
    const auto gallery = begun();
    ASSERT_TRUE(holds_soon([&] { return gallery->snapshot(0) != nullptr; }));
    const auto outline = gallery->snapshot(0);
    ASSERT_TRUE(outline->is_outline());
    if (is_removed) {
      std::filesystem::remove(archive_);
    } else {
      files_.damage(archive_);
    }
    let_go();
    const char* state = is_removed ? "gone" : "damaged";
    ASSERT_TRUE(holds_soon([&] { return gallery->state()["archives"][0]["state"] == state; }));
    const Answers answers(*gallery, notes_, rules_, "1.2");
    EXPECT_EQ(asked(answers, "/api/groups", groups_of(*outline, 12)).status, 200U);
    EXPECT_EQ(answers({.path = "/api/archives/0/table"}).status, 200U);
    // If the question had waited in vain, its status would be 503.
    EXPECT_EQ(asked(answers, "/api/groups", groups_of(*outline, 5)).status, 502U);
    files_.put(archive_, made_up(101, 30));
    ASSERT_TRUE(holds_soon([&] { return !gallery->snapshot(0)->is_outline(); }));
    const auto whole = gallery->snapshot(0);
    EXPECT_EQ(asked(answers, "/api/groups", groups_of(*whole, 5)).status, 200U);
    keep_outline();
  }
}

TEST_F(OutlinesTest, WhatCannotBeHadIsNotLookedForWithoutPause) {
  // Goal: while an archive is damaged, no thread is busy. Method: compare the processor time of
  // this process with the elapsed time.
  const auto gallery = begun();
  ASSERT_TRUE(holds_soon([&] { return gallery->snapshot(0) != nullptr; }));
  files_.damage(archive_);
  let_go();
  ASSERT_TRUE(holds_soon([&] { return gallery->state()["archives"][0]["state"] == "damaged"; }));
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t used = std::clock();  // processor time
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(static_cast<double>(std::clock() - used) / CLOCKS_PER_SEC, 0.5 * passed.count());
}

TEST_F(OutlinesTest, AreOfOneStateOfOneFile) {
  // If the file was replaced or the outline has another digest, the whole archive is read first.
  files_.put(archive_, made_up(60, 10));
  {
    const auto gallery = begun();
    let_go();
    ASSERT_TRUE(holds_soon([&] { return gallery->snapshot(0) != nullptr; }));
    EXPECT_FALSE(gallery->snapshot(0)->is_outline());
    EXPECT_EQ(opened_, 1);
  }
  const Snapshot whole(archive_, {.open = files_.opener()});
  browse::Outline other = browse::outline_of(whole.index(), whole.first_groups());
  other.index.digest.back() = other.index.digest.back() == '0' ? '1' : '0';
  const Snapshot read(archive_, {.outline = &other, .open = files_.opener()});
  EXPECT_FALSE(read.is_outline());
  EXPECT_EQ(read.index().entries, whole.index().entries);
}

}  // namespace
}  // namespace sleight::gallery
