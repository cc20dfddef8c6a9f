#include "common/archive/remote/remote_source.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <optional>
#include <utility>

#include "common/archive/format.h"
#include "common/archive/limits.h"
#include "common/archive/read_ahead.h"
#include "common/archive/remote/contents_check.h"
#include "common/archive/remote/messages.h"
#include "common/base/check.h"
#include "common/base/descriptor.h"
#include "common/base/error.h"

namespace sleight::archive::remote {
namespace {

/// Maximum archives that open_all opens concurrently.
constexpr std::size_t k_opened_at_once = 8;

class RemoteSource final : public Source {
 public:
  /// Starts the reader. take_contents then returns whether the reader opened the archive.
  RemoteSource(const std::string& program, std::string path, const ReaderLimits& limits)
      : path_(std::move(path)), limits_(limits) {
    // Open without blocking, in case the file is a pipe or a device.
    const base::Descriptor archive(
        ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
    struct stat status {};
    if (!archive || ::fstat(archive.get(), &status) != 0)
      throw base::Error(fmt::format("{}: can't open: {}", path_, std::strerror(errno)));
    if (!S_ISREG(status.st_mode)) fail("not a regular file");
    process_.emplace(program, archive.get(), limits);
  }

  /// REQUIRES: first call, only once.
  void take_contents() {
    const AnswerHead head = receive_head();
    if (head.kind != AnswerKind::contents || head.type != 0 || head.bytes > k_contents_bytes_max)
      fail("the reader process's first message is not the list of contents");
    base::Bytes bytes(head.bytes);
    receive(bytes);
    auto groups = decode_contents(bytes);
    if (!groups) fail(groups.error());
    const std::string fault = fault_of_contents(groups.value());
    if (!fault.empty()) fail(fault);
    groups_ = std::move(groups).value();
    std::uint32_t number = 0;
    for (const Group& group : groups_) {
      for (const DatasetSpec& spec : group.datasets)
        datasets_.emplace(path_of(group.name, spec.name), Numbered{number++, &group, &spec});
    }
  }

  std::string name() const override { return path_; }
  const std::vector<Group>& groups() const override { return groups_; }

  Values read(std::string_view group, std::string_view dataset, std::uint64_t first,
              std::uint64_t count) const override {
    const auto found = datasets_.find(path_of(group, dataset));
    CHECK(found != datasets_.end());
    const Numbered& asked = found->second;
    const std::uint64_t total = element_count(*asked.spec);
    CHECK_LE(first, total);
    CHECK_LE(count, total - first);
    if (!process_) throw base::Error(failure_);
    ask({.number = ++asked_, .dataset = asked.number, .first = first, .count = count});
    const AnswerHead head = receive_head();
    if (head.kind != AnswerKind::values || head.type != static_cast<std::uint8_t>(asked.spec->type))
      fail("the reader process sent something other than the requested values");
    switch (asked.spec->type) {
      case ElementType::f64:
        return receive_numbers<double>(head, count);
      case ElementType::i64:
        return receive_numbers<std::int64_t>(head, count);
      case ElementType::i32:
        return receive_numbers<std::int32_t>(head, count);
      case ElementType::boolean:
        return receive_numbers<std::int8_t>(head, count);
      case ElementType::text:
        return receive_texts(head, asked, count);
    }
    base::check_failed("the element type is known", found->first);
  }

 private:
  struct Numbered {
    std::uint32_t number = 0;
    const Group* group = nullptr;
    const DatasetSpec* spec = nullptr;
  };

  [[noreturn]] void fail(std::string_view reason,
                         base::ExitCode code = base::ExitCode::bad_archive) const {
    process_.reset();
    failure_ = base::Error(code, fmt::format("{}: {}", path_, reason));
    throw base::Error(failure_);
  }

  /// Throws if this process's memory limit is below a reader's. The reader inherits the lower
  /// limit. The file may then not be the cause of the failure.
  void fail_for_want_of_memory() const {
    rlimit limit{};
    if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_max >= limits_.address_space_bytes)
      return;
    fail(fmt::format(
             "too little memory to read the archive; this process is limited to {} MB (ulimit -v)",
             limit.rlim_max / 1'000'000),
         base::ExitCode::environment);
  }

  [[noreturn]] void fail_of(Received how_far) const {
    if (how_far == Received::ended) {
      const ReaderEnd end = process_->end();
      if (end.is_abrupt) fail_for_want_of_memory();
      fail(end.words, end.exit_code);
    }
    fail(fmt::format("reading the archive takes more than {} s; the file is damaged or hostile",
                     limits_.timeout_s));
  }

  void ask(const Question& question) const {
    if (process_->has_unasked_words()) fail("the reader process sent data without a request");
    process_->renew_limits();
    if (!process_->send(encode(question))) fail_of(Received::ended);
  }

  void receive(std::span<std::byte> bytes) const {
    const Received how_far = process_->receive(bytes);
    if (how_far != Received::all) fail_of(how_far);
  }

  /// Throws if the reader refuses.
  AnswerHead receive_head() const {
    HeadBytes bytes{};
    receive(bytes);
    const AnswerHead head = decode_head(bytes);
    if (head.number != asked_ || head.nothing != 0)
      fail("the reader process answered a different request");
    if (head.kind != AnswerKind::refusal) return head;
    const bool is_of_environment = head.type == k_of_environment && asked_ == 0;
    if (head.bytes > k_refusal_bytes_max ||
        (head.type != k_of_archive && head.type != k_of_memory && !is_of_environment))
      fail("the reader process sent a malformed error message");
    std::string reason(head.bytes, '\0');
    receive(std::as_writable_bytes(std::span<char>(reason)));
    if (head.type == k_of_memory) fail_for_want_of_memory();
    throw base::Error(is_of_environment ? base::ExitCode::environment : base::ExitCode::bad_archive,
                      fmt::format("{}: {}", path_, shown_text(reason)));
  }

  template <class Number>
  std::vector<Number> receive_numbers(const AnswerHead& head, std::uint64_t count) const {
    if (head.bytes != count * sizeof(Number)) fail_count();
    std::vector<Number> values(count);
    receive(std::as_writable_bytes(std::span<Number>(values)));
    return values;
  }

  std::vector<std::string> receive_texts(const AnswerHead& head, const Numbered& asked,
                                         std::uint64_t count) const {
    // The reader sends at most this many bytes at once (hdf5/reader.h).
    const std::uint64_t bytes_max = std::min(texts_bytes_max(count, asked.spec->text_bytes),
                                             k_text_bytes_max + texts_bytes_max(count, 0));
    if (head.bytes > bytes_max) fail_count();
    base::Bytes bytes(head.bytes);
    receive(bytes);
    auto texts = decode_texts(bytes, count, asked.spec->text_bytes);
    if (!texts) fail(texts.error());
    for (const std::string& text : texts.value()) {
      if (!is_text_for(asked.group->name, asked.spec->name, text))
        fail(fmt::format("{}: the text contains control characters or is not UTF-8",
                         path_of(asked.group->name, asked.spec->name)));
    }
    return std::move(texts).value();
  }

  [[noreturn]] void fail_count() const {
    fail("the reader process sent the wrong number of values");
  }

  std::string path_;
  ReaderLimits limits_;
  std::vector<Group> groups_;
  std::map<std::string, Numbered> datasets_;      ///< by path
  mutable std::optional<ReaderProcess> process_;  ///< empty after a failure
  mutable base::Error failure_{""};
  mutable std::uint32_t asked_ = 0;  ///< number of questions sent
};

}  // namespace

std::unique_ptr<Source> open_remote_by(const std::string& program, const std::string& path,
                                       const ReaderLimits& limits) {
  auto source = std::make_unique<RemoteSource>(program, path, limits);
  source->take_contents();
  return source;
}

std::unique_ptr<Source> open_remote(const std::string& path, const ReaderLimits& limits) {
  return std::make_unique<ReadAhead>(open_remote_by(reader_beside_this_program(), path, limits));
}

std::vector<OpenedArchive> open_all_by(const std::string& program,
                                       std::span<const std::string> paths,
                                       const ReaderLimits& limits) {
  std::vector<OpenedArchive> opened;
  for (std::size_t begin = 0; begin < paths.size(); begin += k_opened_at_once) {
    // Start several readers. Then receive each archive's contents, one archive after the other.
    std::vector<std::unique_ptr<RemoteSource>> started;
    for (const std::string& path :
         paths.subspan(begin, std::min(k_opened_at_once, paths.size() - begin))) {
      OpenedArchive place{.path = path, .source = nullptr, .refused = {}};
      std::unique_ptr<RemoteSource> source;
      try {
        source = std::make_unique<RemoteSource>(program, path, limits);
      } catch (const base::Error& error) {
        place.refused = error.what();
      }
      started.push_back(std::move(source));
      opened.push_back(std::move(place));
    }
    for (std::size_t i = 0; i < started.size(); ++i) {
      if (!started[i]) continue;
      try {
        started[i]->take_contents();
        opened[begin + i].source = std::move(started[i]);
      } catch (const base::Error& error) {
        opened[begin + i].refused = error.what();
      }
    }
  }
  return opened;
}

std::vector<OpenedArchive> open_all(std::span<const std::string> paths,
                                    const ReaderLimits& limits) {
  std::vector<OpenedArchive> opened = open_all_by(reader_beside_this_program(), paths, limits);
  for (OpenedArchive& place : opened) {
    if (place.source != nullptr)
      place.source = std::make_unique<ReadAhead>(std::move(place.source));
  }
  return opened;
}

}  // namespace sleight::archive::remote
