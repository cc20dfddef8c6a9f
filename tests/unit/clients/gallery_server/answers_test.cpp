// Goal: answers agree with the archive. An address names an archive by its number and an animation
// by its name. Any other request is refused with a message. Method: request each address of an
// archive of the made-up world. Request wrong addresses, and send malformed questions.
#include "clients/gallery_server/answers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>

#include "clients/browse/query.h"
#include "common/archive/format.h"
#include "common/json/value.h"
#include "tests/unit/clients/gallery_server/shown_files.h"
#include "tests/unit/clients/gallery_server/unpack.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::gallery {
namespace {

using testing::made_up;
using testing::Unpacked;
using testing::unpacked;
using Json = json::Value;

class AnswersTest : public archive::testing::Scratch {
 protected:
  void SetUp() override {
    ::setenv("XDG_CACHE_HOME", path("cache").c_str(), 1);
    files.put(path("a.h5"), made_up(101, 3));
    gallery = std::make_unique<Gallery>(
        GalleryOptions{.paths = {path("a.h5")}, .look_every_s = 0.01, .open = files.opener()});
    for (int i = 0; i < 2000 && !gallery->snapshot(0); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    ASSERT_NE(gallery->snapshot(0), nullptr);
    snapshot = gallery->snapshot(0);
    answers = std::make_unique<Answers>(*gallery, notes, rules, "1.2");
  }
  void TearDown() override { ::unsetenv("XDG_CACHE_HOME"); }

  web::Answer get(std::string place, std::vector<web::Parameter> parameters = {}) const {
    return (*answers)({.path = std::move(place), .parameters = std::move(parameters)});
  }
  web::Answer post(std::string place, const std::string& body) const {
    return (*answers)({.method = web::Method::post, .path = std::move(place), .body = body});
  }
  Json posted(const std::string& place, const Json& question) const {
    const web::Answer answer = post(place, question.dump());
    EXPECT_EQ(answer.status, 200U) << answer.content.text();
    return Json::parse(answer.content.text());
  }
  Json at() const { return {{"id", 0}, {"generation", snapshot->generation()}}; }

  testing::ShownFiles files;
  Notes notes{""};
  analysis::Rules rules{};
  std::unique_ptr<Gallery> gallery;
  std::shared_ptr<const Snapshot> snapshot;
  std::unique_ptr<Answers> answers;
};

TEST_F(AnswersTest, TellTheTableAndEachAnimation) {
  // Goal: the answers about the table, the scene, the looks and the animations agree with each
  // other. Method: take names from the table, and fetch animations one by one and together.
  const web::Answer table_answer = get("/api/archives/0/table");
  const Unpacked table = unpacked(table_answer.content.text());
  const auto entries = table.head["entries"].get<std::size_t>();
  ASSERT_EQ(entries, snapshot->index().entries.size());
  const auto is_find = table.column<std::uint8_t>("is_find");
  const auto chain = table.column<std::uint32_t>("chain");
  const auto draw = table.column<double>("draw");
  std::string names;
  for (std::size_t i = 0; i < entries; ++i) {
    const std::string name = is_find[i] != 0 ? fmt::format("find.{}", draw[i])
                                             : fmt::format("c{}.{}", chain[i], draw[i]);
    EXPECT_EQ(name, browse::short_text(snapshot->index().entries[i].name));
    const web::Answer one = get("/api/archives/0/animations/" + name);
    ASSERT_EQ(one.status, 200U) << name;
    EXPECT_EQ(unpacked(one.content.text()).head["name"], name);
    if (i < 3) names += (i == 0 ? "" : ",") + name;
  }
  const web::Answer several = get("/api/archives/0/animations", {{"names", names}});
  const Unpacked three = unpacked(several.content.text());
  ASSERT_EQ(three.head["animations"].size(), 3U);
  const std::string second = three.head["animations"][1]["name"].get<std::string>();
  const web::Answer alone = get("/api/archives/0/animations/" + second);
  EXPECT_EQ(three.column<double>("1:start_s"),
            unpacked(alone.content.text()).column<double>("start_s"));
  const Json scene = Json::parse(get("/api/archives/0/scene").content.text());
  EXPECT_EQ(scene["numbers"].size(), table.head["numbers"].size());
  EXPECT_EQ(scene["prior_log_prior"].size(), archive::testing::FakeRunOptions{}.prior_draws);
  EXPECT_TRUE(std::ranges::is_sorted(scene["prior_log_prior"].get<std::vector<double>>()));
  const web::Answer looks_answer = get("/api/archives/0/looks");
  EXPECT_FALSE(unpacked(looks_answer.content.text()).head["meshes"].empty());
}

TEST_F(AnswersTest, FindGroupAndCompareAsTheCommandsDo) {
  // Goal: the server finds the animations that the functions in `browse` find. Groups and likeness
  // cover all animations.
  const browse::Index& index = snapshot->index();
  const std::string query = "bounces >= 2";
  const Json found = posted("/api/find", {{"query", query}, {"archives", Json::array({at()})}});
  const auto condition = browse::parse_query(query, index.scene, index.numbers);
  ASSERT_TRUE(condition.ok());
  EXPECT_EQ(found["found"][0]["entries"].get<std::vector<std::size_t>>(),
            browse::find(condition.value(), index));
  const Json all = posted("/api/find", {{"query", " "}, {"archives", Json::array({at()})}});
  EXPECT_EQ(all["found"][0]["entries"].size(), index.entries.size());
  const Json wrong =
      posted("/api/find", {{"query", "\"ä\" in q 1"}, {"archives", Json::array({at()})}});
  ASSERT_EQ(wrong["errors"].size(), 1U);
  EXPECT_EQ(wrong["errors"][0]["column"], 1);

  Json question = at();
  question.update({{"entries", nullptr}, {"groups", 4}, {"by", "medoids"}});
  const Json grouped = posted("/api/groups", question);
  ASSERT_EQ(grouped["groups"].size(), 4U);
  std::size_t members = 0;
  for (const Json& group : grouped["groups"].elements())
    members += group["members"].size();
  EXPECT_EQ(members, index.entries.size());
  question = at();
  question.update({{"to", {2}}, {"entries", nullptr}});
  const Json alike = posted("/api/alike", question);
  EXPECT_EQ(alike["entries"].size(), index.entries.size());
  EXPECT_EQ(alike["distance_m"][0], 0.0);
  EXPECT_TRUE(std::ranges::is_sorted(alike["distance_m"].get<std::vector<double>>()));
}

TEST_F(AnswersTest, WhatIsNotThereIsRefusedInWords) {
  // Goal: a wrong address is refused with a message, and no address leads outside the archives.
  for (const char* place :
       {"/api", "/api/", "/api/archives", "/api/archives/1/table", "/api/archives/-1/table",
        "/api/archives/0", "/api/archives/0/", "/api/archives/0/table/x", "/api/archives/00x/table",
        "/api/archives/0/animations/9.9", "/api/archives/0/animations/../../etc/passwd",
        "/api/archives/0/series/trace.nothing", "/api/archives/0/series/diagnosis",
        "/api/archives/99999999999999999999/table", "/x", "/api/galleryx"}) {
    const web::Answer answer = get(place);
    EXPECT_EQ(answer.status, 404U) << place;
    EXPECT_FALSE(Json::parse(answer.content.text())["error"].get<std::string>().empty());
  }
  EXPECT_EQ(get("/api/archives/0/animations").status, 400U);
  EXPECT_EQ(get("/api/archives/0/series/trace.lp", {{"chain", "7"}}).status, 404U);
  std::string names = "c0.1";
  for (int i = 0; i < 40; ++i)
    names += ",0.1";
  EXPECT_EQ(get("/api/archives/0/animations", {{"names", names}}).status, 400U);
}

TEST_F(AnswersTest, QuestionsOfAnyFormAreAnsweredOrRefused) {
  // Goal: malformed questions are refused and do no harm. Method: send invalid JSON, wrong types
  // and numbers, and an out-of-date generation number.
  const Json good = at();
  const auto status = [&](const char* place, const Json& question) {
    return post(place, question.dump()).status;
  };
  const auto with = [&](Json more) {
    Json question = good;
    question.update(more);
    return question;
  };
  EXPECT_EQ(post("/api/find", "{").status, 400U);
  EXPECT_EQ(post("/api/find", std::string(100'000, '[')).status, 400U);
  for (const Json& question : {Json(nullptr), Json(1), Json::array(), Json{{"query", 1}},
                               Json{{"query", "x"}, {"archives", 1}},
                               Json{{"query", "x"}, {"archives", Json::array({1})}}})
    EXPECT_EQ(status("/api/find", question), 400U) << question;
  const Json groups{{"entries", nullptr}, {"groups", 3}, {"by", "medoids"}};
  for (const Json& wrong :
       {Json{{"groups", 0}}, Json{{"groups", 501}}, Json{{"groups", -1}}, Json{{"groups", 1.5}},
        Json{{"by", "luck"}}, Json{{"entries", 1}}, Json{{"entries", {-1}}},
        Json{{"entries", {1'000'000}}}, Json{{"entries", {"a"}}}, Json{{"id", "0"}}}) {
    Json question = with(groups);
    question.update(wrong);
    EXPECT_EQ(status("/api/groups", question), 400U) << wrong;
  }
  EXPECT_EQ(status("/api/groups", with({{"entries", {1, 1, 2}}, {"groups", 1}, {"by", "medoids"}})),
            200U);
  EXPECT_EQ(
      status("/api/groups", with({{"entries", Json::array()}, {"groups", 3}, {"by", "medoids"}})),
      200U);
  Json old = with(groups);
  old["generation"] = 0;
  EXPECT_EQ(status("/api/groups", old), 409U);
  Json unknown = with(groups);
  unknown["id"] = 5;
  EXPECT_EQ(status("/api/groups", unknown), 404U);
  EXPECT_EQ(status("/api/alike", with({{"to", Json::array()}})), 400U);
  EXPECT_EQ(status("/api/notes", {{"run", "../x"}, {"notes", {{"c0.1", Json::object()}}}}), 400U);
  EXPECT_EQ(status("/api/notes", {{"run", "3f2a"}, {"name", "c0.1"}, {"note", Json::object()}}),
            400U);
  EXPECT_EQ(status("/api/nothing", good), 404U);
}

TEST_F(AnswersTest, PlotsAreTheChainsNumbers) {
  // Goal: traces show /sample_stats and mark changes of the chain. Histograms cover all draws.
  // Method: compare the columns of the answers with the archive's columns.
  const Json titles = Json::parse(get("/api/archives/0/series").content.text());
  EXPECT_GT(titles.size(), 5U);
  const web::Answer answer = get("/api/archives/0/series/trace.lp", {{"chain", "0"}});
  const Unpacked trace = unpacked(answer.content.text());
  snapshot->read([&](const archive::Source& source) {
    const auto lp =
        std::get<std::vector<double>>(source.read(archive::k_sample_stats, "lp", 0, 101));
    EXPECT_EQ(trace.column<double>("value"), lp);
    const auto lineage = std::get<std::vector<std::int64_t>>(
        source.read(archive::k_sample_stats, "lineage", 0, 101));
    std::vector<std::uint32_t> changes;
    for (std::uint32_t i = 1; i < 101; ++i)
      if (lineage[i] != lineage[i - 1]) changes.push_back(i);
    EXPECT_EQ(trace.column<std::uint32_t>("lineage"), changes);
    const auto satisfied = std::get<std::vector<std::int8_t>>(
        source.read(archive::k_sample_stats, "satisfied", 0, 101));
    std::vector<std::uint32_t> falls;
    for (std::uint32_t i = 1; i < 101; ++i)
      if (satisfied[i - 1] != 0 && satisfied[i] == 0) falls.push_back(i);
    EXPECT_EQ(trace.column<std::uint32_t>("fall"), falls);
    EXPECT_FALSE(falls.empty());
    // The first of the two kinds of proposals is `change_all`.
    const auto accepted = std::get<std::vector<std::int32_t>>(
        source.read(archive::k_sample_stats, "accepted", 0, 2 * 101));
    std::vector<std::uint32_t> changes_of_all;
    for (std::uint32_t i = 1; i < 101; ++i)
      if (accepted[2 * i] > 0) changes_of_all.push_back(i);
    EXPECT_EQ(trace.column<std::uint32_t>("change_all"), changes_of_all);
    EXPECT_FALSE(changes_of_all.empty());
  });
  const web::Answer pair_answer = get("/api/archives/0/series/pair.log_prior");
  const Unpacked pair = unpacked(pair_answer.content.text());
  EXPECT_EQ(pair.head["draws"], 101);
  double sum = 0;
  for (const double share : pair.column<double>("posterior"))
    sum += share;
  EXPECT_NEAR(sum, 1, 1e-12);
}

struct Damage {
  std::string_view group;
  std::string_view dataset;
  bool is_missing;
};

class Damaged final : public archive::Source {
 public:
  Damaged(archive::MemoryArchive whole, const Damage& damage)
      : whole_(std::move(whole)), groups_(whole_.groups()) {
    for (archive::Group& group : groups_) {
      if (group.name != damage.group) continue;
      for (archive::DatasetSpec& spec : group.datasets)
        if (spec.name == damage.dataset) spec.dims.pop_back();
      if (damage.is_missing)
        std::erase_if(group.datasets,
                      [&](const auto& spec) { return spec.name == damage.dataset; });
    }
  }
  std::string name() const override { return "a.h5"; }
  const std::vector<archive::Group>& groups() const override { return groups_; }
  archive::Values read(std::string_view group, std::string_view dataset, std::uint64_t first,
                       std::uint64_t count) const override {
    // If the file were real and these checks failed, the archive reader would end the program.
    const archive::Group* found = archive::find_group(*this, group);
    const archive::DatasetSpec* spec =
        found == nullptr ? nullptr : archive::find_dataset(*found, dataset);
    EXPECT_TRUE(spec != nullptr && first + count <= archive::element_count(*spec))
        << group << "/" << dataset;
    return whole_.read(group, dataset, first, count);
  }

 private:
  archive::MemoryArchive whole_;
  std::vector<archive::Group> groups_;
};

TEST_F(AnswersTest, AnArchiveThatLacksSomethingIsRefusedInWords) {
  // Goal: the server reads only existing data, so a foreign file never crashes it. Method: remove
  // or shorten one column of draws or of the prior. Some of these archives must be refused. If an
  // archive isn't refused, the server must answer each plot that it offers, and must not offer the
  // damaged column's plot.
  int refused = 0;
  int answered = 0;
  for (const std::string_view group : {archive::k_sample_stats, archive::k_sample_stats_prior}) {
    for (const std::string_view dataset : {"lp", "log_prior", "landing_m", "accepted", "lineage"}) {
      for (const bool is_missing : {true, false}) {
        if (archive::find_dataset(*archive::find_group(made_up(1), group), dataset) == nullptr)
          continue;
        const Damage damage{.group = group, .dataset = dataset, .is_missing = is_missing};
        const std::string words = fmt::format("{}-{}-{}", group.substr(1), dataset, is_missing);
        std::ofstream(path(words + ".h5")) << words;
        Gallery shown({.paths = {path(words + ".h5")},
                       .look_every_s = 0.01,
                       .open = [&](const std::string&) -> std::unique_ptr<archive::Source> {
                         return std::make_unique<Damaged>(made_up(101, 3), damage);
                       }});
        const Answers all(shown, notes, rules, "1.2");
        for (int i = 0; i < 2000 && shown.state()["archives"][0]["state"] == "reading"; ++i)
          std::this_thread::sleep_for(std::chrono::milliseconds(5));
        if (shown.snapshot(0) == nullptr) {
          EXPECT_EQ(shown.state()["archives"][0]["state"], "damaged") << words;
          ++refused;
          continue;
        }
        ++answered;
        const web::Answer list = all({.path = "/api/archives/0/series"});
        ASSERT_EQ(list.status, 200U) << words;
        const Json titles = Json::parse(list.content.text());
        for (const Json& title : titles.elements()) {
          const std::string name = title["name"].get<std::string>();
          EXPECT_NE(name, fmt::format("pair.{}", dataset)) << words;
          if (name == "diagnosis") continue;
          EXPECT_EQ(all({.path = "/api/archives/0/series/" + name}).status, 200U)
              << words << " " << name;
        }
      }
    }
  }
  EXPECT_GT(refused, 0);
  EXPECT_GT(answered, 0);
}

}  // namespace
}  // namespace sleight::gallery
