// Goal: the server reads the files of a page's folder once, gives each file its content type, and
// reads nothing outside the folder. Method: read folders that contain links, pipes and odd names.
// Decompress the compressed files and compare them with the originals.
#include "clients/web/static_files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "common/base/error.h"

namespace sleight::web {
namespace {

namespace fs = std::filesystem;

class Page : public ::testing::Test {
 protected:
  Page() { write("index.html", "<!doctype html>"); }
  ~Page() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  StaticFiles read() const { return StaticFiles(folder_.string()); }
  std::string failure() const {
    try {
      read();
      return "";
    } catch (const base::Error& error) {
      return error.what();
    }
  }

  fs::path folder_ = fs::path(::testing::TempDir()) /
                     ("page." + std::to_string(::getpid()) + "." +
                      ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

std::string field_of(const Answer& answer, const std::string& name) {
  for (const Field& field : answer.fields)
    if (field.name == name) return field.value;
  return "";
}

std::string unpacked(std::string_view packed, std::size_t size) {
  std::string text(size + 1, '\0');
  z_stream stream{};
  EXPECT_EQ(inflateInit2(&stream, 15 + 16), Z_OK);
  std::string bytes(packed);
  stream.next_in = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(text.data());
  stream.avail_out = static_cast<uInt>(text.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  text.resize(stream.total_out);
  inflateEnd(&stream);
  return text;
}

TEST_F(Page, IsFoundByItsNames) {
  write("assets/index-DkX3_9aQ.js", "let a = 1;");
  write("style.css", "a {}");
  const StaticFiles files = read();
  EXPECT_EQ(files.count(), 3U);
  const auto index = files.find("/", false);
  ASSERT_TRUE(index);
  EXPECT_EQ(index->content.text(), "<!doctype html>");
  EXPECT_EQ(index->type, "text/html; charset=utf-8");
  EXPECT_EQ(index->cache, Cache::no_store);
  EXPECT_EQ(index->etag, files.find("/index.html", false)->etag);
  const auto script = files.find("/assets/index-DkX3_9aQ.js", false);
  ASSERT_TRUE(script);
  EXPECT_EQ(script->type, "text/javascript; charset=utf-8");
  EXPECT_EQ(script->cache, Cache::immutable);
  EXPECT_NE(script->etag, index->etag);
  for (const std::string path :
       {"", "index.html", "/assets", "/assets/", "//index.html", "/INDEX.html", "/index.html/",
        "/./index.html", "/assets/../index.html"}) {
    EXPECT_FALSE(files.find(path, false)) << path;
  }
}

TEST_F(Page, IsReadOnce) {
  const StaticFiles files = read();
  write("index.html", "another");
  write("new.js", "");
  EXPECT_EQ(files.find("/", false)->content.text(), "<!doctype html>");
  EXPECT_FALSE(files.find("/new.js", false));
}

TEST_F(Page, IsCompressedWhereThatHelps) {
  std::string text;
  for (int i = 0; i < 1000; ++i)
    text += "const number" + std::to_string(i) + " = 1;\n";
  write("long.js", text);
  write("long.png", text);
  write("short.js", "a");
  const StaticFiles files = read();
  const auto plain = files.find("/long.js", false);
  EXPECT_EQ(plain->content.text(), text);
  EXPECT_EQ(field_of(*plain, "Content-Encoding"), "");
  EXPECT_EQ(field_of(*plain, "Vary"), "Accept-Encoding");
  const auto packed = files.find("/long.js", true);
  EXPECT_EQ(field_of(*packed, "Content-Encoding"), "gzip");
  EXPECT_EQ(field_of(*packed, "Vary"), "Accept-Encoding");
  EXPECT_LT(packed->content.text().size(), text.size() / 4);
  EXPECT_NE(packed->etag, plain->etag);
  EXPECT_EQ(unpacked(packed->content.text(), text.size()), text);
  for (const std::string path : {"/long.png", "/short.js"}) {
    EXPECT_EQ(field_of(*files.find(path, true), "Content-Encoding"), "") << path;
    EXPECT_EQ(field_of(*files.find(path, true), "Vary"), "") << path;
  }
}

TEST_F(Page, LeavesOutWhatHasNoType) {
  write(".hidden.js", "");
  write(".git/config.js", "");
  write("notes.txt", "");
  write("index.js.map", "");
  write("empty.js", "");
  EXPECT_EQ(read().count(), 2U);
  EXPECT_TRUE(read().find("/empty.js", true));
}

TEST_F(Page, HoldsNoLinks) {
  fs::create_symlink("/etc/passwd", folder_ / "passwd.js");
  EXPECT_NE(failure().find("passwd.js: is a link"), std::string::npos) << failure();
  fs::remove(folder_ / "passwd.js");
  fs::create_directory_symlink("/etc", folder_ / "assets");
  EXPECT_NE(failure().find("assets: is a link"), std::string::npos) << failure();
  fs::remove(folder_ / "assets");
  fs::create_symlink("index.html", folder_ / "other.html");
  EXPECT_NE(failure().find("is a link"), std::string::npos);
  fs::remove(folder_ / "other.html");
  EXPECT_EQ(failure(), "");
}

TEST_F(Page, HoldsNoPipes) {
  ASSERT_EQ(::mkfifo((folder_ / "pipe.js").c_str(), 0600), 0);
  EXPECT_NE(failure().find("pipe.js: is neither"), std::string::npos) << failure();
}

TEST_F(Page, HasBounds) {
  std::string deep;
  for (int i = 0; i <= k_static_depth_max; ++i)
    deep += "a/";
  write(deep + "a.js", "");
  EXPECT_NE(failure().find("too deep"), std::string::npos);
  fs::remove_all(folder_ / "a");
  for (std::size_t i = 0; i < k_static_files_max; ++i)
    write(std::to_string(i) + ".txt", "");
  EXPECT_NE(failure().find("more than"), std::string::npos);
}

TEST_F(Page, SparseFilesAreBounded) {
  write("large.js", "");
  fs::resize_file(folder_ / "large.js", k_static_bytes_max + 1);
  EXPECT_NE(failure().find("more than"), std::string::npos);
}

TEST_F(Page, NeedsAnIndex) {
  fs::remove(folder_ / "index.html");
  EXPECT_NE(failure().find("no index.html"), std::string::npos);
  fs::remove_all(folder_);
  EXPECT_NE(failure(), "");
}

TEST(Names, TellHashes) {
  EXPECT_TRUE(has_hash("index-DkX3_9aQ.js"));
  EXPECT_TRUE(has_hash("index.abcdef12.css"));
  EXPECT_TRUE(has_hash("index-B-x3kf9a.js"));
  EXPECT_FALSE(has_hash("index.html"));
  EXPECT_FALSE(has_hash("three-renderer.js"));
  EXPECT_FALSE(has_hash("DkX3_9aQ.js"));
  EXPECT_FALSE(has_hash("-DkX3_9aQ.js"));
  EXPECT_FALSE(has_hash("index-DkX3.9aQ.js"));
  EXPECT_FALSE(has_hash("index_DkX3_9aQ.js"));
}

}  // namespace
}  // namespace sleight::web
