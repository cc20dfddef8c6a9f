// Goal: a saved gallery contains exactly the server's answers, and is complete or absent. Method:
// save an archive of the made-up world, and compare each file with the answer. Put other files in
// the gallery's place. Interrupt saves.
#include "clients/gallery_server/saved_gallery.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <zlib.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "clients/gallery_server/archive_answers.h"
#include "clients/gallery_server/index_columns.h"
#include "clients/gallery_server/named_archives.h"
#include "common/base/descriptor.h"
#include "common/base/error.h"
#include "common/json/value.h"
#include "tests/unit/clients/gallery_server/shown_files.h"
#include "tests/unit/common/archive/hdf5/scratch.h"

namespace sleight::gallery {
namespace {

namespace fs = std::filesystem;
using Json = json::Value;

TEST(Base64, IsThatOfTheStandard) {
  // Goal: base64 texts follow the standard that browsers decode. Method: encode the test vectors of
  // RFC 4648, section 10. Encode bytes that give the digits + and /.
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

/// Returns the three arguments of the call sleightSaved("path", "kind", "text") in a file.
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
  // Only the diagnosis calls `judge`.
  analysis::Rules rules{
      .draws_min = 4,
      .ess_wanted = [](std::size_t) { return 400.0; },
      .judge = [](std::string_view, const analysis::ScalarDraws&) { return analysis::Verdict(); }};
  std::shared_ptr<const Snapshot> snapshot;
};

TEST_F(SavedGallery, HoldsWhatAServerAnswers) {
  // Goal: saved files contain the server's answers. Method: decode a file of each kind, and compare
  // its content with the answer.
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

/// Returns the exit code and the message of the error that `work` throws. If it throws nothing, the
/// code is `ok`.
template <typename Work>
std::pair<base::ExitCode, std::string> refusal_of(const Work& work) {
  try {
    work();
  } catch (const base::Error& error) {
    return {error.exit_code(), error.what()};
  }
  return {base::ExitCode::ok, ""};
}

std::map<std::string, std::string> files_in(const fs::path& folder) {
  std::map<std::string, std::string> found;
  for (const auto& item : fs::recursive_directory_iterator(folder)) {
    if (item.is_regular_file())
      found[item.path().lexically_relative(folder).string()] = text_of_file(item.path());
  }
  return found;
}

class Spoilt final : public archive::Source {
 public:
  Spoilt(archive::MemoryArchive whole, const bool& is_spoilt)
      : whole_(std::move(whole)), is_spoilt_(is_spoilt) {}
  std::string name() const override { return "b.h5"; }
  const std::vector<archive::Group>& groups() const override { return whole_.groups(); }
  archive::Values read(std::string_view group, std::string_view dataset, std::uint64_t first,
                       std::uint64_t count) const override {
    if (is_spoilt_) archive::refuse_archive(*this, "it is damaged");
    return whole_.read(group, dataset, first, count);
  }

 private:
  archive::MemoryArchive whole_;
  const bool& is_spoilt_;
};

TEST_F(SavedGallery, NamesTheArchiveThatCantBeRead) {
  // Goal: if one of several archives can't be read, the error names that archive, and the save
  // leaves no files behind. Method: make the second of two archives unreadable after it was opened.
  files.put(path("b.h5"), testing::made_up(102, 3));
  bool is_spoilt = false;
  const auto second = std::make_shared<const Snapshot>(
      path("b.h5"), Snapshot::Options{.open = [&](const std::string&) {
        return std::make_unique<Spoilt>(testing::made_up(102, 3), is_spoilt);
      }});
  is_spoilt = true;
  try {
    save_gallery({{.name = "a", .snapshot = snapshot}, {.name = "b", .snapshot = second}},
                 options("saved"), rules);
    FAIL() << "it was saved";
  } catch (const UnreadableArchive& error) {
    EXPECT_EQ(error.number(), 1U);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("b.h5"));
  }
  EXPECT_FALSE(fs::exists(path("saved")));
}

TEST_F(SavedGallery, TakesNothingElsesPlace) {
  // Goal: a save replaces nothing except an empty folder or a saved gallery. Method: save over a
  // file, a folder with another file, an empty folder, and a saved gallery. Save to a path that
  // ends in a slash. Save to a link; the link must stay.
  fs::create_directories(path("mine"));
  std::ofstream(path("mine/letter.txt")) << "dear";
  EXPECT_EQ(refusal_of([&] { save(options("mine")); }).first, base::ExitCode::conflict);
  EXPECT_TRUE(fs::exists(path("mine/letter.txt")));
  std::ofstream(path("file")) << "a file";
  EXPECT_EQ(refusal_of([&] { save(options("file")); }).first, base::ExitCode::conflict);
  fs::create_symlink(path("nowhere"), path("link"));
  save(options("link"));
  save(options("link/"));
  EXPECT_EQ(fs::read_symlink(path("link")), path("nowhere"));
  fs::create_directories(path("empty"));
  save(options("empty"));
  save(options("empty"));
  save(options("empty/"));
  save(options("new/"));
  EXPECT_EQ(files_in(path("new")), files_in(path("empty")));
  EXPECT_EQ(files_in(path("nowhere")), files_in(path("empty")));
  EXPECT_EQ(fs::status(path("new")).permissions(), fs::status(path("page")).permissions());
}

TEST_F(SavedGallery, IsReplacedWhereNothingElseIsInIt) {
  // Goal: a save never deletes files that people put into a saved gallery, and the error names
  // these files. Method: save over a gallery after adding a foreign file or folder, or after
  // replacing one of its files by a link.
  const std::map<std::string, std::string> others = {{"hi.h5", "hi.h5"},
                                                     {"CNAME", "CNAME"},
                                                     {".git/HEAD", ".git"},
                                                     {"data/0/photo.js", "data/0/photo.js"},
                                                     {"data/mine/photo.jpg", "data/mine"}};
  save(options("saved"));
  for (const auto& [other, named] : others) {
    const fs::path file = fs::path(path("saved")) / other;
    fs::create_directories(file.parent_path());
    std::ofstream(file) << "mine";
    const auto before = files_in(path("saved"));
    const auto [code, words] = refusal_of([&] { save(options("saved")); });
    EXPECT_EQ(code, base::ExitCode::conflict) << other;
    EXPECT_THAT(words, ::testing::HasSubstr("contains " + named));
    EXPECT_EQ(files_in(path("saved")), before);
    fs::remove_all(fs::path(path("saved")) / named);
  }
  fs::remove(path("saved/app.css"));
  fs::create_symlink(path("page/app.css"), path("saved/app.css"));
  EXPECT_EQ(refusal_of([&] { save(options("saved")); }).first, base::ExitCode::conflict);
  fs::remove(path("saved/app.css"));
  save(options("saved"));
  EXPECT_TRUE(fs::exists(path("saved/app.css")));
}

TEST_F(SavedGallery, IsKnownByWhatItsManifestSays) {
  // Goal: the name of a file alone doesn't identify a folder as a saved gallery. Method: save over
  // a folder whose data/gallery.js is foreign. Save over a folder whose manifest is invalid, or
  // names files of other folders.
  fs::create_directories(path("photos/data"));
  std::ofstream(path("photos/data/gallery.js")) << "mine";
  EXPECT_EQ(refusal_of([&] { save(options("photos")); }).first, base::ExitCode::conflict);
  std::ofstream(path("letter")) << "dear";
  const std::string manifest = path("photos/sleight-gallery.json");
  for (const char* named : {"[]", "7", "[1]", R"(["data/gallery.js", "../letter"])",
                            R"(["data/gallery.js", "data/../../letter.js"])"}) {
    std::ofstream(manifest) << R"({"sleight_gallery": 1, "files": )" << named << "}";
    EXPECT_EQ(refusal_of([&] { save(options("photos")); }).first, base::ExitCode::conflict);
  }
  for (const char* text :
       {"", "mine", "[]", R"({"files": ["data/gallery.js", "sleight-gallery.json"]})"}) {
    std::ofstream(manifest) << text;
    EXPECT_EQ(refusal_of([&] { save(options("photos")); }).first, base::ExitCode::conflict);
  }
  EXPECT_EQ(text_of_file(path("photos/data/gallery.js")), "mine");
  EXPECT_EQ(text_of_file(path("letter")), "dear");
}

TEST_F(SavedGallery, LeavesNoFileOfTheOneBefore) {
  // Goal: the manifest names all files. If a new gallery lacks a file of the earlier gallery, the
  // file is removed. Method: save two archives, then save only one of them.
  const SavedArchive archive{.name = "a.h5", .snapshot = snapshot};
  save_gallery({archive, archive}, options("saved"), rules);
  const Json manifest = Json::parse(text_of_file(path("saved/sleight-gallery.json")));
  std::vector<std::string> names;
  for (const auto& [name, content] : files_in(path("saved")))
    names.push_back(name);
  EXPECT_EQ(manifest["files"], Json(names));
  save_gallery({archive}, options("saved"), rules);
  save_gallery({archive}, options("other"), rules);
  EXPECT_EQ(files_in(path("saved")), files_in(path("other")));
  EXPECT_FALSE(fs::exists(path("saved/data/1")));
}

TEST_F(SavedGallery, KeepsTheFolderItself) {
  // Goal: a save replaces a folder's content and keeps the folder itself. So a gallery can be saved
  // to a mount point, the current folder or a link's target. Method: save as "." and through a
  // link, and check that the folder's inode stays the same.
  save(options("saved"));
  struct stat before {};
  ASSERT_EQ(::stat(path("saved").c_str(), &before), 0);
  fs::create_directory_symlink(path("saved"), path("link"));
  const fs::path here = fs::current_path();
  fs::current_path(path("saved"));
  std::ofstream("index.html") << "the first";
  SaveOptions current = options("");
  current.folder = ".";
  const auto [code, words] = refusal_of([&] { save(current); });
  fs::current_path(here);
  EXPECT_EQ(code, base::ExitCode::ok) << words;
  EXPECT_EQ(text_of_file(path("saved/index.html")), "index.html");
  std::ofstream(path("saved/index.html")) << "the second";
  save(options("link"));
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(text_of_file(path("saved/index.html")), "index.html");
  struct stat after {};
  ASSERT_EQ(::stat(path("saved").c_str(), &after), 0);
  EXPECT_EQ(after.st_ino, before.st_ino);
}

fs::path work_in(const fs::path& folder) {
  for (const auto& item : fs::directory_iterator(folder)) {
    if (item.path().filename().string().starts_with(".sleight-saving-")) return item.path();
  }
  ADD_FAILURE() << "there is no folder to save in";
  return {};
}

TEST_F(SavedGallery, IsThereAsAWholeOrNotAtAll) {
  // Goal: an interrupted save leaves nothing but the earlier gallery. Method: save with three
  // progress callbacks. The first callback throws halfway. The second callback removes a file, so a
  // rename fails halfway. The third callback puts a file into the gallery.
  save(options("saved"));
  std::ofstream(path("saved/index.html")) << "the first";
  const auto before = files_in(path("saved"));
  SaveOptions broken = options("saved");
  broken.progress = [](std::size_t done, std::size_t of) {
    if (2 * done > of) throw base::Error(base::ExitCode::interrupted, "interrupted");
  };
  EXPECT_THROW(save(broken), base::Error);
  EXPECT_EQ(files_in(path("saved")), before);
  broken.folder = path("other");
  EXPECT_THROW(save(broken), base::Error);
  for (const auto& item : fs::directory_iterator(path(".")))
    EXPECT_THAT(item.path().filename().string(), ::testing::Not(::testing::HasSubstr("other")));

  SaveOptions spoiled = options("saved");
  spoiled.progress = [this](std::size_t, std::size_t) {
    fs::remove(work_in(path("saved")) / "new/index.html");
  };
  EXPECT_EQ(refusal_of([&] { save(spoiled); }).first, base::ExitCode::environment);
  EXPECT_EQ(files_in(path("saved")), before);
  EXPECT_EQ(std::distance(fs::directory_iterator(path("saved")), {}), 5);

  SaveOptions disturbed = options("saved");
  disturbed.progress = [this](std::size_t, std::size_t) {
    std::ofstream(path("saved/letter.txt")) << "dear";
  };
  EXPECT_EQ(refusal_of([&] { save(disturbed); }).first, base::ExitCode::conflict);
  EXPECT_EQ(text_of_file(path("saved/letter.txt")), "dear");
  EXPECT_EQ(text_of_file(path("saved/index.html")), "the first");
}

TEST(NamedArchives, AbandonedFoldersAreRemoved) {
  // Goal: a killed gallery's temporary folder is removed, and a running gallery's stays. Method:
  // make two folders whose names are those of temporary folders, and lock the second. Add folders,
  // a file and a link that must stay.
  std::string form = (fs::temp_directory_path() / "sleight-test-XXXXXX").string();
  const fs::path temporary = ::mkdtemp(form.data());
  for (const char* name : {"sleight-gallery-aaaaaa", "sleight-gallery-bbbbbb", "sleight-gallery-c",
                           "sleight-gallery-longer1", "other-gallery-dddddd"}) {
    fs::create_directories(temporary / name);
    std::ofstream(temporary / name / "job-1.h5") << "an archive";
  }
  std::ofstream(temporary / "sleight-gallery-eeeeee") << "a file";
  fs::create_directory_symlink(temporary / "sleight-gallery-c",
                               temporary / "sleight-gallery-ffffff");
  const base::Descriptor held(
      ::open((temporary / "sleight-gallery-bbbbbb").c_str(), O_RDONLY | O_DIRECTORY));
  ASSERT_EQ(::flock(held.get(), LOCK_EX), 0);
  remove_abandoned_folders(temporary.string());
  std::set<std::string> left;
  for (const auto& item : fs::directory_iterator(temporary))
    left.insert(item.path().filename().string());
  EXPECT_THAT(left,
              ::testing::UnorderedElementsAre("sleight-gallery-bbbbbb", "sleight-gallery-c",
                                              "sleight-gallery-longer1", "other-gallery-dddddd",
                                              "sleight-gallery-eeeeee", "sleight-gallery-ffffff"));
  EXPECT_TRUE(fs::exists(temporary / "sleight-gallery-c/job-1.h5"));
  fs::remove_all(temporary);
}

TEST(NothingToShow, IsSaidWhereNothingIsOrMayCome) {
  // Goal: the page says that there is nothing to show only if no archive is shown or being read.
  using Ordered = json::Value;
  const auto is_said = [](const std::string& archives) {
    return !gallery::nothing_to_show(
                Ordered::parse(R"({"left_out": [], "archives": [)" + archives + "]}"), {"results"})
                .empty();
  };
  const std::string bad =
      R"({"name": "a.h5", "state": "damaged", "words": "no archive", "generation": 0})";
  for (const std::string& nothing : {std::string(), bad, bad + "," + bad})
    EXPECT_TRUE(is_said(nothing)) << nothing;
  for (const char* other :
       {R"({"state": "ready", "generation": 1})", R"({"state": "reading", "generation": 0})",
        R"({"state": "damaged", "generation": 1})"})
    EXPECT_FALSE(is_said(bad + "," + other)) << other;
}

}  // namespace
}  // namespace sleight::gallery
