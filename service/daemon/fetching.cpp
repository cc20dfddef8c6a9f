#include "service/daemon/fetching.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "common/base/error.h"
#include "common/hash/sha256.h"
#include "common/logging/log.h"
#include "service/daemon/views.h"
#include "service/keeper/command.h"

namespace sleight::daemon {
namespace {

constexpr std::size_t k_hash_piece = 1U << 20U;

rpc::Refusal refusal(rpc::RefusalKind kind, std::string sentence, std::string what_to_do = {}) {
  return {.kind = kind, .sentence = std::move(sentence), .what_to_do = std::move(what_to_do)};
}

/// Returns the program's last line of output, without the program's name and the job's folder.
std::string last_line(const keeper::ToolEnd& end) {
  const std::string text =
      end.words.empty() ? end.why() : end.words.substr(end.words.find_last_of('\n') + 1);
  constexpr std::string_view k_name = "sleight: ";
  return text.starts_with(k_name) ? text.substr(k_name.size()) : text;
}

std::vector<std::string> names_after(const std::string& folder, const std::string& after) {
  std::vector<std::string> names;
  std::error_code reason;
  for (const auto& entry : std::filesystem::directory_iterator(folder, reason)) {
    std::string name = entry.path().filename().string();
    if (name > after && entry.is_regular_file(reason)) names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

std::string sha256_of_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw base::Error(fmt::format("{}: can't read the file", path));
  hash::Sha256 hash;
  std::string piece(k_hash_piece, '\0');
  while (file) {
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    hash.update(std::string_view(piece.data(), static_cast<std::size_t>(file.gcount())));
  }
  if (file.bad()) throw base::Error(fmt::format("{}: can't read the file", path));
  return hash::to_hex(hash.finish());
}

Fetching::Fetching(Parts parts)
    : parts_(std::move(parts)),
      expiry_(parts_.loop.call_every(k_held_for_s / 10, [this] { drop_expired(); })) {}

Fetching::~Fetching() {
  parts_.worker.end();
  parts_.maker.end();
}

void Fetching::fetch(std::uint32_t user, const rpc::FetchAsk& ask, std::string segments,
                     rpc::Reply<rpc::Fetched> reply) {
  if (!ask.sha256_wanted.empty()) {
    if (auto source = held(ask.sha256_wanted)) {
      rpc::Fetched fetched;
      fetched.files.push_back(std::move(source));
      reply.answer(std::move(fetched));
      return;
    }
  }
  if (const auto of_user = under_way_.find(user);
      of_user != under_way_.end() && of_user->second >= k_fetches_of_user_max) {
    reply.refuse(
        refusal(rpc::RefusalKind::busy,
                fmt::format("You already have {} fetches in progress, which is the maximum.",
                            k_fetches_of_user_max),
                "Try again when a fetch has finished."));
    return;
  }
  make(user, ask, std::move(segments),
       std::make_shared<rpc::Reply<rpc::Fetched>>(std::move(reply)));
}

/// Runs the program. The program's core doesn't count as one of the jobs' cores. When the daemon
/// ends, the program is killed.
keeper::ToolEnd Fetching::run_maker(const std::vector<std::string>& command) const {
  return keeper::run_tool(command, {.seconds_max = k_make_s_max,
                                    .environment = keeper::program_environment(),
                                    .yields = true,
                                    .stop = &parts_.maker.ending()});
}

Fetching::Files Fetching::derived(jobs::JobId job, const std::string& made) const {
  const keeper::ToolEnd end =
      run_maker({parts_.sleight, "archive", "derive", parts_.folders.run(job), "-o", made});
  if (end.exit_code != 0) {
    return refusal(rpc::RefusalKind::environment,
                   fmt::format("Can't create an archive of job {}: {}", job.value, last_line(end)));
  }
  return std::vector<Found>{
      {.path = made, .name = fmt::format("job-{}.h5", job.value), .is_ours = true}};
}

/// Returns the newest archive. If the run wrote no archive, derives one from the store.
Fetching::Files Fetching::newest(jobs::JobId job, const std::string& made) const {
  const std::string archive = parts_.folders.archive(job);
  if (std::filesystem::exists(archive))
    return std::vector<Found>{{.path = archive, .name = fmt::format("job-{}.h5", job.value)}};
  if (std::filesystem::exists(parts_.folders.run(job))) return derived(job, made);
  if (!std::filesystem::exists(parts_.folders.folder(job))) {
    return refusal(rpc::RefusalKind::not_found,
                   fmt::format("The files of job {} do not exist.", job.value),
                   "The job may not have started yet, or its folder was deleted.");
  }
  return refusal(rpc::RefusalKind::conflict, fmt::format("Job {} has no archive yet.", job.value),
                 "The archive becomes available after the first results are stored.");
}

Fetching::Files Fetching::recordings(jobs::JobId job, const std::string& segments,
                                     const std::vector<std::uint64_t>& ids,
                                     const std::string& made) const {
  std::vector<std::string> command{
      parts_.sleight, "archive", "export", parts_.folders.archive(job), "--csv", "--table",
      segments,       "-o",      made};
  for (const std::uint64_t id : ids) {
    command.emplace_back("--animation");
    command.push_back(std::to_string(id));
  }
  const keeper::ToolEnd end = run_maker(command);
  if (end.exit_code != 0) {
    return refusal(
        rpc::RefusalKind::not_found,
        fmt::format("Can't export the recordings of job {}: {}", job.value, last_line(end)));
  }
  return std::vector<Found>{
      {.path = made, .name = fmt::format("job-{}-recordings.csv", job.value), .is_ours = true}};
}

std::vector<Fetching::Found> Fetching::failures(jobs::JobId job, const std::string& after,
                                                bool& has_more) const {
  const std::string folder = parts_.folders.failures(job);
  std::vector<std::string> names = names_after(folder, after);
  has_more = names.size() > rpc::k_fetch_files_max;
  if (has_more) names.resize(rpc::k_fetch_files_max);
  std::vector<Found> found;
  for (const std::string& name : names)
    found.push_back({.path = folder + "/" + name, .name = name});
  return found;
}

/// Creates another link to the file and hashes the contents. If another file replaces the original,
/// the link still has these contents. Throws base::Error.
Fetching::Hashed Fetching::hashed(Found file, const std::string& beside) {
  const std::string own = beside + "-" + file.name;
  std::error_code reason;
  if (file.is_ours) {
    std::filesystem::rename(file.path, own, reason);
  } else {
    std::filesystem::create_hard_link(file.path, own, reason);
  }
  if (reason) throw base::Error(fmt::format("{}: {}", own, reason.message()));
  file.path = own;
  return {.file = file, .sha256 = sha256_of_file(own)};
}

Fetching::Files Fetching::find(const rpc::FetchAsk& ask, const std::string& segments,
                               const std::string& beside, bool& has_more) const {
  const jobs::JobId job = job_id(ask.job);
  switch (ask.kind) {
    case rpc::FetchKind::so_far:
      return derived(job, beside + ".h5");
    case rpc::FetchKind::failure_files:
      return failures(job, ask.after, has_more);
    case rpc::FetchKind::recordings:
      return recordings(job, segments, ask.ids, beside + ".csv");
    case rpc::FetchKind::archive:
    case rpc::FetchKind::unknown:
      break;
  }
  return newest(job, beside + ".h5");
}

/// In a worker's thread, finds or derives the files and hashes them.
void Fetching::make(std::uint32_t user, const rpc::FetchAsk& ask, const std::string& segments,
                    std::shared_ptr<rpc::Reply<rpc::Fetched>> reply) {
  const std::string beside = fmt::format("{}/{}", parts_.folders.fetched(), ++made_);
  const bool is_there = ask.kind == rpc::FetchKind::failure_files ||
                        (ask.kind == rpc::FetchKind::archive &&
                         std::filesystem::exists(parts_.folders.archive(job_id(ask.job))));
  Worker& worker = is_there ? parts_.worker : parts_.maker;
  ++under_way_[user];
  worker.run([this, user, ask, segments, beside, reply] {
    std::variant<std::vector<Hashed>, rpc::Refusal> outcome = std::vector<Hashed>{};
    bool has_more = false;
    try {
      Files found = find(ask, segments, beside, has_more);
      if (auto* refused = std::get_if<rpc::Refusal>(&found)) {
        outcome = std::move(*refused);
      } else {
        for (Found& file : std::get<std::vector<Found>>(found))
          std::get<std::vector<Hashed>>(outcome).push_back(hashed(std::move(file), beside));
      }
    } catch (const base::Error& failure) {
      logging::warn(failure.what());
      outcome = refusal(rpc::RefusalKind::environment,
                        fmt::format("The files of job {} can't be read.", ask.job.value),
                        "See the service's log for the reason.");
    }
    parts_.loop.post([this, user, outcome = std::move(outcome), has_more, reply]() mutable {
      if (--under_way_[user] == 0) under_way_.erase(user);
      if (auto* refused = std::get_if<rpc::Refusal>(&outcome)) {
        reply->refuse(std::move(*refused));
      } else {
        give(std::get<std::vector<Hashed>>(std::move(outcome)), has_more, *reply);
      }
    });
  });
}

void Fetching::give(std::vector<Hashed> files, bool has_more, rpc::Reply<rpc::Fetched>& reply) {
  rpc::Fetched fetched{.files = {}, .has_more = has_more};
  try {
    for (const Hashed& hashed : files) {
      fetched.files.push_back(rpc::open_source(hashed.file.path, hashed.file.name, hashed.sha256));
      hold(hashed.sha256, hashed.file);
    }
    reply.answer(std::move(fetched));
  } catch (const base::Error&) {
    reply.refuse(refusal(rpc::RefusalKind::environment, "The file was deleted during the fetch.",
                         "Try again."));
  }
}

std::unique_ptr<rpc::Source> Fetching::held(const std::string& sha256) {
  const auto at = held_.find(sha256);
  if (at == held_.end()) return nullptr;
  try {
    at->second.until_s = clock_.now_s() + k_held_for_s;
    return rpc::open_source(at->second.path, at->second.name, sha256);
  } catch (const base::Error&) {
    held_.erase(at);
    return nullptr;
  }
}

/// Stores the file's link for a while. If derived files have the same name, keeps only the
/// k_held_made_max newest.
void Fetching::hold(const std::string& sha256, const Found& file) {
  const auto [at, is_new] = held_.try_emplace(
      sha256, Held{.path = file.path, .name = file.name, .is_ours = file.is_ours});
  if (!is_new && at->second.path != file.path) {
    ::unlink(at->second.path.c_str());
    at->second.path = file.path;
  }
  at->second.until_s = clock_.now_s() + k_held_for_s;
  drop_oldest([&](const Held& held) { return held.is_ours && held.name == file.name; },
              k_held_made_max);
  drop_oldest([](const Held&) { return true; }, k_held_files_max);
}

/// Deletes the link. Readers keep the open file.
Fetching::HeldFile Fetching::drop(HeldFile held) {
  ::unlink(held->second.path.c_str());
  return held_.erase(held);
}

void Fetching::drop_oldest(const std::function<bool(const Held&)>& is_meant, std::size_t most) {
  std::vector<HeldFile> meant;
  for (auto at = held_.begin(); at != held_.end(); ++at)
    if (is_meant(at->second)) meant.push_back(at);
  std::ranges::sort(meant, {}, [](HeldFile at) { return at->second.until_s; });
  for (std::size_t i = 0; i + most < meant.size(); ++i)
    drop(meant[i]);
}

void Fetching::drop_expired() {
  for (auto at = held_.begin(); at != held_.end();)
    at = at->second.until_s <= clock_.now_s() ? drop(at) : std::next(at);
}

}  // namespace sleight::daemon
