#include "service/coordinator/writing_words.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "common/events/progress.h"

namespace sleight::coordinator {
namespace {

using Part = archive::WritingProgress::Part;
using events::grouped;

/// "1,200 of 5,000 draws (24%)  0:12 left  310 draws/s".
std::string counted(const archive::WritingProgress& now, const char* things, double per_s,
                    const char* unit) {
  if (now.total == 0) return things;
  std::string words = fmt::format(
      "{} of {} {} ({:.0f}%)", grouped(now.done), grouped(now.total), things,
      std::floor(100.0 * static_cast<double>(now.done) / static_cast<double>(now.total)));
  if (per_s > 0) {
    words += fmt::format("  {} left  {} {}/s",
                         events::clock_time(static_cast<double>(now.total - now.done) / per_s),
                         grouped(static_cast<std::uint64_t>(per_s)), unit);
  }
  return words;
}

std::string words_of(const archive::WritingProgress& now, double per_s) {
  switch (now.part) {
    case Part::learning:
      return fmt::format("processing stored scans: {} so far", grouped(now.done));
    case Part::draws:
      return counted(now, "draws", per_s, "draws");
    case Part::animations:
      break;
  }
  return counted(now, "animations", per_s, "animations");
}

}  // namespace

WritingWords::WritingWords(Say say, const base::Clock& clock)
    : say_(std::move(say)), clock_(clock), begun_s_(clock.now_s()), said_s_(begun_s_) {}

void WritingWords::hear(const archive::WritingProgress& now) {
  const double now_s = clock_.now_s();
  if (now.part != begun_.part || now.done < begun_.done) {
    begun_ = now;
    begun_s_ = now_s;
  }
  if (now_s - said_s_ < k_writing_said_every_s) return;
  said_s_ = now_s;
  const double took_s = now_s - begun_s_;
  const double per_s = took_s > 0 ? static_cast<double>(now.done - begun_.done) / took_s : 0;
  say_(fmt::format("{}: {}", k_writing, words_of(now, per_s)));
}

}  // namespace sleight::coordinator
