// Goal: notes about animations are stored as written, and nothing else is stored. Method: write
// notes, and change, damage or replace their files.
#include "clients/gallery_server/notes.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "common/base/error.h"
#include "common/base/file_system.h"
#include "tests/support/property.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::gallery {
namespace {

namespace fs = std::filesystem;
using Json = json::Value;
using ::testing::HasSubstr;

Json changed(Notes& notes, const std::string& run, const std::string& animation,
             const Json& patch) {
  return notes.change(run, {{animation, patch}})[animation];
}

class NotesTest : public archive::testing::Scratch {
 protected:
  const Json starred{{"star", true}, {"hidden", false}, {"tags_on", {"calm"}}, {"note", "näher"}};
  const Json nothing{{"star", false}, {"hidden", false}, {"tags_off", {"calm"}}, {"note", ""}};
  const std::string run = "3f2a9c01";
};

TEST_F(NotesTest, AreThereAgainTheNextTime) {
  // Goal: a note outlives the gallery, is private, and is deleted when it becomes empty.
  {
    Notes notes(path("notes"));
    EXPECT_EQ(changed(notes, run, "c0.250", starred)["changed"], 1);
    EXPECT_EQ(changed(notes, run, "find.3", starred)["changed"], 2);
    EXPECT_EQ(notes.trouble(), "");
  }
  struct stat about {};
  ASSERT_EQ(::stat(path("notes").c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 077U, 0U);
  Notes notes(path("notes"));
  const Json kept = notes.of_run(run);
  EXPECT_EQ(kept["c0.250"]["note"], "näher");
  EXPECT_EQ(kept["c0.250"]["tags"], Json::array({"calm"}));
  EXPECT_EQ(kept["find.3"]["star"], true);
  // Older galleries wrote an animation's name as "0.250" instead of "c0.250".
  base::PosixFileSystem files;
  const std::string file = path("notes/" + run + ".json");
  std::string text = base::read_text_file(file, 10'000);
  text.replace(text.find("c0.250"), 6, "0.250");
  base::write_text_file(files, file, text);
  EXPECT_EQ(Notes(path("notes")).of_run(run), kept);
  changed(notes, run, "0.250", nothing);
  EXPECT_FALSE(notes.of_run(run).contains("c0.250"));
  EXPECT_FALSE(Notes(path("notes")).of_run(run).contains("c0.250"));
  EXPECT_TRUE(notes.of_run("ffff").empty());
}

TEST_F(NotesTest, NothingElseGetsIn) {
  // Goal: invalid notes are refused and create no file. Method: use wrong types, excessive sizes,
  // and names that lead to other folders.
  Notes notes(path("notes"));
  const auto refused = [&](const std::string& of, const std::string& name, const Json& note) {
    EXPECT_THROW(changed(notes, of, name, note), base::Error) << of << " " << name << " " << note;
  };
  refused("../x", "c0.1", starred);
  refused("", "c0.1", starred);
  refused(run, "../0.1", starred);
  refused(run, "0.1/../../x", starred);
  refused(run, "c0.1", Json("text"));
  refused(run, "c0.1", {{"star", 1}});
  refused(run, "c0.1", {{"tags_on", "calm"}});
  refused(run, "c0.1", {{"tags_off", Json::array({1})}});
  refused(run, "c0.1", {{"tags_on", Json::array({std::string(k_tag_bytes_max + 1, 'x')})}});
  refused(run, "c0.1", {{"note", std::string(k_note_bytes_max + 1, 'x')}});
  Json many = Json::array();
  for (std::size_t i = 0; i <= k_tags_max; ++i)
    many.push_back(fmt::format("tag {}", i));
  refused(run, "c0.1", {{"tags_on", many}});
  EXPECT_FALSE(fs::exists(path("notes")));
}

TEST_F(NotesTest, ManyAreChangedAtOnceOrNone) {
  // Goal: a bulk change is stored whole or not at all. Method: change thousands of notes at once.
  // Then try a change that contains one invalid note, and a change that contains too many notes. A
  // change of as many notes as allowed takes seconds, or half a minute with sanitizers.
  Notes notes(path("notes"));
  Json stars = Json::object();
  for (int i = 0; i < 5000; ++i)
    stars[fmt::format("c0.{}", i)] = {{"star", true}};
  EXPECT_EQ(notes.change(run, stars).size(), 5000U);
  EXPECT_EQ(Notes(path("notes")).of_run(run).size(), 5000U);
  Json off = stars;
  for (const auto& [name, patch] : stars.items())
    off[name]["star"] = false;
  off["c0.4999"] = {{"star", "no"}};
  EXPECT_THROW(notes.change(run, off), base::Error);
  EXPECT_EQ(notes.of_run(run)["c0.0"]["star"], true);
  Json more = Json::object();
  for (std::size_t i = 0; i <= k_notes_max - 5000; ++i)
    more[fmt::format("c1.{}", i)] = {{"hidden", true}};
  EXPECT_THROW(notes.change(run, more), base::Error);
#ifndef SLEIGHT_SANITIZED
  if (property::of_tier(0, 1) == 1) {
    more.erase("c1.0");
    EXPECT_EQ(notes.change(run, more).size(), k_notes_max - 5000);
    EXPECT_EQ(Notes(path("notes")).of_run(run).size(), k_notes_max);
  }
#endif
  EXPECT_THROW(notes.change(run, Json::array({1})), base::Error);
}

TEST_F(NotesTest, WhatAChangeDoesNotSpeakOfStays) {
  // Goal: if two people change different fields of one note, both changes are stored.
  Notes mine(path("notes"));
  Notes yours(path("notes"));
  changed(mine, run, "c0.1", {{"note", "this one"}, {"tags_on", {"film"}}});
  EXPECT_EQ(changed(yours, run, "c0.1", {{"star", true}, {"tags_on", {"red", "film"}}})["note"],
            "this one");
  changed(mine, run, "c0.1", {{"tags_off", {"red", "none"}}});
  for (Notes* notes : {&mine, &yours}) {
    const Json kept = notes->of_run(run)["c0.1"];
    EXPECT_EQ(kept["note"], "this one");
    EXPECT_EQ(kept["star"], true);
    EXPECT_EQ(kept["tags"], Json::array({"film"}));
  }
}

TEST_F(NotesTest, WithoutAPlaceTheyLastUntilTheEnd) {
  // Goal: if notes can't be stored, they last until the gallery ends, and a message says so. An
  // invalid file stays unchanged. Method: use a path that isn't a folder, then a folder that has an
  // invalid file, then no path at all.
  std::ofstream(path("taken")) << "a file";
  Notes notes(path("taken/notes"));
  changed(notes, run, "c0.250", starred);
  EXPECT_EQ(notes.of_run(run)["c0.250"]["star"], true);
  EXPECT_THAT(notes.trouble(), HasSubstr("until the gallery ends"));

  fs::create_directories(path("notes"));
  std::ofstream(path("notes/3f2a9c01.json")) << "{\"notes\": [1, 2";
  Notes damaged(path("notes"));
  EXPECT_TRUE(damaged.of_run(run).empty());
  EXPECT_THAT(damaged.trouble(), HasSubstr("notes/3f2a9c01.json"));
  changed(damaged, run, "c0.1", starred);
  std::string first;
  std::getline(std::ifstream(path("notes/3f2a9c01.json")), first);
  EXPECT_EQ(first, "{\"notes\": [1, 2");

  Notes nowhere("");
  EXPECT_THAT(nowhere.trouble(), HasSubstr("no home folder"));
  changed(nowhere, run, "c0.1", starred);
  EXPECT_EQ(nowhere.of_run(run)["c0.1"]["star"], true);
}

TEST_F(NotesTest, AnotherRunsFileIsNoConcern) {
  // Goal: an unreadable file affects only its own run. Method: write nonsense into one run's file
  // and a note into another run's file. Read both.
  fs::create_directories(path("notes"));
  std::ofstream(path("notes/3f2a9c01.json")) << "[]";
  Notes notes(path("notes"));
  notes.of_run(run);
  changed(notes, "aaaa", "c0.1", starred);
  EXPECT_THAT(notes.trouble(), HasSubstr("3f2a9c01.json"));
  EXPECT_TRUE(Notes(path("notes")).of_run("aaaa").contains("c0.1"));
}

TEST_F(NotesTest, LieBesideTheArchiveWhereSomebodyWantsThemThere) {
  // Goal: notes are stored in the folder "sleight-notes" beside the archive if it exists, and
  // otherwise in a personal folder.
  ::setenv("XDG_DATA_HOME", path("data").c_str(), 1);
  EXPECT_EQ(notes_folder(path("a.h5")), path("data/sleight/notes"));
  fs::create_directories(path("sleight-notes"));
  EXPECT_EQ(notes_folder(path("a.h5")), path("sleight-notes"));
  Notes notes(path("data/own"));
  notes.keep_in(run, path("sleight-notes"));
  notes.keep_in(run, path("elsewhere"));
  changed(notes, run, "c0.1", starred);
  changed(notes, "aaaa", "c0.1", starred);
  EXPECT_TRUE(fs::exists(path("sleight-notes/3f2a9c01.json")));
  EXPECT_TRUE(fs::exists(path("data/own/aaaa.json")));
  ::unsetenv("XDG_DATA_HOME");
}

}  // namespace
}  // namespace sleight::gallery
