#include "clients/gallery_server/snapshot.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "clients/analysis/sampling_method.h"
#include "clients/browse/archives/browsed.h"
#include "clients/gallery_server/checked_read.h"
#include "common/archive/format.h"
#include "common/archive/kept_motions.h"
#include "common/archive/remote/remote_source.h"
#include "common/base/check.h"
#include "common/base/cores.h"

namespace sleight::gallery {
namespace {

/// A lineage's number; 0 if a file has an invalid number.
std::int64_t whole(double number) {
  constexpr double k_most = 9e15;  // doubles represent all integers below this
  return std::abs(number) <= k_most ? static_cast<std::int64_t>(number) : 0;
}

/// Satisfied draws of all chains.
std::vector<LineageDraw> satisfied_of(const archive::Source& source,
                                      const archive::Summary& summary) {
  const std::uint64_t draws = summary.chains * summary.scans;
  std::vector<LineageDraw> satisfied;
  for (std::uint64_t first = 0; first < draws; first += k_rows_at_once) {
    const std::uint64_t count = std::min(k_rows_at_once, draws - first);
    const auto column = [&](std::string_view name) {
      return checked_numbers(source, archive::k_sample_stats, name, draws, first, count);
    };
    const std::vector<double> is_satisfied = column("satisfied");
    const std::vector<double> lineage = column("lineage");
    for (std::uint64_t i = 0; i < count; ++i) {
      if (is_satisfied[i] == 0) continue;
      satisfied.push_back({.chain = (first + i) / summary.scans,
                           .lineage = whole(lineage[i]),
                           .draw = (first + i) % summary.scans});
    }
  }
  return satisfied;
}

std::vector<double> blind_throws(const archive::Source& source) {
  std::vector<double> throws;
  const auto read = [&](std::string_view group, std::string_view name, std::uint64_t count) {
    if (count == 0 || !has_numbers(source, group, name, count)) return;
    throws = checked_numbers(source, group, name, count, 0, count);
  };
  read(archive::k_sample_stats_prior, "log_prior", prior_draws_of(source));
  if (throws.empty()) read(archive::k_finds, "log_prior_of_throw", archive::k_throws);
  std::erase_if(throws, [](double value) { return !std::isfinite(value); });
  std::ranges::sort(throws);
  return throws;
}

/// The outline's index, completed from the archive; none if the outline belongs to another archive.
std::optional<browse::Index> index_of_outline(const archive::Source& source,
                                              browse::Outline& outline) {
  if (archive::summary_of(source).content_digest != outline.index.digest) return std::nullopt;
  const std::size_t entries = outline.index.entries.size();
  auto read = browse::read_index(source, {.of_this_file = &outline.index});
  if (!read || entries == 0 || read.value().taken_over != entries) return std::nullopt;
  return std::move(read.value().index);
}

}  // namespace

Facts facts_of(const archive::Source& source, const browse::ReadIndex& read) {
  const browse::Index& index = read.index;
  Facts facts{.summary = archive::summary_of(source)};
  const archive::Summary& summary = facts.summary;
  facts.in_proportion = summary.chains * summary.scans > 0 && summary.warning.empty() &&
                        std::ranges::all_of(index.entries, [](const browse::Entry& entry) {
                          return entry.name.is_find || entry.in_proportion;
                        });
  facts.prior_log_prior = blind_throws(source);
  facts.method = analysis::method_word(summary.request_text);
  if (summary.chains * summary.scans > k_counted_draws_max) return facts;
  const std::vector<LineageDraw> satisfied = satisfied_of(source, summary);
  facts.satisfied = satisfied.size();
  if (facts.in_proportion && !read.is_beginning) {
    std::vector<LineageDraw> kept;
    for (const browse::Entry& entry : index.entries) {
      if (!entry.name.is_find)
        kept.push_back(
            {.chain = entry.name.chain, .lineage = entry.lineage, .draw = entry.name.draw});
    }
    facts.by_lineage = satisfied_draws(satisfied, kept);
  }
  return facts;
}

Snapshot::Snapshot(const std::string& path, const Options& options)
    : generation_(options.generation),
      file_(options.file ? options.file : browse::state_of_file(path)),
      source_(options.open ? options.open(path) : archive::remote::open_remote(path)) {
  if (options.outline != nullptr) {
    auto outline = index_of_outline(*source_, *options.outline);
    if (outline) {
      read_.index = *std::move(outline);
      first_groups_ = std::move(options.outline->groups);
    }
  }
  if (!first_groups_) {
    CHECK(options.earlier == nullptr || !options.earlier->is_outline());
    read_ = browse::read_index(
        *source_, path,
        {.file = file_,
         .earlier = options.earlier == nullptr ? nullptr : &options.earlier->read_.index,
         .beginning_max = options.beginning_max,
         .progress = options.progress});
  }
  facts_ = facts_of(*source_, read_);
  for (std::size_t entry = 0; entry < read_.index.entries.size(); ++entry)
    by_name_.emplace(browse::short_text(read_.index.entries[entry].name), entry);
}

std::vector<double> Snapshot::satisfied_draws() const {
  if (facts_.by_lineage.draws == 0) return {};
  // Shares count only animations of chains, so map the animations' indices to entries.
  std::vector<std::size_t> entry_of_animation;
  for (std::size_t entry = 0; entry < read_.index.entries.size(); ++entry)
    if (!read_.index.entries[entry].name.is_find) entry_of_animation.push_back(entry);
  std::vector<double> draws(read_.index.entries.size(), 0.0);
  for (const LineageCounts& lineage : facts_.by_lineage.lineages) {
    for (const LineageCounts::Count& count : lineage.counts)
      draws[entry_of_animation[count.animation]] = static_cast<double>(count.draws);
  }
  return draws;
}

std::optional<std::size_t> Snapshot::entry_of(std::string_view name) const {
  const auto found = by_name_.find(name);
  return found == by_name_.end() ? std::nullopt : std::optional(found->second);
}

const browse::AlikeSet& Snapshot::alike() const {
  CHECK(!is_outline());
  std::call_once(made_alike_, [this] {
    std::vector<const browse::Entry*> all;
    for (const browse::Entry& entry : read_.index.entries)
      all.push_back(&entry);
    alike_.emplace(all, read_.index.scene, base::cores_here());
  });
  return *alike_;
}

browse::Groups Snapshot::first_groups() const {
  if (first_groups_) return *first_groups_;
  return alike().groups(browse::k_first_groups, browse::k_first_grouping);
}

void Snapshot::keep_outline(const std::string& path) const {
  CHECK(!is_outline() && !is_beginning());
  if (file_) browse::keep_outline(path, *file_, read_.index, first_groups());
}

void Snapshot::read(const std::function<void(const archive::Source&)>& work) const {
  const std::lock_guard lock(mutex_);
  work(*source_);
}

browse::KeptAnimation Snapshot::animation(std::size_t entry) const {
  const browse::Entry& of = read_.index.entries[entry];
  const std::string_view group = of.name.is_find ? archive::k_finds : archive::k_animations;
  browse::KeptAnimation animation;
  read([&](const archive::Source& source) {
    const archive::KeptMotions motions(source, group);
    animation = browse::kept_animation(source, motions, of.row, read_.index.scene,
                                       browse::short_text(of.name));
  });
  return animation;
}

}  // namespace sleight::gallery
