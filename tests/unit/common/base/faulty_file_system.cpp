#include "tests/unit/common/base/faulty_file_system.h"

#include <fmt/format.h>

#include <utility>

#include "common/base/error.h"

namespace sleight::base::testing {
namespace {

class FaultyFile final : public File {
 public:
  FaultyFile(const FaultyFileSystem& system, std::unique_ptr<File> real)
      : system_(system), real_(std::move(real)) {}

  std::error_code write_at(std::uint64_t offset, BytesView bytes) override {
    const std::error_code failure = system_.failure_of(FileCall::write);
    const std::error_code outcome =
        real_->write_at(offset, failure ? bytes.first(bytes.size() / 2) : bytes);
    return failure ? failure : outcome;
  }
  std::error_code read_at(std::uint64_t offset, std::span<std::byte> bytes) override {
    const std::error_code failure = system_.failure_of(FileCall::read);
    const std::error_code outcome = real_->read_at(offset, bytes);
    return failure ? failure : outcome;
  }
  std::error_code resize(std::uint64_t size) override {
    const std::error_code failure = system_.failure_of(FileCall::resize);
    return failure ? failure : real_->resize(size);
  }
  std::error_code close() override {
    const std::error_code failure = system_.failure_of(FileCall::close);
    const std::error_code outcome = real_->close();
    return failure ? failure : outcome;
  }

 private:
  const FaultyFileSystem& system_;
  std::unique_ptr<File> real_;
};

}  // namespace

std::string name_of(FileCall call) {
  constexpr const char* k_names[] = {"look",           "list",   "create", "read",
                                     "write",          "resize", "close",  "sync_file",
                                     "sync_directory", "rename", "remove", "make_folder"};
  return k_names[static_cast<std::size_t>(call)];
}

void FaultyFileSystem::fail(const Fault& fault) {
  fault_ = fault;
  calls_ = 0;
  failures_ = 0;
}

std::error_code FaultyFileSystem::failure_of(FileCall call) const {
  if (!fault_ || (fault_->call && *fault_->call != call)) return {};
  if (calls_++ < fault_->after || failures_ >= fault_->times) return {};
  ++failures_;
  return {static_cast<int>(fault_->reason), std::system_category()};
}

void FaultyFileSystem::throw_failure_of(FileCall call, const std::string& path) const {
  if (const std::error_code failure = failure_of(call)) {
    throw Error(fmt::format("{}: can't {}: {}", path, name_of(call), failure.message()));
  }
}

bool FaultyFileSystem::exists(const std::string& path) const {
  throw_failure_of(FileCall::look, path);
  return real_.exists(path);
}

bool FaultyFileSystem::is_directory(const std::string& path) const {
  throw_failure_of(FileCall::look, path);
  return real_.is_directory(path);
}

std::vector<std::string> FaultyFileSystem::names_in(const std::string& folder) const {
  throw_failure_of(FileCall::list, folder);
  return real_.names_in(folder);
}

Result<std::unique_ptr<File>, std::error_code> FaultyFileSystem::create(const std::string& path) {
  if (const std::error_code failure = failure_of(FileCall::create)) return failure;
  auto file = real_.create(path);
  if (!file) return file.error();
  return std::unique_ptr<File>(std::make_unique<FaultyFile>(*this, std::move(file).value()));
}

void FaultyFileSystem::sync_file(const std::string& path) {
  throw_failure_of(FileCall::sync_file, path);
  real_.sync_file(path);
}

void FaultyFileSystem::sync_directory_of(const std::string& path) {
  throw_failure_of(FileCall::sync_directory, path);
  real_.sync_directory_of(path);
}

void FaultyFileSystem::rename(const std::string& from, const std::string& to) {
  throw_failure_of(FileCall::rename, to);
  real_.rename(from, to);
}

void FaultyFileSystem::make_folder(const std::string& path) {
  throw_failure_of(FileCall::make_folder, path);
  real_.make_folder(path);
}

void FaultyFileSystem::remove(const std::string& path) {
  throw_failure_of(FileCall::remove, path);
  real_.remove(path);
}

}  // namespace sleight::base::testing
