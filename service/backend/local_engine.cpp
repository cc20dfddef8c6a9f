#include "service/backend/local_engine.h"

#include <fmt/format.h>

#include <charconv>
#include <sstream>
#include <utility>

#include "common/base/file_system.h"
#include "service/keeper/process_table.h"

namespace sleight::backend {
namespace {

constexpr std::size_t k_entry_bytes_max = 8192;

std::uint32_t epoch_of(const AttemptName& name) {
  return static_cast<std::uint32_t>(name.epoch);
}

}  // namespace

LocalEngine::LocalEngine(std::string register_folder, keeper::Programs programs)
    : register_(std::move(register_folder)), keepers_(std::move(programs)) {
  base::PosixFileSystem().make_folder(register_);
}

/// A name's text, which is a file's name too.
std::string LocalEngine::path_of(const AttemptName& name) const {
  return fmt::format("{}/{}", register_, to_text(name));
}

std::optional<LocalEngine::Launched> LocalEngine::launched(const AttemptName& name) const {
  const std::string path = path_of(name);
  if (!base::PosixFileSystem().exists(path)) return std::nullopt;
  std::istringstream entry(base::read_text_file(path, k_entry_bytes_max));
  Launched launched;
  entry >> launched.keeper.pid >> launched.keeper.start_ticks >> launched.keeper.boot;
  entry.ignore(1);
  std::getline(entry, launched.folder);
  if (launched.folder.empty()) throw base::Error(fmt::format("{}: it is damaged", path));
  return launched;
}

Seen LocalEngine::launch(const Order& order) {
  check_order(order);
  if (!launched(order.name)) {
    const keeper::RunningKeeper keeper = keepers_.launch_command(order.folder, order.command);
    const keeper::ProcessIdentity& identity = keeper.identity();
    base::PosixFileSystem files;
    const std::string path = path_of(order.name);
    base::write_text_file(files, path + ".new",
                          fmt::format("{} {} {}\n{}\n", identity.pid, identity.start_ticks,
                                      identity.boot, order.folder));
    files.rename(path + ".new", path);
  }
  return state(order.name);
}

Seen LocalEngine::state(const AttemptName& name) {
  const auto launched = this->launched(name);
  if (!launched) return {};
  Seen seen{.state = State::gone, .id = fmt::format("{}", launched->keeper.pid)};
  const auto newest = keeper::read_record(launched->folder);
  if (newest && newest->attempt > name.epoch) return seen;
  const keeper::Look look = keepers_.look(launched->folder, epoch_of(name));
  using keeper::Look;
  const bool begins = look.state == Look::State::never_began && keeper::is_living(launched->keeper);
  seen.state = begins || look.state == Look::State::running ? State::running : State::gone;
  if (look.state == Look::State::never_began) seen.words = begins ? "it begins" : look.words;
  if (look.state == Look::State::died) seen.words = "its keeper was killed";
  return seen;
}

bool LocalEngine::signal(const AttemptName& name, keeper::Stop how) {
  const auto launched = this->launched(name);
  return launched && keepers_.stop(launched->folder, epoch_of(name), how);
}

std::map<AttemptName, Seen> LocalEngine::list(const std::string& daemon) {
  std::map<AttemptName, Seen> listed;
  for (const std::string& file : base::PosixFileSystem().names_in(register_)) {
    const auto name = attempt_name_of(file);
    if (name && name->daemon == daemon) listed.emplace(*name, state(*name));
  }
  return listed;
}

std::string LocalEngine::log(const AttemptName& name, const std::string& folder,
                             std::size_t bytes_max) {
  const auto launched = this->launched(name);
  return end_of_file((launched ? launched->folder : folder) + "/" + keeper::k_keeper_words_name,
                     bytes_max);
}

}  // namespace sleight::backend
