// Implements Source of handler.h for files on disk.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "common/base/check.h"
#include "common/base/error.h"
#include "common/rpc/handler.h"

namespace sleight::rpc {
namespace {

class FileSource final : public Source {
 public:
  FileSource(const std::string& path, std::string name, std::string sha256)
      : descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    struct stat seen = {};
    if (descriptor_ < 0 || ::fstat(descriptor_, &seen) != 0) {
      const std::string reason = std::system_category().message(errno);
      if (descriptor_ >= 0) ::close(descriptor_);
      throw base::Error(fmt::format("can't open {}: {}", path, reason));
    }
    view_ = {.name = std::move(name),
             .size = static_cast<std::uint64_t>(seen.st_size),
             .sha256 = std::move(sha256)};
  }
  ~FileSource() override { ::close(descriptor_); }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  FileView view() const override { return view_; }

  void read(std::uint64_t offset, std::size_t bytes, Reply<base::Bytes> reply) override {
    base::Bytes piece(bytes);
    std::size_t done = 0;
    while (done < bytes) {
      const auto got = ::pread(descriptor_, piece.data() + done, bytes - done,
                               static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) {
        reply.refuse({.kind = RefusalKind::environment,
                      .sentence = "The server can't read the whole file.",
                      .what_to_do = "Fetch it again."});
        return;
      }
      done += static_cast<std::size_t>(got);
    }
    reply.answer(std::move(piece));
  }

 private:
  int descriptor_;
  FileView view_;
};

}  // namespace

std::unique_ptr<Source> open_source(const std::string& path, std::string name, std::string sha256) {
  return std::make_unique<FileSource>(path, std::move(name), std::move(sha256));
}

}  // namespace sleight::rpc
