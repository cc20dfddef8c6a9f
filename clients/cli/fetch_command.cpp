#include "clients/cli/fetch_command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "clients/cli/job_text.h"
#include "clients/cli/service_json.h"
#include "clients/service_client/selected_jobs.h"
#include "clients/service_client/service_call.h"
#include "clients/terminal/interruption.h"
#include "clients/terminal/output.h"
#include "clients/terminal/terminal.h"
#include "common/archive/digest/verify.h"
#include "common/archive/remote/remote_source.h"
#include "common/archive/summary.h"
#include "common/base/clock.h"
#include "common/base/error.h"
#include "common/events/progress.h"
#include "common/hash/sha256.h"

namespace sleight::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t k_read_bytes = 1U << 20U;
constexpr double k_show_every_s = 0.1;

std::optional<std::uint64_t> whole_number_of(std::string_view text) {
  std::uint64_t number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, failure] = std::from_chars(text.data(), end, number);
  return failure == std::errc() && rest == end ? std::optional(number) : std::nullopt;
}

double as_double(std::uint64_t count) {
  return static_cast<double>(count);
}

std::string sha256_of_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw base::Error(fmt::format("{}: can't read the existing file", path));
  hash::Sha256 hash;
  std::string piece(k_read_bytes, '\0');
  while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())) || file.gcount() > 0)
    hash.update(std::string_view(piece).substr(0, static_cast<std::size_t>(file.gcount())));
  return hash::to_hex(hash.finish());
}

class FetchPrinter {
 public:
  explicit FetchPrinter(bool quiet) : shows_(!quiet && line_.can_renew()) {}
  ~FetchPrinter() { clear(); }
  FetchPrinter(const FetchPrinter&) = delete;
  FetchPrinter& operator=(const FetchPrinter&) = delete;

  void show(const std::string& place, const rpc::FileView& file, std::uint64_t bytes) {
    if (!shows_) return;
    if (file.sha256 != sha256_) {
      sha256_ = file.sha256;
      first_bytes_ = bytes;
      began_s_ = clock_.now_s();
    } else if (clock_.now_s() - shown_s_ < k_show_every_s && bytes < file.size) {
      return;
    }
    shown_s_ = clock_.now_s();
    const double share = file.size == 0 ? 1 : as_double(bytes) / as_double(file.size);
    const double rate = as_double(bytes - std::min(bytes, first_bytes_)) / (shown_s_ - began_s_);
    std::string line =
        fmt::format("{}  {:.0f}% of {:.1f} MB", place, share * 100, as_double(file.size) / 1e6);
    if (rate > 0 && rate < 1e15) {
      line += fmt::format("  {:.1f} MB/s  {} left", rate / 1e6,
                          events::clock_time(as_double(file.size - bytes) / rate));
    }
    line_.show(line);
  }
  void clear() { line_.clear(); }

 private:
  terminal::RenewedLine line_{stderr};
  bool shows_;
  base::SteadyClock clock_;
  std::string sha256_;
  std::uint64_t first_bytes_ = 0;
  double began_s_ = 0;
  double shown_s_ = 0;
};

/// How a file at the destination compares with a fetched one.
enum class Standing { free, same, other };

Standing standing_of(const std::string& path, const rpc::FileView& file) {
  std::error_code none;
  if (!fs::exists(path, none)) return Standing::free;
  if (fs::is_regular_file(path, none) && fs::file_size(path, none) == file.size &&
      sha256_of_file(path) == file.sha256)
    return Standing::same;
  return Standing::other;
}

/// Whether the path is a folder or a device, which can't be replaced.
bool is_no_file(const std::string& path) {
  std::error_code none;
  const fs::file_status status = fs::status(path, none);
  return fs::exists(status) && !fs::is_regular_file(status);
}

[[noreturn]] void refuse_to_replace(const std::string& path) {
  if (is_no_file(path)) {
    throw base::Error(
        base::ExitCode::conflict,
        fmt::format("{}: already exists and is not a regular file; choose another place with -o",
                    terminal::shown(path)));
  }
  throw base::Error(base::ExitCode::conflict,
                    fmt::format("{}: already exists with other content; replace it with --force, "
                                "or choose another place with -o",
                                terminal::shown(path)));
}

class Arrivals {
 public:
  Arrivals(const FetchOptions& options, std::string place, bool is_file)
      : options_(options), place_(std::move(place)), is_file_(is_file), printer_(options.quiet) {}

  /// Serves as a FetchProgress. The client calls this function before it writes the first piece.
  /// Returns false if another file is at the destination.
  bool arrived(const rpc::FileView& file, std::uint64_t bytes) {
    if (terminal::Interruption::requested()) return false;
    const std::string path = path_of(file);
    const bool is_first_look = looked_at_.insert(path).second;
    if (is_first_look && is_no_file(path)) {
      taken_ = path;
      return false;
    }
    if (is_first_look && !options_.force) {
      const Standing standing = standing_of(path, file);
      if (standing == Standing::other) taken_ = path;
      if (standing == Standing::same && is_file_) same_ = path;
      if (!taken_.empty() || !same_.empty()) return false;
    }
    printer_.show(terminal::shown(path), file, bytes);
    bytes_[path] = file.size;
    return true;
  }

  void clear() { printer_.clear(); }
  const std::string& taken() const { return taken_; }
  const std::string& same() const { return same_; }
  std::uint64_t bytes_of(const std::string& path) const {
    const auto found = bytes_.find(path);
    return found == bytes_.end() ? 0 : found->second;
  }

 private:
  std::string path_of(const rpc::FileView& file) const {
    return is_file_ ? place_ : (fs::path(place_) / file.name).string();
  }

  const FetchOptions& options_;
  std::string place_;
  bool is_file_;
  FetchPrinter printer_;
  std::set<std::string> looked_at_;
  std::map<std::string, std::uint64_t> bytes_;
  std::string taken_;
  std::string same_;
};

struct Brought {
  rpc::JobId job{};
  std::vector<std::string> paths{};
  bool interrupted = false;
};

bool is_of_one_file(rpc::FetchKind kind) {
  return kind == rpc::FetchKind::archive || kind == rpc::FetchKind::so_far;
}

Brought fetch_job(rpc::Client& client, rpc::FetchAsk ask, const rpc::JobView& job,
                  const std::string& place, const FetchOptions& options,
                  const ArchiveCheck& check) {
  const bool is_file = is_of_one_file(ask.kind);
  Arrivals arrivals(options, place, is_file);
  const rpc::FetchProgress progress = [&](const rpc::FileView& file, std::uint64_t bytes) {
    return arrivals.arrived(file, bytes);
  };
  const rpc::AtItsPlace other = options.force ? rpc::AtItsPlace::replaced : rpc::AtItsPlace::kept;
  const rpc::FetchedFiles fetched =
      is_file ? client.fetch_file(
                    ask, place, progress, [&](const std::string& path) { check(path, job); }, other)
              : client.fetch_folder(ask, place, progress, other);
  arrivals.clear();
  if (!is_file && fetched.paths.empty()) {
    // Remove the folder if it is empty.
    std::error_code none;
    fs::remove(place, none);
  }
  if (!arrivals.taken().empty()) refuse_to_replace(arrivals.taken());
  Brought brought{.job = ask.job, .paths = fetched.paths};
  if (!arrivals.same().empty()) brought.paths = {arrivals.same()};
  brought.interrupted = arrivals.same().empty() && fetched.how != rpc::Waited::settled;
  if (options.json || options.quiet) return brought;
  for (const std::string& path : brought.paths) {
    if (arrivals.same().empty()) {
      // If a job is unfinished, its results aren't final, so print its state.
      const bool is_of_now = is_file && !rpc::is_settled(job.state);
      fmt::print(
          "{}  {}{}\n", terminal::shown(path), size_text(arrivals.bytes_of(path)),
          is_of_now ? fmt::format(", results so far: job {} is {}", job.id, rpc::name_of(job.state))
                    : "");
    } else {
      fmt::print("{}  already exists with the same content\n", terminal::shown(path));
    }
  }
  if (brought.paths.empty() && !brought.interrupted) fmt::print("job {}: no files\n", ask.job);
  return brought;
}

Json json_of(const std::vector<Brought>& all, bool is_single) {
  Json list = Json::array();
  for (const Brought& brought : all)
    list.push_back({{"id", brought.job.value}, {"files", brought.paths}});
  return is_single && list.size() == 1 ? list[0] : list;
}

void make_folder(const std::string& path) {
  std::error_code failure;
  fs::create_directories(path, failure);
  if (failure)
    throw base::Error(fmt::format("{}: can't create the folder: {}", path, failure.message()));
}

int fetch_all(rpc::Client& client, const FetchOptions& options,
              std::span<const service_client::JobName> names, const ArchiveCheck& check) {
  const rpc::FetchAsk ask = fetch_ask_of(options);
  const std::vector<rpc::JobView> jobs = views_of(client, names);
  const bool several = !is_single_job(names);
  const bool is_file = is_of_one_file(ask.kind);
  const auto* group = names.size() == 1 ? std::get_if<rpc::GroupId>(&names.front()) : nullptr;
  const terminal::Interruption interruption([&client] { client.interrupt(); });
  std::vector<Brought> all;
  base::ExitCode code = base::ExitCode::ok;
  for (const rpc::JobView& job : jobs) {
    rpc::FetchAsk of_job = ask;
    of_job.job = job.id;
    const std::string place =
        place_of(options, job.id, several, group ? std::optional(*group) : std::nullopt);
    const fs::path folder = fs::path(place).parent_path();
    if (several) make_folder(folder.string());
    std::error_code none;
    if (is_file && !folder.empty() && !fs::is_directory(folder, none))
      throw base::Error(fmt::format("{}: no such folder", terminal::shown(folder.string())));
    try {
      all.push_back(fetch_job(client, of_job, job, place, options, check));
    } catch (const rpc::RefusedError& error) {
      // If a job has no archive, fetch from the other jobs anyway.
      if (!several) throw;
      terminal::complain(
          fmt::format("sleight: job {}: {}", job.id, service_client::words_of(error.refusal())));
      if (code == base::ExitCode::ok) code = service_client::exit_code_of(error.refusal().kind);
      continue;
    } catch (const base::Error& error) {
      // If a file is damaged or its destination is taken, fetch from the other jobs anyway. A
      // missing service prevents this.
      if (!several || error.exit_code() == base::ExitCode::no_server ||
          dynamic_cast<const rpc::NoServer*>(&error) != nullptr)
        throw;
      terminal::complain(fmt::format("sleight: {}", error.what()));
      if (code == base::ExitCode::ok) code = error.exit_code();
      continue;
    }
    if (all.back().interrupted) {
      terminal::complain("interrupted; to resume, repeat the command");
      code = base::ExitCode::interrupted;
      break;
    }
  }
  if (options.json) fmt::print("{}\n", indented(json_of(all, !several)));
  return static_cast<int>(code);
}

}  // namespace

void check_archive(const std::string& path, const rpc::JobView& job) {
  const auto findings_of = [&](const archive::Source& source) {
    std::vector<std::string> findings = archive::verify(source);
    if (findings.empty() && job.state == rpc::JobState::done && !job.digest.empty()) {
      // Use the stored digest, which has been verified.
      const std::string digest = archive::summary_of(source).content_digest;
      if (digest != job.digest)
        findings.push_back(fmt::format("the archive's digest is {}, expected the job's digest {}",
                                       digest, job.digest));
    }
    for (const std::string& finding : findings)
      terminal::complain(fmt::format("sleight: job {}: {}", job.id, terminal::shown(finding)));
    return findings;
  };
  std::string words;
  try {
    if (findings_of(*archive::remote::open_remote(path)).empty()) return;
  } catch (const base::Error& error) {
    if (error.exit_code() != base::ExitCode::bad_archive) throw;
    words = fmt::format(" ({})", error.what());
  }
  throw base::Error(
      base::ExitCode::bad_archive,
      fmt::format("job {}: the archive on the server's disk is damaged{}, so no file was written; "
                  "to rebuild the archive from the run store, run `sleight fetch {} --so-far`",
                  job.id, words, job.id));
}

std::optional<std::vector<std::uint64_t>> recording_ids_of(std::string_view text) {
  std::set<std::uint64_t> ids;
  while (true) {
    const std::size_t comma = text.find(',');
    const std::string_view item = text.substr(0, comma);
    const std::size_t dots = item.find("..");
    const auto first = whole_number_of(item.substr(0, dots));
    const auto last =
        dots == std::string_view::npos ? first : whole_number_of(item.substr(dots + 2));
    if (!first || !last || *first > *last || *last - *first >= rpc::k_fetch_ids_max)
      return std::nullopt;
    for (std::uint64_t id = *first; id - *first <= *last - *first; ++id)
      ids.insert(id);
    if (ids.size() > rpc::k_fetch_ids_max) return std::nullopt;
    if (comma == std::string_view::npos) return std::vector(ids.begin(), ids.end());
    text.remove_prefix(comma + 1);
  }
}

rpc::FetchAsk fetch_ask_of(const FetchOptions& options) {
  const int kinds = int{options.so_far} + int{!options.recordings.empty()} + int{options.failures};
  if (kinds > 1) {
    throw base::Error(base::ExitCode::usage,
                      "--so-far, --recordings and --failures can't be combined");
  }
  rpc::FetchAsk ask;
  if (options.so_far) ask.kind = rpc::FetchKind::so_far;
  if (options.failures) ask.kind = rpc::FetchKind::failure_files;
  if (!options.recordings.empty()) {
    ask.kind = rpc::FetchKind::recordings;
    auto ids = recording_ids_of(options.recordings);
    if (!ids) {
      throw base::Error(base::ExitCode::usage,
                        fmt::format("--recordings: '{}' is not a list of ids, such as 3,7,10..20, "
                                    "or has more than {} ids",
                                    terminal::shown(options.recordings), rpc::k_fetch_ids_max));
    }
    ask.ids = *std::move(ids);
  }
  return ask;
}

std::string place_of(const FetchOptions& options, rpc::JobId job, bool several,
                     const std::optional<rpc::GroupId>& group) {
  std::string name = fmt::format("job-{}", job);
  if (options.failures) {
    name += "-failures";
  } else if (!options.recordings.empty()) {
    name += "-recordings";
  } else {
    name += ".h5";
  }
  if (!several) return options.output.empty() ? name : options.output;
  const std::string folder = !options.output.empty() ? options.output
                             : group                 ? fmt::format("g{}", *group)
                                                     : ".";
  return (fs::path(folder) / name).string();
}

int fetch(const std::string& socket, const FetchOptions& options, const ArchiveCheck& check) {
  const std::vector<service_client::JobName> names = service_client::read_job_names(options.jobs);
  static_cast<void>(fetch_ask_of(options));  // report usage errors first
  return service_client::with_service(
      socket, [&](rpc::Client& client) { return fetch_all(client, options, names, check); });
}

}  // namespace sleight::cli
