#include "common/store/lease.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <string_view>
#include <utility>

#include "common/base/check.h"

namespace sleight::store {
namespace {

constexpr std::string_view k_title = "sleight lease 1";
/// Maximum length of a value. A host's name has at most 64 bytes.
constexpr std::size_t k_value_bytes_max = 128;

/// Returns the text as one printable line. The text comes from the system, or from a file that
/// others can write.
std::string value_of(std::string_view text) {
  std::string value(text.substr(0, k_value_bytes_max));
  std::ranges::replace_if(
      value, [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; }, '?');
  return value;
}

/// Returns the lines `key value` below the title. Returns nothing if the text has another form.
std::optional<std::map<std::string, std::string, std::less<>>> lines_of(std::string_view text) {
  std::map<std::string, std::string, std::less<>> values;
  for (bool is_first = true; !text.empty(); is_first = false) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return std::nullopt;
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end + 1);
    if (is_first && line != k_title) return std::nullopt;
    if (const std::size_t space = line.find(' '); space != std::string_view::npos)
      values.emplace(line.substr(0, space), value_of(line.substr(space + 1)));
  }
  return values;
}

template <class Number>
bool read_number(std::string_view text, Number& number) {
  const auto [rest, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
  return failure == std::errc() && rest == text.data() + text.size();
}

}  // namespace

std::string LeaseText::to_text() const {
  std::string text = fmt::format(
      "{}\ntoken {}\nhost {}\nmachine {}\nprocess {}\nstarted {}\nsince {}\nlease_s {}\nepoch {}\n"
      "beat {}\nreleased {:d}\nowes_copies {:d}\n",
      k_title, value_of(token), value_of(holder.host), value_of(holder.machine), holder.process,
      holder.started, value_of(holder.since), lease_s, epoch, beat, is_released, owes_copies);
  CHECK_LT(text.size(), k_lease_text_bytes);
  text.append(k_lease_text_bytes - 1 - text.size(), ' ');
  text.push_back('\n');
  return text;
}

std::optional<LeaseText> LeaseText::from_text(const std::string& text) {
  if (text.size() != k_lease_text_bytes) return std::nullopt;
  const auto lines = lines_of(text);
  if (!lines) return std::nullopt;
  const auto value = [&](std::string_view key) -> std::string_view {
    const auto found = lines->find(key);
    return found == lines->end() ? std::string_view() : std::string_view(found->second);
  };
  LeaseText lease{.holder = {.host = std::string(value("host")),
                             .machine = std::string(value("machine")),
                             .since = std::string(value("since"))},
                  .token = std::string(value("token")),
                  .is_released = value("released") == "1",
                  .owes_copies = value("owes_copies") == "1"};
  const bool is_whole = read_number(value("process"), lease.holder.process) &&
                        read_number(value("started"), lease.holder.started) &&
                        read_number(value("lease_s"), lease.lease_s) &&
                        read_number(value("epoch"), lease.epoch) &&
                        read_number(value("beat"), lease.beat);
  // The condition is negated, so that NaN is refused too.
  if (!is_whole || !(lease.lease_s > 0 && lease.lease_s <= k_lease_s_max)) return std::nullopt;
  return lease;
}

Lease::Lease(LeaseFiles& files, const base::Clock& clock, LeaseText text)
    : files_(files), clock_(clock), text_(std::move(text)) {}

Lease::Outcome Lease::try_take() {
  CHECK_EQ(generation_, 0U);
  const std::vector<std::uint64_t> all = files_.list();
  if (all.empty()) return take(1, false);

  const std::uint64_t newest = all.back();
  const double asked_s = clock_.now_s();
  std::optional<std::string> text = files_.read(newest);
  const double seen_s = clock_.now_s();
  if (!text) return Unsure{};  // withdrawn, or the list is out of date
  const std::optional<LeaseText> other = LeaseText::from_text(*text);
  if (other && (other->is_released || files_.is_gone(other->holder)))
    return take(newest + 1, other->owes_copies);
  if (other && files_.is_here(other->holder)) return Held{other};

  // The holder is on another machine. A live holder renews its lease.
  const double lease_s = other ? other->lease_s : k_lease_s;
  if (!seen_ || seen_->generation != newest) {
    seen_ = Seen{.generation = newest, .text = *std::move(text), .since_s = seen_s};
    return Unsure{.by = other, .left_s = lease_s};
  }
  if (seen_->text != *text) return Held{other};
  const double left_s = seen_->since_s + lease_s - asked_s;
  if (left_s > 0) return Unsure{.by = other, .left_s = left_s};
  return take(newest + 1, true);
}

Lease::Outcome Lease::take(std::uint64_t generation, bool owes_copies) {
  text_.owes_copies = owes_copies;
  const double begin_s = clock_.now_s();
  own_ = files_.make(generation, text_.to_text());
  if (!own_) return Unsure{};  // another process was faster

  // If the first list was out of date, this generation may have been used before. In that case a
  // newer generation exists.
  const std::vector<std::uint64_t> all = files_.list();
  if (!all.empty() && all.back() > generation) {
    own_.reset();
    files_.remove(generation);
    return Unsure{};
  }
  generation_ = generation;
  end_s_ = begin_s + held_s();
  for (const std::uint64_t older : all) {
    if (older < generation) files_.remove(older);
  }
  return Taken{};
}

bool Lease::renew() {
  CHECK_GT(generation_, 0U);
  if (!may_act()) return false;
  const double begin_s = clock_.now_s();
  ++text_.beat;
  own_->write(text_.to_text());
  const std::vector<std::uint64_t> all = files_.list();
  // A late renewal does not count, because observers may have missed it.
  const bool is_in_time = clock_.now_s() < end_s_;
  // If the lease was renewed in time, nobody can have taken it, unless this clock has stalled.
  const bool is_newest = all.empty() || all.back() <= generation_;
  if (!is_in_time || !is_newest) {
    is_lost_ = true;
    return false;
  }
  end_s_ = begin_s + held_s();
  return true;
}

void Lease::release() {
  if (!may_act()) return;
  // Stop acting before writing. The next holder may read the file before write() returns.
  is_lost_ = true;
  text_.is_released = true;
  own_->write(text_.to_text());
}

bool Lease::may_act() const {
  return !is_lost_ && clock_.now_s() < end_s_;
}

std::optional<LeaseText> Lease::successor() {
  const std::vector<std::uint64_t> all = files_.list();
  if (all.empty() || all.back() <= generation_) return std::nullopt;
  const std::optional<std::string> text = files_.read(all.back());
  return text ? LeaseText::from_text(*text) : std::nullopt;
}

}  // namespace sleight::store
