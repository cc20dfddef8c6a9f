#include "service/backend/slurm_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace sleight::backend {
namespace {

constexpr std::size_t k_value_bytes_max = 1024;
constexpr std::array<std::string_view, 4> k_plain_keys{"account", "partition", "qos", "time"};
constexpr std::string_view k_more_key = "more";

/// Options of sbatch, without dashes.
constexpr std::array<std::string_view, 27> k_refused{
    "array",     "batch",   "chdir",    "clusters", "comment",  "cpus-per-task",  "error",
    "gid",       "help",    "hold",     "input",    "job-name", "ntasks",         "no-requeue",
    "open-mode", "output",  "parsable", "requeue",  "signal",   "test-only",      "uid",
    "usage",     "version", "wait",     "wrap",     "quiet",    "ntasks-per-core"};

[[noreturn]] void refuse_wish(const std::string& words) {
  throw base::Error(base::ExitCode::usage, words);
}

void check_value(std::string_view key, std::string_view value) {
  const bool has_control = std::ranges::any_of(
      value, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  if (has_control)
    refuse_wish(fmt::format("the Slurm option '{}' contains control characters", key));
  if (value.size() > k_value_bytes_max)
    refuse_wish(
        fmt::format("the Slurm option '{}' is longer than {} bytes", key, k_value_bytes_max));
}

/// The words, separated by spaces.
std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    if (end > 0) words.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return words;
}

/// Refuses abbreviations too: sbatch accepts "--comm=x" for --comment.
void check_word(const std::string& word) {
  if (!word.starts_with("--") || word.size() < 3)
    refuse_wish(
        fmt::format("'{}' is not an sbatch option of the form --name=value or --name", word));
  const std::string_view name = std::string_view(word).substr(2, word.find('=') - 2);
  const auto refused = std::ranges::find_if(
      k_refused, [name](std::string_view known) { return known.starts_with(name); });
  if (refused != k_refused.end())
    refuse_wish(fmt::format("the service controls --{} itself; remove '{}'", *refused, word));
}

}  // namespace

SlurmWishes slurm_wishes_of(const Options& defaults, const Options& options) {
  SlurmWishes wishes;
  for (const Options* all : {&defaults, &options}) {
    for (const auto& [key, value] : *all) {
      if (key != k_more_key && std::ranges::find(k_plain_keys, key) == k_plain_keys.end())
        refuse_wish(fmt::format(
            "unknown Slurm option '{}'; expected 'account', 'partition', 'qos', 'time' or 'more'",
            key));
      check_value(key, value);
    }
  }
  for (const std::string_view key : k_plain_keys) {
    const std::string name(key);
    const auto own = options.find(name);
    const auto usual = defaults.find(name);
    const bool has_own = own != options.end() && !own->second.empty();
    if (!has_own && (usual == defaults.end() || usual->second.empty())) continue;
    wishes.arguments.push_back(fmt::format("--{}={}", key, has_own ? own->second : usual->second));
  }
  for (const Options* all : {&defaults, &options}) {
    const auto more = all->find(std::string(k_more_key));
    if (more == all->end()) continue;
    for (std::string& word : words_of(more->second)) {
      check_word(word);
      wishes.says_memory = wishes.says_memory || word.starts_with("--mem");
      wishes.arguments.push_back(std::move(word));
    }
  }
  return wishes;
}

}  // namespace sleight::backend
