#include "tests/unit/service/core/script.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "common/base/check.h"

namespace sleight::core {
namespace {

plan::ReplicaKey key_of(char name) {
  return {base::ChainId{static_cast<std::uint32_t>(name - 'a')}, base::ReplicaId{0}};
}
char name_of(const plan::ReplicaKey& key) {
  return static_cast<char>('a' + key.chain.value);
}

/// Returns a replica's state before a scan: a text that names the replica and the scan.
base::Bytes state_of(const plan::ReplicaKey& key, std::uint64_t scan) {
  base::Bytes bytes;
  for (const char c : fmt::format("{}{}", name_of(key), scan))
    bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

std::string place_of(const plan::Unit& unit) {
  return fmt::format("{}@{}", name_of(unit.replica), unit.first_scan.value);
}

}  // namespace

ListedPlan::ListedPlan(std::string_view list) {
  std::istringstream words{std::string(list)};
  for (std::string word; words >> word;) {
    Job& job = jobs_.emplace_back();
    const std::size_t less = word.find('<');
    if (less != std::string::npos) job.after = word.substr(less + 1);
    word = word.substr(0, less);
    job.is_part = word.front() == '[';
    if (job.is_part) {
      job.replicas = word.substr(1, word.size() - 2);
    } else {
      job.replicas = word.substr(0, 1);
      if (word.size() > 1) job.scans = static_cast<std::uint32_t>(std::stoul(word.substr(1)));
    }
  }
}

std::optional<plan::Block> ListedPlan::next_block(const plan::BlockLimits&) {
  std::string busy;
  for (Job& job : jobs_) {
    const auto free = [&](char replica) { return busy.find(replica) == std::string::npos; };
    const bool ready = !job.handed_out && std::ranges::all_of(job.replicas + job.after, free);
    if (!job.done()) busy += job.replicas;
    if (!ready) continue;
    job.handed_out = true;
    plan::Block block;
    for (const char replica : job.replicas) {
      plan::Unit& unit = block.members.emplace_back();
      unit.replica = key_of(replica);
      unit.first_scan = base::ScanIndex{next_scan_[replica]};
      unit.scans = job.scans;
      unit.starts = next_scan_[replica] == 0;
    }
    if (job.is_part) {
      const auto levels = static_cast<std::uint32_t>(job.replicas.size());
      block.ladder = {.levels = levels,
                      .first_level = 0,
                      .inverse_temperatures = std::vector<double>(levels, 1),
                      .proposal_scales = std::vector<std::vector<double>>(levels),
                      .end_scan = 10,
                      .scans_max = 3 * levels};
    }
    return block;
  }
  return std::nullopt;
}

void ListedPlan::consume(plan::ReplicaKey replica, base::ScanIndex first_scan,
                         std::span<const plan::ScanRecord> records) {
  const char name = name_of(replica);
  EXPECT_EQ(first_scan.value, next_scan_[name]) << name;
  next_scan_[name] += records.size();
  const auto job = std::ranges::find_if(jobs_, [&](const Job& each) {
    return each.handed_out && !each.done() && each.replicas.find(name) != std::string::npos;
  });
  ASSERT_NE(job, jobs_.end());
  ++job->consumed;
}

bool ListedPlan::finished() const {
  return std::ranges::all_of(jobs_, &Job::done);
}

/// A line's words and its settings. A setting is a word of the form name=value.
struct Script::Line {
  std::vector<std::string> words;
  std::map<std::string, std::string, std::less<>> settings;

  explicit Line(std::string_view text) {
    std::istringstream stream{std::string(text)};
    for (std::string word; stream >> word;) {
      const std::size_t is = word.find('=');
      if (is == std::string::npos) words.push_back(word);
      if (is != std::string::npos) settings[word.substr(0, is)] = word.substr(is + 1);
    }
  }
  std::uint64_t number(std::string_view name, std::uint64_t otherwise) const {
    const auto found = settings.find(name);
    return found == settings.end() ? otherwise : std::stoull(found->second);
  }
  WorkerId worker() const { return WorkerId{static_cast<std::uint32_t>(std::stoul(words.at(1)))}; }
  /// Assignments named in the line.
  std::vector<std::uint64_t> assignments() const {
    std::vector<std::uint64_t> ids;
    for (const std::string& word : words) {
      if (word.front() == '#') ids.push_back(std::stoull(word.substr(1)));
    }
    return ids;
  }
};

Delivered Script::delivery(const Line& line) const {
  Delivered made{.worker = line.worker(), .delivery = {}};
  made.delivery.epoch = line.number("epoch", options_.epoch);
  made.delivery.assignment = line.assignments().front();
  if (line.words.back() == "lacking") return made;
  const plan::Block& block = given_.at(made.delivery.assignment);
  const auto cost = line.settings.find("cost");
  const auto found = line.settings.find("wrong");
  const std::string wrong = found == line.settings.end() ? "" : found->second;
  for (const plan::Unit& member : block.members) {
    plan::UnitResult& result = made.delivery.results.emplace_back();
    result.unit = member;
    result.unit.scans = static_cast<std::uint32_t>(line.number("scans", member.scans));
    if (wrong == "replica") result.unit.replica = key_of('z');
    if (wrong == "first") ++result.unit.first_scan.value;
    result.scans.resize(result.unit.scans + (wrong == "scans" ? 1 : 0));
    result.state_after = state_of(member.replica, member.first_scan.value + result.unit.scans);
    result.cost_s = cost == line.settings.end() ? 0.001 : std::stod(cost->second);
  }
  if (wrong == "members") made.delivery.results.push_back(made.delivery.results.back());
  return made;
}

std::string Script::printed(const Effect& effect) {
  if (const auto* ask = std::get_if<Ask>(&effect)) {
    EXPECT_EQ(ask->ping.epoch, options_.epoch);
    return fmt::format("ask {}", ask->worker);
  }
  std::string text;
  if (const auto* keep = std::get_if<Keep>(&effect)) {
    for (const plan::UnitResult& result : keep->results)
      text += fmt::format(" {}+{}", place_of(result.unit), result.unit.scans);
    return "keep" + text;
  }
  const auto& assign = std::get<Assign>(effect);
  EXPECT_EQ(assign.assignment.epoch, options_.epoch);
  const plan::Block& block = assign.assignment.block;
  given_[assign.assignment.assignment] = block;
  EXPECT_EQ(assign.assignment.states.size(), block.members.size());
  for (std::size_t i = 0; i < block.members.size(); ++i) {
    const plan::Unit& member = block.members[i];
    if (i > 0) text += ", ";
    text += place_of(member);
    if (!block.ladder) text += fmt::format("+{}", member.scans);
    const plan::GivenState& state = assign.assignment.states[i];
    EXPECT_FALSE(member.starts && state);
    if (state) {
      EXPECT_EQ(*state, state_of(member.replica, member.first_scan.value)) << text;
    }
    text += member.starts ? " starts" : state ? " bytes" : " held";
  }
  if (block.ladder) text = "[" + text + "]";
  return fmt::format("assign {} #{} {}", assign.worker, assign.assignment.assignment, text);
}

void Script::take(const Line& line) {
  const std::string& kind = line.words.front();
  if (kind == "resume") {
    const char replica = line.words.at(1).front();
    const std::uint64_t scan = std::stoull(line.words.at(2));
    plan_.begins_at(replica, scan);
    scheduler_.resume(key_of(replica), scan, state_of(key_of(replica), scan));
    return;
  }
  const Input input = [&]() -> Input {
    if (kind == "join") {
      return Joined{.worker = line.worker(),
                    .incarnation = line.number("incarnation", 0),
                    .threads = static_cast<std::uint32_t>(line.number("threads", 1))};
    }
    if (kind == "leave") return Left{line.worker()};
    if (kind == "tick") return Tick{std::stod(line.words.at(1))};
    if (kind == "done") return delivery(line);
    if (kind == "pong") {
      return Answered{.worker = line.worker(),
                      .pong = {.epoch = line.number("epoch", options_.epoch),
                               .assignments = line.assignments()}};
    }
    CHECK(kind == "stop");
    return StopAsked{};
  }();
  bool gave = false;
  for (const Effect& effect : scheduler_.step(input)) {
    // Assign effects may depend on Keep effects, so all Keep effects must come first.
    EXPECT_FALSE(gave && std::holds_alternative<Keep>(effect));
    gave = gave || std::holds_alternative<Assign>(effect);
    played_ += "  " + printed(effect) + "\n";
  }
  if (scheduler_.counts().refused > refused_) played_ += "  (refused)\n";
  if (scheduler_.ended() && !ended_) played_ += "  (ended)\n";
  refused_ = scheduler_.counts().refused;
  ended_ = scheduler_.ended();
}

std::string Script::play(std::string_view script) {
  played_.clear();
  std::istringstream lines{std::string(script)};
  for (std::string text; std::getline(lines, text);) {
    if (text.starts_with("  ")) continue;
    played_ += text + "\n";
    if (!text.empty()) take(Line(text));
  }
  return played_;
}

void expect_goes(std::string_view plan, const SchedulerOptions& options, std::string_view script) {
  Script played(plan, options);
  EXPECT_EQ(played.play(script), script);
}

}  // namespace sleight::core
