// Implements fetching over a Link (link.h), without sockets.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>

#include "common/base/check.h"
#include "common/base/file_system.h"
#include "common/rpc/link.h"
#include "common/rpc/part_file.h"

namespace sleight::rpc {
namespace {

/// If the received bytes are wrong, a file is tried at most this often.
constexpr int k_wrong_max = 3;

constexpr std::size_t k_sha256_digits = 64;

Refusal broken_answer() {
  return {.kind = RefusalKind::bug,
          .sentence = "The server announced an invalid file.",
          .what_to_do = "See the server's log."};
}

void check_view(const FileView& view) {
  const bool is_hexadecimal =
      view.sha256.size() == k_sha256_digits &&
      view.sha256.find_first_not_of("0123456789abcdef") == std::string::npos;
  if (!is_hexadecimal || !is_file_name(view.name)) throw RefusedError(broken_answer());
}

class Fetching {
 public:
  Fetching(Link& link, const ClientOptions& options, FetchAsk ask, const FetchProgress& progress,
           const FetchCheck& check, AtItsPlace other)
      : link_(link),
        patience_(link, options),
        ask_(std::move(ask)),
        progress_(progress),
        check_(check),
        other_(other) {}

  /// `place_of` maps a file's name to its path. If `is_one`, expects exactly one file; otherwise
  /// fetches all pages of files.
  FetchedFiles run(bool is_one, const std::function<std::string(const std::string&)>& place_of) {
    try {
      while (!is_over_) {
        try {
          attempt(is_one, place_of);
        } catch (const Lost& error) {
          patience_.again(error.what());
        } catch (const NoServer& error) {
          if (!patience_.was_there()) throw;
          patience_.again(error.what());
        } catch (const RefusedError& error) {
          if (error.refusal().kind != RefusalKind::busy) throw;
          patience_.again(error.what());
        }
      }
    } catch (const Interrupted&) {
      fetched_.how = Waited::interrupted;
    }
    return std::move(fetched_);
  }

 private:
  void attempt(bool is_one, const std::function<std::string(const std::string&)>& place_of) {
    const ArrivedFiles arrived = link_.fetch(ask_);
    patience_.reset();
    if (is_one && arrived.files.size() != 1) throw RefusedError(broken_answer());
    for (std::size_t i = 0; i < arrived.files.size(); ++i) {
      const FileView& view = arrived.files[i];
      check_view(view);
      if (is_one) ask_.sha256_wanted = view.sha256;
      const std::string path = place_of(view.name);
      const std::optional<bool> is_right = take(i, view, path);
      if (!is_right) {
        fetched_.how = Waited::stopped;
        is_over_ = true;
        return;
      }
      if (!*is_right) {
        if (++wrong_ == k_wrong_max) {
          throw base::Error(
              fmt::format("{}: the received file does not match its announced checksum; the "
                          "server's disk may be damaged",
                          path));
        }
        return;  // the next attempt resumes after the last correct file
      }
      fetched_.paths.push_back(path);
      ask_.after = view.name;
    }
    is_over_ = is_one || !arrived.has_more || arrived.files.empty();
  }

  /// Receives a file. Returns whether the content matches its digest. Returns nothing if the
  /// receiver stops the fetch.
  std::optional<bool> take(std::size_t file, const FileView& view, const std::string& path) {
    PartFile part(path, view);
    while (true) {
      if (progress_ && !progress_(view, part.bytes())) return std::nullopt;
      if (part.is_whole()) return part.finish(check_, other_);
      const auto bytes = static_cast<std::uint32_t>(
          std::min<std::uint64_t>(view.size - part.bytes(), k_piece_bytes_max));
      part.append(link_.read(file, part.bytes(), bytes));
    }
  }

  Link& link_;
  Patience patience_;
  FetchAsk ask_;
  const FetchProgress& progress_;
  const FetchCheck& check_;
  AtItsPlace other_;
  FetchedFiles fetched_{};
  bool is_over_ = false;
  int wrong_ = 0;
};

}  // namespace

FetchedFiles fetch_file_over(Link& link, const ClientOptions& options, FetchAsk ask,
                             const std::string& path, const FetchProgress& progress,
                             const FetchCheck& check, AtItsPlace other) {
  return Fetching(link, options, std::move(ask), progress, check, other)
      .run(true, [&](const std::string&) { return path; });
}

FetchedFiles fetch_folder_over(Link& link, const ClientOptions& options, FetchAsk ask,
                               const std::string& folder, const FetchProgress& progress,
                               AtItsPlace other) {
  base::PosixFileSystem files;
  files.make_folder(folder);
  const FetchCheck unchecked;
  return Fetching(link, options, std::move(ask), progress, unchecked, other)
      .run(false, [&](const std::string& name) { return folder + "/" + name; });
}

}  // namespace sleight::rpc
