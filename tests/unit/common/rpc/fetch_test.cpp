// Goal: whatever fails during a fetch, the destination has a complete file or no new file.
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/hash/sha256.h"
#include "common/rpc/client.h"
#include "common/rpc/link.h"
#include "common/rpc/part_file.h"
#include "tests/unit/common/rpc/fake_service.h"

namespace sleight::rpc {
namespace {

using testing::content_of;
using testing::FakeService;
using testing::ServerProcess;
using testing::ServerThread;

std::string read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::string> names_in(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

class FetchTest : public testing::SocketFolder {
 protected:
  FetchTest() {
    service.jobs[1].view.id = {1};
    std::filesystem::create_directory(path("out"));
  }
  FakeService service;
  const FetchAsk archive = {.job = {1}, .kind = FetchKind::archive};
};

TEST_F(FetchTest, BringsAFileOfAnySize) {
  // Goal: a fetched file equals the original, replaces an older file, and leaves no other file.
  // Method: fetch files whose sizes are near the size of a piece.
  ServerThread server(socket(), service);
  Client client(socket());
  const std::string to = path("out/ball.h5");
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, k_piece_bytes_max - 1, k_piece_bytes_max,
        k_piece_bytes_max + 1, 5 * k_piece_bytes_max + 17}) {
    const std::string content = content_of(size, size + 1);
    server.on_loop([&](Server&) { service.add_file("ball.h5", content); });
    std::uint64_t seen = 0;
    const FetchedFiles fetched =
        client.fetch_file(archive, to, [&](const FileView& file, std::uint64_t bytes) {
          EXPECT_EQ(file.size, size);
          EXPECT_GE(bytes, seen);
          seen = bytes;
          return true;
        });
    EXPECT_EQ(fetched.how, Waited::settled);
    EXPECT_EQ(fetched.paths, std::vector<std::string>{to});
    EXPECT_EQ(seen, size);
    EXPECT_TRUE(read(to) == content);
    EXPECT_EQ(names_in(path("out")), std::vector<std::string>{"ball.h5"});
  }
  EXPECT_THROW(client.fetch_file({.job = {7}}, to), RefusedError);
}

TEST_F(FetchTest, GoesOnWhereItStopped) {
  // Goal: a stopped fetch continues its partial file if the content is still the same. Otherwise
  // the fetch starts from scratch and removes the partial file. Method: stop a fetch in the middle.
  // Then fetch the same content. Then stop a fetch and fetch other content.
  const std::size_t size = 4 * k_piece_bytes_max;
  const std::string first = content_of(size, 1);
  const std::string second = content_of(size, 2);
  service.add_file("ball.h5", first);
  ServerThread server(socket(), service);
  Client client(socket());
  const std::string to = path("out/ball.h5");
  const auto stop_in_the_middle = [&](const FileView&, std::uint64_t bytes) {
    return bytes < 2 * k_piece_bytes_max;
  };
  const auto first_bytes = [&] {
    std::uint64_t begins = size + 1;
    EXPECT_EQ(client
                  .fetch_file(archive, to,
                              [&](const FileView&, std::uint64_t bytes) {
                                begins = std::min(begins, bytes);
                                return true;
                              })
                  .how,
              Waited::settled);
    return begins;
  };
  EXPECT_EQ(client.fetch_file(archive, to, stop_in_the_middle).how, Waited::stopped);
  EXPECT_FALSE(std::filesystem::exists(to));
  EXPECT_EQ(first_bytes(), 2 * k_piece_bytes_max);
  EXPECT_TRUE(read(to) == first);

  EXPECT_EQ(client.fetch_file(archive, to, stop_in_the_middle).how, Waited::stopped);
  server.on_loop([&](Server&) { service.add_file("ball.h5", second); });
  EXPECT_EQ(first_bytes(), 0U);
  EXPECT_TRUE(read(to) == second);
  EXPECT_EQ(names_in(path("out")), std::vector<std::string>{"ball.h5"});
}

TEST_F(FetchTest, GoesOnOverKilledServers) {
  // Goal: if servers are killed during a fetch, bytes that have arrived are not fetched again.
  // Method: kill the server after every three pieces, and check that the number of bytes never
  // decreases.
  const std::size_t size = 9 * k_piece_bytes_max + 5;
  const auto shared = testing::make_shared_memory();
  auto server = std::make_unique<ServerProcess>(socket(), *shared, size);
  Client client(socket(), {.first_wait_s = 0.002, .wait_s_max = 0.02});
  std::uint64_t last = 0;
  int kills = 0;
  const FetchedFiles fetched =
      client.fetch_file(archive, path("out/x.h5"), [&](const FileView&, std::uint64_t bytes) {
        EXPECT_GE(bytes, last);
        last = bytes;
        if (bytes / (3 * k_piece_bytes_max) > static_cast<std::uint64_t>(kills)) {
          ++kills;
          server = nullptr;
          server = std::make_unique<ServerProcess>(socket(), *shared, size);
        }
        return true;
      });
  EXPECT_EQ(fetched.how, Waited::settled);
  EXPECT_GE(kills, 3);
  EXPECT_TRUE(read(path("out/x.h5")) == content_of(size, 1));
}

TEST_F(FetchTest, ContentThatIsNotWhatWasAnnouncedIsNoFile) {
  // Goal: if a file's bytes don't match the announced digest, the file is never put in place. If a
  // partial file is damaged, it is fetched again. Method: damage a partial file, announce a wrong
  // digest, and announce an invalid digest.
  const std::string content = content_of(3 * k_piece_bytes_max, 3);
  service.add_file("ball.h5", content);
  ServerThread server(socket(), service);
  Client client(socket());
  const std::string to = path("out/ball.h5");
  {
    PartFile part(to,
                  {.name = "ball.h5", .size = content.size(), .sha256 = hash::sha256_hex(content)});
    part.append(base::Bytes(k_piece_bytes_max, std::byte{7}));
  }
  EXPECT_EQ(client.fetch_file(archive, to).how, Waited::settled);
  EXPECT_TRUE(read(to) == content);

  server.on_loop([&](Server&) { service.files["ball.h5"].sha256 = std::string(64, 'a'); });
  EXPECT_THROW(client.fetch_file(archive, to), base::Error);
  EXPECT_TRUE(read(to) == content);
  server.on_loop([&](Server&) { service.files["ball.h5"].sha256 = "../../x"; });
  EXPECT_THROW(client.fetch_file(archive, to), RefusedError);
  EXPECT_EQ(names_in(path("out")), std::vector<std::string>{"ball.h5"});
}

TEST_F(FetchTest, KeepsAFileThatCameMeanwhile) {
  // Goal: if another program creates a file at the destination during a fetch, the file is replaced
  // only if that is allowed. A file with the same content is not a conflict. Method: create the
  // file when the last piece arrives.
  const std::string content = content_of(2 * k_piece_bytes_max, 3);
  service.add_file("ball.h5", content);
  const ServerThread server(socket(), service);
  Client client(socket());
  const std::string to = path("out/ball.h5");
  const auto fetch = [&](const std::string& meanwhile, AtItsPlace other) {
    std::filesystem::remove(to);
    return client.fetch_file(
        archive, to,
        [&](const FileView& file, std::uint64_t bytes) {
          if (bytes == file.size) std::ofstream(to, std::ios::binary) << meanwhile;
          return true;
        },
        {}, other);
  };
  EXPECT_THROW(fetch("other", AtItsPlace::kept), base::Error);
  EXPECT_EQ(read(to), "other");
  EXPECT_EQ(names_in(path("out")), std::vector<std::string>{"ball.h5"});
  EXPECT_EQ(fetch(content, AtItsPlace::kept).how, Waited::settled);
  EXPECT_EQ(fetch("other", AtItsPlace::replaced).how, Waited::settled);
  EXPECT_TRUE(read(to) == content);
  EXPECT_EQ(names_in(path("out")), std::vector<std::string>{"ball.h5"});
}

TEST_F(FetchTest, BringsManyFilesByPages) {
  // Goal: one call fetches several files into a folder, page by page. If a file's name leads out of
  // the folder, it is refused. Method: fetch 20 files in pages of 7. Then add a file whose name is
  // hostile.
  for (int i = 10; i < 30; ++i)
    service.add_file(fmt::format("failure-{}.bin", i), content_of(1000, static_cast<unsigned>(i)));
  service.files_in_page = 7;
  ServerThread server(socket(), service);
  Client client(socket());
  const FetchedFiles fetched =
      client.fetch_folder({.job = {1}, .kind = FetchKind::failure_files}, path("out/failures"));
  EXPECT_EQ(fetched.paths.size(), 20U);
  EXPECT_EQ(names_in(path("out/failures")).size(), 20U);
  EXPECT_TRUE(read(path("out/failures/failure-29.bin")) == content_of(1000, 29));
  server.on_loop([&](Server&) { service.add_file("../z", "z"); });
  EXPECT_THROW(client.fetch_folder({.job = {1}, .kind = FetchKind::failure_files}, path("out/f")),
               RefusedError);
  EXPECT_FALSE(std::filesystem::exists(path("out/z")));
}

TEST_F(FetchTest, ADiskThatFailsLeavesNoHalfFile) {
  // Goal: if a write fails, it is reported, and no file is left at the destination. A later fetch
  // succeeds. Method: limit the size of files in a separate process, as on a full disk. Then fetch
  // without the limit.
  const std::string content = content_of(3 * k_piece_bytes_max, 4);
  service.add_file("ball.h5", content);
  ServerThread server(socket(), service);
  const std::string to = path("out/ball.h5");
  // The server's thread may hold a lock during a fork, so start the death test as a new program.
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto fetch_with_little_room = [&] {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {.rlim_cur = 2'000'000, .rlim_max = 2'000'000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    try {
      Client(socket()).fetch_file(archive, to);
    } catch (const base::Error& error) {
      if (std::filesystem::exists(to)) ::_exit(19);
      ::_exit(std::string(error.what()).find("can't write") == 0 ? 17 : 18);
    }
    ::_exit(0);
  };
  EXPECT_EXIT(fetch_with_little_room(), ::testing::ExitedWithCode(17), "");
  Client client(socket());
  EXPECT_EQ(client.fetch_file(archive, to).how, Waited::settled);
  EXPECT_TRUE(read(to) == content);
}

TEST_F(FetchTest, FilesOfTheDiskAreHeldOpen) {
  // Goal: if a file is replaced during a fetch, the client gets the old content. A read beyond the
  // file's end is refused. Method: open a file, then rename another file over it.
  std::ofstream(path("a"), std::ios::binary) << "old content";
  const auto source = open_source(path("a"), "a.h5", "digest");
  std::ofstream(path("b"), std::ios::binary) << "new";
  std::filesystem::rename(path("b"), path("a"));
  EXPECT_EQ(source->view(), (FileView{.name = "a.h5", .size = 11, .sha256 = "digest"}));
  std::string piece;
  source->read(4, 7, Reply<base::Bytes>([&](Reply<base::Bytes>::Answer answer) {
                 for (const std::byte byte : answer.value())
                   piece += static_cast<char>(byte);
               }));
  EXPECT_EQ(piece, "content");
  EXPECT_THROW(open_source(path("nowhere"), "x", "y"), base::Error);
  std::filesystem::resize_file(path("a"), 1);
  const auto torn = open_source(path("a"), "a", "d");
  bool is_refused = false;
  torn->read(0, 2, Reply<base::Bytes>([&](Reply<base::Bytes>::Answer answer) {
               is_refused = !answer.ok();
             }));
  EXPECT_TRUE(is_refused);
}

/// A link to a server that is killed during the first call. The second call finds no server. The
/// third call works.
class CutLink final : public Link {
 public:
  std::vector<ArrivedBatch> watch(const std::vector<WatchPoint>&) override { return {}; }
  ArrivedFiles fetch(const FetchAsk&) override {
    ++calls;
    if (calls == 1 && !is_never_there) throw Lost("cut");
    if (calls <= 2) throw NoServer("away");
    return {
        .files = {{.name = "a.h5", .size = content.size(), .sha256 = hash::sha256_hex(content)}}};
  }
  base::Bytes read(std::size_t, std::uint64_t offset, std::uint32_t bytes) override {
    const auto* first = reinterpret_cast<const std::byte*>(content.data()) + offset;
    return {first, first + bytes};
  }
  void pause(double seconds) override { now += seconds; }
  double now_s() const override { return now; }

  const std::string content = "content";
  bool is_never_there = false;
  int calls = 0;
  double now = 0;
};

TEST_F(FetchTest, AFirstCallThatIsCutIsRepeated) {
  // Goal: if the daemon is killed during a fetch's first call, the client waits for it. If no
  // daemon ever ran, the client doesn't wait. Method: use two links. One link loses its first call;
  // the other link finds no server.
  CutLink cut;
  EXPECT_EQ(fetch_file_over(cut, {}, archive, path("out/a.h5"), {}, {}, AtItsPlace::replaced).how,
            Waited::settled);
  EXPECT_EQ(cut.calls, 3);
  EXPECT_EQ(read(path("out/a.h5")), cut.content);
  CutLink nobody;
  nobody.is_never_there = true;
  EXPECT_THROW(fetch_file_over(nobody, {}, archive, path("out/b.h5"), {}, {}, AtItsPlace::replaced),
               NoServer);
}

}  // namespace
}  // namespace sleight::rpc
