#include "clients/browse/archives/animation_ids.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "clients/browse/index.h"
#include "common/archive/format.h"
#include "common/archive/summary.h"
#include "common/base/error.h"

namespace sleight::browse {
namespace {

constexpr std::size_t k_shown_ids = 5;

std::vector<std::int64_t> numbers_of(const archive::Source& source, std::string_view name,
                                     std::uint64_t count) {
  const archive::Group* group = archive::find_group(source, archive::k_animations);
  const archive::DatasetSpec* spec =
      group == nullptr ? nullptr : archive::find_dataset(*group, name);
  const bool fits = spec != nullptr && spec->type == archive::ElementType::i64 &&
                    spec->dims.size() == 1 && spec->dims[0].size == count;
  if (!fits) {
    throw base::Error(base::ExitCode::bad_archive,
                      fmt::format("{}: {}/{}: expected a column of {} numbers", source.name(),
                                  archive::k_animations, name, count));
  }
  return std::get<std::vector<std::int64_t>>(source.read(archive::k_animations, name, 0, count));
}

using IdsByText = std::map<std::string_view, const AnimationId*>;

std::string text_of(const browse::AskedName& name) {
  return browse::short_text(
      browse::AnimationName{.is_find = name.is_find, .chain = name.chain, .draw = name.draw});
}

/// Throws if a spreadsheet may have read the id "3.700" as a number and written "3.7".
void refuse_lost_zeros(const archive::Source& source, const std::string& text,
                       browse::AskedName name, const IdsByText& by_text) {
  if (!name.is_bare || name.draw % 10 == 0) return;
  std::vector<std::string> meant;
  const std::string exact = text_of(name);
  for (; name.draw <= std::numeric_limits<std::uint64_t>::max() / 10; name.draw *= 10) {
    if (by_text.contains(text_of(name))) meant.push_back(text_of(name));
  }
  if (meant.empty() || (meant.size() == 1 && meant.front() == exact)) return;
  throw base::Error(base::ExitCode::usage,
                    fmt::format("{}: the id '{}' may have lost zeros at its end; use {}",
                                source.name(), text, fmt::join(meant, " or ")));
}

}  // namespace

std::string_view group_of(const AnimationId& id) {
  return id.is_find ? archive::k_finds : archive::k_animations;
}

std::vector<AnimationId> animation_ids(const archive::Source& source) {
  const archive::Summary summary = archive::summary_of(source);
  std::vector<AnimationId> ids;
  std::set<std::string> texts;
  if (summary.animations > 0) {
    const auto chains = numbers_of(source, "chain", summary.animations);
    const auto draws = numbers_of(source, "draw", summary.animations);
    for (std::size_t row = 0; row < chains.size(); ++row) {
      if (chains[row] < 0 || draws[row] < 0) {
        throw base::Error(
            base::ExitCode::bad_archive,
            fmt::format("{}: the number of a chain or draw is below 0", source.name()));
      }
      ids.push_back({.row = row,
                     .text = browse::short_text({.chain = static_cast<std::uint64_t>(chains[row]),
                                                 .draw = static_cast<std::uint64_t>(draws[row])})});
      if (!texts.insert(ids.back().text).second) {
        throw base::Error(
            base::ExitCode::bad_archive,
            fmt::format("{}: two animations have the id {}", source.name(), ids.back().text));
      }
    }
  }
  for (std::uint64_t row = 0; row < summary.finds.animations; ++row)
    ids.push_back(
        {.is_find = true, .row = row, .text = browse::short_text({.is_find = true, .draw = row})});
  return ids;
}

std::vector<AnimationId> animations_of(const archive::Source& source,
                                       std::span<const std::string> asked) {
  const std::vector<AnimationId> all = animation_ids(source);
  const std::string run_id = archive::summary_of(source).run_id;
  IdsByText by_text;
  for (const AnimationId& id : all)
    by_text.emplace(id.text, &id);
  std::vector<AnimationId> chosen;
  std::set<std::string_view> taken;
  for (const std::string& text : asked) {
    const auto name = browse::parse_name(text);
    const bool is_of_run = name && run_id.starts_with(name->run);
    if (is_of_run) refuse_lost_zeros(source, text, *name, by_text);
    const auto found = is_of_run ? by_text.find(text_of(*name)) : by_text.end();
    if (found == by_text.end()) {
      std::vector<std::string_view> first;
      for (const AnimationId& id : std::span(all).first(std::min(all.size(), k_shown_ids)))
        first.push_back(id.text);
      throw base::Error(
          base::ExitCode::usage,
          all.empty() ? fmt::format("{}: no animation '{}'; the archive has no animations",
                                    source.name(), text)
                      : fmt::format("{}: no animation '{}'; the archive has {}{}", source.name(),
                                    text, fmt::join(first, ", "),
                                    all.size() > first.size()
                                        ? fmt::format(" and {} more", all.size() - first.size())
                                        : ""));
    }
    if (taken.insert(found->first).second) chosen.push_back(*found->second);
  }
  return chosen;
}

}  // namespace sleight::browse
