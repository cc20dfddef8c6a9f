// Goal: a saved gallery holds what a server would answer, nothing else, and is there as a whole or
// not at all. Method: the made-up world's archive, saved; each file against the answer; other
// things in its place; work that is broken off.
#include "clients/gallery_server/saved_gallery.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "clients/gallery_server/archive_answers.h"
#include "clients/gallery_server/base64.h"
#include "clients/gallery_server/index_columns.h"
#include "common/base/error.h"
#include "tests/unit/clients/gallery_server/shown_files.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::gallery {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

TEST(Base64, IsThatOfTheStandard) {
  // Goal: the text is what browsers take apart. Method: the test vectors of RFC 4648, section 10,
  // and all digits.
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xff\xef\xbe"), "/+++");
}

std::string text_of_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file.good()) << path;
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The three texts of sleightSaved("path", "kind", "text").
Json call_of(const fs::path& path) {
  const std::string script = text_of_file(path);
  const std::string begin = "sleightSaved(";
  EXPECT_EQ(script.substr(0, begin.size()), begin);
  EXPECT_EQ(script.substr(script.size() - 3), ");\n");
  return Json::parse("[" + script.substr(begin.size(), script.size() - begin.size() - 3) + "]");
}

std::string unzipped(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string packed;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6U | static_cast<std::uint32_t>(digits.find(c));
    if ((count += 6) < 8) continue;
    packed += static_cast<char>(bits >> static_cast<unsigned>(count -= 8));
  }
  z_stream stream{};
  EXPECT_EQ(inflateInit2(&stream, 15 + 16), Z_OK);
  std::string plain(16U << 20U, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(plain.data());
  stream.avail_out = static_cast<uInt>(plain.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  plain.resize(stream.total_out);
  inflateEnd(&stream);
  return plain;
}

class SavedGallery : public archive::testing::Scratch {
 protected:
  void SetUp() override {
    ::setenv("XDG_CACHE_HOME", path("cache").c_str(), 1);
    fs::create_directories(path("page"));
    for (const char* name : {"index.html", "app.js", "app.css"})
      std::ofstream(path(std::string("page/") + name)) << name;
    files.put(path("a.h5"), testing::made_up(101, 3));
    snapshot =
        std::make_shared<const Snapshot>(path("a.h5"), Snapshot::Options{.open = files.opener()});
  }
  void TearDown() override { ::unsetenv("XDG_CACHE_HOME"); }

  SaveOptions options(const std::string& folder) const {
    return {.folder = path(folder), .page = path("page"), .version = "1.2"};
  }
  std::uint64_t save(const SaveOptions& how) const {
    return save_gallery({{.name = "</script>\"\\.h5", .snapshot = snapshot}}, how, rules);
  }

  testing::ShownFiles files;
  // No plot of the made-up world is judged but by the diagnosis.
  cli::Rules rules{
      .draws_min = 4,
      .ess_wanted = [](std::size_t) { return 400.0; },
      .judge = [](std::string_view, const cli::ScalarDraws&) { return cli::Verdict(); }};
  std::shared_ptr<const Snapshot> snapshot;
};

TEST_F(SavedGallery, HoldsWhatAServerAnswers) {
  // Goal: files are the answers. Method: each kind, taken apart; all animations are in some file.
  const std::uint64_t bytes = save(options("saved"));
  std::uint64_t found = 0;
  for (const auto& item : fs::recursive_directory_iterator(path("saved"))) {
    if (item.is_regular_file()) found += item.file_size();
  }
  EXPECT_EQ(bytes, found);
  EXPECT_EQ(text_of_file(path("saved/app.js")), "app.js");

  const Json gallery = call_of(path("saved/data/gallery.js"));
  EXPECT_EQ(gallery[0], "gallery");
  EXPECT_EQ(gallery[1], "json");
  const Json state = Json::parse(gallery[2].get<std::string>());
  EXPECT_EQ(state["archives"][0]["name"], "</script>\"\\.h5");
  EXPECT_EQ(state["archives"][0]["finds"], 3);

  const Json table_call = call_of(path("saved/data/0/table.js"));
  EXPECT_EQ(table_call[1], "gz");
  EXPECT_EQ(unzipped(table_call[2].get<std::string>()), table(*snapshot));
  EXPECT_EQ(unzipped(call_of(path("saved/data/0/index.js"))[2].get<std::string>()),
            index_columns(snapshot->index(), snapshot->generation(), snapshot->satisfied_draws()));
  EXPECT_EQ(Json::parse(call_of(path("saved/data/0/scene.js"))[2].get<std::string>()),
            Json(scene_json(*snapshot)));

  std::vector<std::string> names;
  for (std::size_t i = 0;
       i < std::min<std::size_t>(k_animations_at_once, snapshot->index().entries.size()); ++i)
    names.push_back(browse::short_text(snapshot->index().entries[i].name));
  EXPECT_EQ(unzipped(call_of(path("saved/data/0/animations-0.js"))[2].get<std::string>()),
            several_animations(*snapshot, names));
  EXPECT_TRUE(fs::exists(path("saved/data/0/series-trace.lp-0.js")));
}

TEST_F(SavedGallery, TakesNothingElsesPlace) {
  // Goal: only a saved gallery, or nothing, is replaced. Method: a folder with a file; a file; an
  // empty folder; a gallery; a name with a slash behind it.
  fs::create_directories(path("mine"));
  std::ofstream(path("mine/letter.txt")) << "dear";
  EXPECT_THROW(save(options("mine")), base::Error);
  EXPECT_TRUE(fs::exists(path("mine/letter.txt")));
  std::ofstream(path("file")) << "a file";
  EXPECT_THROW(save(options("file")), base::Error);
  fs::create_directories(path("empty"));
  save(options("empty"));
  save(options("empty"));
  save(options("empty/"));
  EXPECT_TRUE(fs::exists(path("empty/data/gallery.js")));
}

TEST_F(SavedGallery, IsThereAsAWholeOrNotAtAll) {
  // Goal: work that is broken off leaves nothing, and an earlier gallery as it was. Method: a
  // progress that throws in the middle.
  save(options("saved"));
  std::ofstream(path("saved/data/mark")) << "the first";
  SaveOptions broken = options("saved");
  broken.progress = [](std::size_t done, std::size_t of) {
    if (2 * done > of) throw base::Error(base::ExitCode::interrupted, "interrupted");
  };
  EXPECT_THROW(save(broken), base::Error);
  EXPECT_TRUE(fs::exists(path("saved/data/mark")));
  broken.folder = path("other");
  EXPECT_THROW(save(broken), base::Error);
  for (const auto& item : fs::directory_iterator(path(".")))
    EXPECT_THAT(item.path().filename().string(), ::testing::Not(::testing::HasSubstr("other")));
}

}  // namespace
}  // namespace sleight::gallery
