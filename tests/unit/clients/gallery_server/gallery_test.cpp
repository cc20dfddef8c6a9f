// Goal: the page always has all available data. Once data is read, it stays, even if the archive
// grows, vanishes, is damaged or returns. Method: change, delete and damage files that a gallery
// shows.
#include "clients/gallery_server/gallery.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/json/value.h"
#include "tests/support/facts.h"
#include "tests/unit/clients/gallery_server/shown_files.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::gallery {
namespace {

using ::testing::HasSubstr;
using testing::made_up;

class GalleryTest : public archive::testing::Scratch {
 protected:
  void SetUp() override { ::setenv("XDG_CACHE_HOME", path("cache").c_str(), 1); }
  void TearDown() override { ::unsetenv("XDG_CACHE_HOME"); }

  GalleryOptions options(std::vector<std::string> paths) {
    return {.paths = std::move(paths),
            .look_every_s = 0.01,
            .changed = [this] { ++changes; },
            .open = files.opener()};
  }
  /// Waits until an archive's state satisfies `is`. Returns the state.
  static json::Value waited(const Gallery& gallery, std::size_t archive,
                            const std::function<bool(const json::Value&)>& is) {
    for (int i = 0; i < 2000; ++i) {
      const auto state = gallery.state();
      if (state["archives"].size() > archive && is(state["archives"][archive]))
        return state["archives"][archive];
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ADD_FAILURE() << gallery.state().dump(1);
    return gallery.state()["archives"][archive];
  }
  static auto is(const char* state) {
    return [state](const json::Value& json) { return json["state"] == state; };
  }

  testing::ShownFiles files;
  std::atomic<int> changes = 0;
};

TEST_F(GalleryTest, AGrowingArchiveIsReadAnew) {
  // Goal: if a longer run replaces an archive, its new animations appear under a higher generation.
  // Old snapshots stay valid.
  const std::string archive = path("a.h5");
  files.put(archive, made_up(50));
  Gallery gallery(options({archive}));
  const auto before = waited(gallery, 0, is("ready"));
  const auto old = gallery.snapshot(0);
  EXPECT_EQ(before["name"], "a.h5");
  EXPECT_EQ(before["as_of"], "scan 50");
  files.put(archive, made_up(101, 4));
  const auto count = [](const json::Value& json, const char* key) {
    return json[key].get<std::size_t>();
  };
  const auto after = waited(gallery, 0, [&](const auto& json) {
    return count(json, "generation") > count(before, "generation");
  });
  EXPECT_GT(count(after, "kept"), count(before, "kept"));
  EXPECT_EQ(after["finds"], 4);
  EXPECT_EQ(after["as_of"], "scan 101; 4 found by search");
  EXPECT_EQ(old->index().entries.size(), before["kept"]);
  EXPECT_EQ(old->animation(0).motion.segment_count(),
            gallery.snapshot(0)->animation(0).motion.segment_count());
  EXPECT_GE(changes.load(), 2);
}

TEST_F(GalleryTest, ALargeArchiveShowsItsBeginningWhileTheRestIsRead) {
  // Goal: the first 500 animations of a large archive appear early, marked as incomplete. Later,
  // all its animations appear under a higher generation. A small archive appears whole at once.
  // Method: record the state at each change.
  const std::string archive = path("a.h5");
  std::vector<json::Value> said;
  std::atomic<Gallery*> telling = nullptr;
  const auto start = [&] {
    said.clear();
    telling = nullptr;
    GalleryOptions asked = options({archive});
    asked.changed = [&] {
      if (telling == nullptr) return;  // no archive can be open yet
      const auto state = telling.load()->state();
      for (const auto& shown : state["archives"].elements())
        if (shown["state"] == "ready") said.push_back(shown);
    };
    asked.open = [&, open = asked.open](const std::string& file) {
      telling.wait(nullptr);
      return open(file);
    };
    return asked;
  };
  const auto all_of = [&](Gallery& gallery, int finds) {
    telling = &gallery;
    telling.notify_all();
    waited(gallery, 0, [&](const auto& json) { return json["finds"] == finds; });
    return gallery.snapshot(0);
  };
  const auto entries_of = [](const json::Value& json) {
    return json["kept"].get<std::size_t>() + json["finds"].get<std::size_t>();
  };
  for (const int finds : {900, 300}) {
    files.put(archive, made_up(50, static_cast<std::uint64_t>(finds)));
    const bool is_large = finds > 500;
    auto gallery = std::make_unique<Gallery>(start());
    const auto whole = all_of(*gallery, finds);
    gallery.reset();  // ends all reports
    ASSERT_FALSE(said.empty());
    EXPECT_EQ(said.front()["is_beginning"], is_large);
    EXPECT_EQ(entries_of(said.front()) == 500, is_large);
    EXPECT_EQ(said.back()["is_beginning"], false);
    EXPECT_EQ(said.back()["finds"], finds);
    EXPECT_EQ(said.back()["generation"].get<std::uint64_t>() >
                  said.front()["generation"].get<std::uint64_t>(),
              is_large);
    EXPECT_EQ(whole->index().entries.size(), entries_of(said.back()));
    EXPECT_FALSE(whole->is_beginning());
  }
}

TEST_F(GalleryTest, StartedAgainItTellsAnotherReading) {
  // An open page must not confuse its entries with the entries of a restarted gallery.
  const std::string archive = path("a.h5");
  files.put(archive, made_up(50));
  std::vector<json::Value> said;
  for (int i = 0; i < 2; ++i) {
    const Gallery gallery(options({archive}));
    said.push_back(waited(gallery, 0, is("ready")));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(said[0]["run"], said[1]["run"]);
  EXPECT_GT(said[1]["generation"].get<std::uint64_t>(), said[0]["generation"].get<std::uint64_t>());
}

TEST_F(GalleryTest, WhatIsGoneOrDamagedKeepsWhatWasRead) {
  // Goal: a deleted or damaged file is reported, its data stays, and the restored file is read
  // again.
  const std::string archive = path("a.h5");
  files.put(archive, made_up(50));
  Gallery gallery(options({archive}));
  const auto before = waited(gallery, 0, is("ready"));
  std::filesystem::remove(archive);
  EXPECT_THAT(waited(gallery, 0, is("gone"))["words"].get<std::string>(),
              tests::HasFacts("no longer exists|stays visible"));
  EXPECT_NE(gallery.snapshot(0), nullptr);
  files.damage(archive);
  EXPECT_THAT(waited(gallery, 0, is("damaged"))["words"].get<std::string>(),
              tests::HasFacts("it is damaged|stays visible"));
  EXPECT_EQ(gallery.snapshot(0)->generation(), before["generation"]);
  files.put(archive, made_up(60));
  EXPECT_EQ(waited(gallery, 0, is("ready"))["as_of"], "scan 60");
}

TEST_F(GalleryTest, AFolderShowsWhatLiesInItAndNothingElse) {
  // Goal: a folder's archives are shown, including archives that are added later. A damaged archive
  // affects no other archive. If a link leads outside the folder, it is reported and not opened.
  // Method: show a folder with a sound archive, a damaged archive and a link.
  std::filesystem::create_directories(path("runs"));
  std::filesystem::create_directories(path("elsewhere"));
  files.put(path("runs/b.h5"), made_up(50));
  files.damage(path("runs/c.h5"));
  files.put(path("elsewhere/secret.h5"), made_up(40));
  std::filesystem::create_symlink(path("elsewhere/secret.h5"), path("runs/link.h5"));
  Gallery gallery(options({path("runs")}));
  waited(gallery, 0, is("ready"));
  EXPECT_THAT(waited(gallery, 1, is("damaged"))["words"].get<std::string>(),
              HasSubstr("it is damaged"));
  EXPECT_EQ(gallery.snapshot(1), nullptr);
  EXPECT_EQ(gallery.archives(), 2U);
  const auto left_out = gallery.state()["left_out"];
  ASSERT_EQ(left_out.size(), 1U);
  EXPECT_EQ(left_out[0]["name"], "link.h5");
  files.put(path("runs/a.h5"), made_up(30));
  EXPECT_EQ(waited(gallery, 2, is("ready"))["name"], "a.h5");
}

}  // namespace
}  // namespace sleight::gallery
