#include "common/archive/digest/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "common/archive/digest/digest.h"
#include "common/archive/format.h"
#include "common/archive/kept_motions.h"
#include "common/archive/structure.h"

namespace sleight::archive {
namespace {

using Findings = std::vector<std::string>;

bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) ||
         (std::isnan(a) && std::isnan(b));
}

/// Counts the violations of one rule and records where the first one is. A rule gives at most one
/// finding.
class Rule {
 public:
  explicit Rule(std::string text) : text_(std::move(text)) {}
  /// `place` is called only for the first violation.
  template <class Place>
  void expect(bool holds, Place&& place) {
    if (!holds && faults_++ == 0) first_ = place();
  }
  void report(Findings& findings) const {
    if (faults_ != 0) {
      findings.push_back(fmt::format("{}: {} violation{}, first at {}", text_, faults_,
                                     faults_ == 1 ? "" : "s", first_));
    }
  }

 private:
  std::string text_;
  std::string first_;
  std::uint64_t faults_ = 0;
};

/// Typed access to a source whose structure is valid.
class Reader {
 public:
  explicit Reader(const Source& source) : source_(source) {}

  std::uint64_t size(std::string_view group, std::string_view dim) const {
    return find_dataset(*find_group(source_, group), dim)->dims[0].size;
  }
  std::uint64_t elements(std::string_view group, std::string_view dataset) const {
    return element_count(*find_dataset(*find_group(source_, group), dataset));
  }
  template <class Element>
  std::vector<Element> read(std::string_view group, std::string_view dataset, std::uint64_t first,
                            std::uint64_t count) const {
    return std::get<std::vector<Element>>(source_.read(group, dataset, first, count));
  }
  template <class Element>
  Element one(std::string_view group, std::string_view dataset, std::uint64_t place) const {
    return read<Element>(group, dataset, place, 1).at(0);
  }
  std::int64_t integer(std::string_view group, std::string_view attribute) const {
    return std::get<std::int64_t>(
        find_attribute(find_group(source_, group)->attributes, attribute)->value);
  }
  const Group& group(std::string_view name) const { return *find_group(source_, name); }
  bool has_group(std::string_view name) const { return find_group(source_, name) != nullptr; }

 private:
  const Source& source_;
};

template <class Visit>
void for_each_batch(std::uint64_t total, Visit&& visit) {
  for (std::uint64_t first = 0; first < total; first += k_batch_elements) {
    visit(first, std::min<std::uint64_t>(k_batch_elements, total - first));
  }
}

void check_progression(const Reader& reader, std::string_view group, std::string_view dim,
                       std::uint64_t step, Findings& findings) {
  Rule rule(fmt::format("{} must count 0, {}, ...", path_of(group, dim), step));
  for_each_batch(reader.size(group, dim), [&](std::uint64_t first, std::uint64_t count) {
    const auto values = reader.read<std::int64_t>(group, dim, first, count);
    for (std::size_t i = 0; i < values.size(); ++i) {
      rule.expect(values[i] == static_cast<std::int64_t>((first + i) * step),
                  [&] { return fmt::format("{}", first + i); });
    }
  });
  rule.report(findings);
}

/// Checks the coordinates of chains and draws, and that all groups have the same chains and scans.
void check_coordinates(const Reader& reader, Findings& findings) {
  const std::int64_t thin = reader.integer(k_posterior, "thin");
  const std::uint64_t scans = reader.size(k_sample_stats, "draw");
  if (thin < 1) {
    findings.push_back(fmt::format("/posterior thin is {}: expected at least 1", thin));
    return;
  }
  const auto step = static_cast<std::uint64_t>(thin);
  const std::uint64_t states = scans == 0 ? 0 : (scans - 1) / step + 1;
  if (reader.size(k_posterior, "draw") != states) {
    findings.push_back(
        fmt::format("/posterior has {} draws, but {} scans with thin {} require {} draws",
                    reader.size(k_posterior, "draw"), scans, thin, states));
    return;
  }
  for (const std::string_view group : {k_posterior, k_sample_stats, k_replicas}) {
    check_progression(reader, group, "chain", 1, findings);
    if (reader.size(group, "chain") != reader.size(k_sample_stats, "chain")) {
      findings.push_back(
          fmt::format("{} and /sample_stats have different numbers of chains", group));
    }
  }
  check_progression(reader, k_posterior, "draw", step, findings);
  check_progression(reader, k_sample_stats, "draw", 1, findings);
  check_progression(reader, k_replicas, "replica", 1, findings);
  check_progression(reader, k_animations, "animation", 1, findings);
  check_progression(reader, k_animations, "segment", 1, findings);

  if (reader.size(k_replicas, "replica") > 1) {
    // Scans are numbered from the start of the run. Draws may be numbered differently.
    Rule place("/replicas/scan must be a multiple of thin, or -1");
    for_each_batch(
        reader.elements(k_replicas, "scan"), [&](std::uint64_t first, std::uint64_t count) {
          for (const auto scan : reader.read<std::int64_t>(k_replicas, "scan", first, count))
            place.expect(scan == -1 || (scan >= 0 && scan % thin == 0),
                         [&] { return fmt::format("scan {}", scan); });
        });
    place.report(findings);
    return;
  }
  Rule newest("/replicas/scan must be the run's last multiple of 'thin'");
  for_each_batch(
      reader.elements(k_replicas, "scan"), [&](std::uint64_t first, std::uint64_t count) {
        for (const auto scan : reader.read<std::int64_t>(k_replicas, "scan", first, count)) {
          newest.expect(states != 0 && scan == static_cast<std::int64_t>((states - 1) * step),
                        [&] { return fmt::format("scan {}", scan); });
        }
      });
  newest.report(findings);
}

void check_scalars(const Reader& reader, Findings& findings) {
  Rule sum("lp = log_prior + log_constraint");
  Rule truth("satisfied must be 0 or 1");
  Rule lineage("lineage must not be negative");
  const auto place = [&](std::uint64_t element) {
    const std::uint64_t scans = reader.size(k_sample_stats, "draw");
    return [element, scans] {
      return fmt::format("chain {}, scan {}", element / scans, element % scans);
    };
  };
  for_each_batch(
      reader.elements(k_sample_stats, "lp"), [&](std::uint64_t first, std::uint64_t count) {
        const auto lp = reader.read<double>(k_sample_stats, "lp", first, count);
        const auto prior = reader.read<double>(k_sample_stats, "log_prior", first, count);
        const auto constraint = reader.read<double>(k_sample_stats, "log_constraint", first, count);
        const auto satisfied = reader.read<std::int8_t>(k_sample_stats, "satisfied", first, count);
        const auto lineages = reader.read<std::int64_t>(k_sample_stats, "lineage", first, count);
        for (std::size_t i = 0; i < count; ++i) {
          sum.expect(same(lp[i], prior[i] + constraint[i]), place(first + i));
          truth.expect(satisfied[i] == 0 || satisfied[i] == 1, place(first + i));
          lineage.expect(lineages[i] >= 0, place(first + i));
        }
      });
  sum.report(findings);
  truth.report(findings);
  lineage.report(findings);
}

void check_proposals(const Reader& reader, Findings& findings) {
  const std::uint64_t kinds = reader.size(k_sample_stats, "proposal_kind");
  const std::uint64_t scans = reader.size(k_sample_stats, "draw");
  Rule count_rule("0 <= accepted <= proposed");
  Rule rate_rule("acceptance_rate = accepted / proposed");
  if (kinds == 0 || kinds > k_batch_elements) {
    findings.push_back(fmt::format("/sample_stats has {} kinds of proposal: expected 1 to {}",
                                   kinds, k_batch_elements));
    return;
  }
  const std::uint64_t total = reader.elements(k_sample_stats, "acceptance_rate");
  const std::uint64_t rows_of_batch = k_batch_elements / kinds;
  for (std::uint64_t first = 0; first < total; first += rows_of_batch) {
    const std::uint64_t rows = std::min(rows_of_batch, total - first);
    const auto proposed =
        reader.read<std::int32_t>(k_sample_stats, "proposed", first * kinds, rows * kinds);
    const auto accepted =
        reader.read<std::int32_t>(k_sample_stats, "accepted", first * kinds, rows * kinds);
    const auto rate = reader.read<double>(k_sample_stats, "acceptance_rate", first, rows);
    for (std::size_t row = 0; row < rows; ++row) {
      const auto place = [&] {
        return fmt::format("chain {}, scan {}", (first + row) / scans, (first + row) % scans);
      };
      std::int64_t proposed_sum = 0;
      std::int64_t accepted_sum = 0;
      for (std::size_t i = row * kinds; i < (row + 1) * kinds; ++i) {
        count_rule.expect(0 <= accepted[i] && accepted[i] <= proposed[i], place);
        proposed_sum += proposed[i];
        accepted_sum += accepted[i];
      }
      rate_rule.expect(
          same(rate[row], static_cast<double>(accepted_sum) / static_cast<double>(proposed_sum)),
          place);
    }
  }
  count_rule.report(findings);
  rate_rule.report(findings);
}

class AnimationCheck {
 public:
  explicit AnimationCheck(const Reader& reader)
      : reader_(reader),
        chains_(reader.size(k_sample_stats, "chain")),
        scans_(reader.size(k_sample_stats, "draw")) {
    for (const DatasetSpec& spec : reader.group(k_animations).datasets) {
      if (spec.dims.size() != 1 || spec.dims[0].name != "animation") continue;
      const DatasetSpec* scalar = find_dataset(reader.group(k_sample_stats), spec.name);
      if (spec.type == ElementType::f64 && scalar != nullptr && scalar->type == ElementType::f64 &&
          scalar->dims.size() == 2) {
        shared_.push_back(spec.name);
      }
    }
  }

  void run(Findings& findings) {
    const std::uint64_t total = reader_.size(k_animations, "animation");
    const std::int64_t keep_max = reader_.integer(k_animations, "keep_max");
    if (std::cmp_greater(total, keep_max)) {
      findings.push_back(
          fmt::format("/animations has {} animations, but keep_max is {}", total, keep_max));
      return;
    }
    for_each_batch(total,
                   [this](std::uint64_t first, std::uint64_t count) { check_batch(first, count); });
    segments_.expect(std::cmp_equal(next_segment_, reader_.size(k_animations, "segment")),
                     [] { return std::string("the end of dimension segment"); });
    for (const Rule* rule : {&order_, &place_, &satisfied_, &equal_, &lineage_, &segments_}) {
      rule->report(findings);
    }
  }

 private:
  void check_batch(std::uint64_t first, std::uint64_t count) {
    const auto integers = [&](const char* name) {
      return reader_.read<std::int64_t>(k_animations, name, first, count);
    };
    const auto chain = integers("chain");
    const auto draw = integers("draw");
    const auto lineage = integers("lineage");
    const auto start = integers("segment_start");
    const auto rows = integers("segment_count");
    std::vector<std::vector<double>> shared;
    for (const std::string& name : shared_) {
      shared.push_back(reader_.read<double>(k_animations, name, first, count));
    }
    for (std::size_t i = 0; i < count; ++i) {
      const auto here = [&] { return fmt::format("animation {}", first + i); };
      const std::pair at{draw[i], chain[i]};
      order_.expect(first + i == 0 || before_ < at, here);
      before_ = at;
      segments_.expect(start[i] == next_segment_ && rows[i] >= 0, here);
      // Use unsigned arithmetic, which wraps instead of overflowing, because the file may contain
      // any numbers.
      next_segment_ = static_cast<std::int64_t>(static_cast<std::uint64_t>(start[i]) +
                                                static_cast<std::uint64_t>(rows[i]));
      const bool inside = chain[i] >= 0 && std::cmp_less(chain[i], chains_) && draw[i] >= 0 &&
                          std::cmp_less(draw[i], scans_);
      place_.expect(inside, here);
      if (!inside) continue;
      const std::int64_t kept = ++kept_of_lineage_[{chain[i], lineage[i]}];
      lineage_.expect(kept <= reader_.integer(k_animations, "keep_per_lineage"), here);
      const std::uint64_t row =
          static_cast<std::uint64_t>(chain[i]) * scans_ + static_cast<std::uint64_t>(draw[i]);
      satisfied_.expect(reader_.one<std::int8_t>(k_sample_stats, "satisfied", row) == 1, here);
      equal_.expect(reader_.one<std::int64_t>(k_sample_stats, "lineage", row) == lineage[i], here);
      for (std::size_t s = 0; s < shared_.size(); ++s) {
        equal_.expect(same(reader_.one<double>(k_sample_stats, shared_[s], row), shared[s][i]),
                      here);
      }
    }
  }

  const Reader& reader_;
  std::uint64_t chains_;
  std::uint64_t scans_;
  std::vector<std::string> shared_;  ///< scalars in both groups
  std::pair<std::int64_t, std::int64_t> before_{};
  std::int64_t next_segment_ = 0;
  std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> kept_of_lineage_;
  Rule order_{"animations must be ordered by draw, then by chain"};
  Rule place_{"an animation's chain and draw must exist in the run"};
  Rule satisfied_{"a kept animation must satisfy the constraint"};
  Rule equal_{"an animation's scalars must equal the values of its scan in /sample_stats"};
  Rule lineage_{"a lineage must have at most keep_per_lineage animations"};
  Rule segments_{"segments must be contiguous"};
};

/// Checks the finds: the number of kept finds, the order of their starts, and their segments.
void check_finds(const Reader& reader, Findings& findings) {
  if (!reader.has_group(k_finds)) return;
  for (const char* dim : {"animation", "segment", "throw"})
    check_progression(reader, k_finds, dim, 1, findings);
  const std::uint64_t total = reader.size(k_finds, "animation");
  const std::int64_t found = reader.integer(k_finds, k_found);
  const std::int64_t keep_max = reader.integer(k_finds, "keep_max");
  if (std::cmp_not_equal(total, std::min(found, keep_max))) {
    findings.push_back(
        fmt::format("/finds has {} animations; expected the smaller of its attributes found ({}) "
                    "and keep_max ({})",
                    total, found, keep_max));
  }
  Rule order{"/finds: the animations' start numbers must increase"};
  Rule segments{"the segments in /finds must be contiguous"};
  std::int64_t start_before = -1;
  std::int64_t next_segment = 0;
  for_each_batch(total, [&](std::uint64_t first, std::uint64_t count) {
    const auto start = reader.read<std::int64_t>(k_finds, "start", first, count);
    const auto begin = reader.read<std::int64_t>(k_finds, "segment_start", first, count);
    const auto rows = reader.read<std::int64_t>(k_finds, "segment_count", first, count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto here = [&] { return fmt::format("animation {}", first + i); };
      order.expect(start[i] > start_before, here);
      start_before = start[i];
      segments.expect(begin[i] == next_segment && rows[i] >= 0, here);
      next_segment = static_cast<std::int64_t>(static_cast<std::uint64_t>(begin[i]) +
                                               static_cast<std::uint64_t>(rows[i]));
    }
  });
  segments.expect(std::cmp_equal(next_segment, reader.size(k_finds, "segment")),
                  [] { return std::string("the end of dimension segment"); });
  order.report(findings);
  segments.report(findings);
}

/// Checks a dimension's rows: an animation's rows must directly follow the previous animation's.
void check_rows(const Reader& reader, std::string_view group, const std::string& dim,
                Findings& findings) {
  check_progression(reader, group, dim, 1, findings);
  Rule rule(
      fmt::format("{}: the animations' rows along dimension {} must be contiguous", group, dim));
  std::uint64_t next = 0;
  for_each_batch(reader.size(group, "animation"), [&](std::uint64_t first, std::uint64_t count) {
    const auto start = reader.read<std::int64_t>(group, dim + "_start", first, count);
    const auto rows = reader.read<std::int64_t>(group, dim + "_count", first, count);
    for (std::size_t i = 0; i < count; ++i) {
      rule.expect(std::cmp_equal(start[i], next) && rows[i] >= 0,
                  [&] { return fmt::format("animation {}", first + i); });
      next = static_cast<std::uint64_t>(start[i]) + static_cast<std::uint64_t>(rows[i]);
    }
  });
  rule.expect(next == reader.size(group, dim), [&] { return "the end of dimension " + dim; });
  rule.report(findings);
}

/// Checks the motions, and each animation's own parts of the scene.
void check_motions(const Source& source, const Reader& reader, std::string_view group,
                   const scene::Scene& scene, Findings& findings) {
  const bool is_draws = group == k_animations;
  Rule proportion(is_draws ? "in_proportion must be 0 or 1" : "in_proportion of a find must be 0");
  Rule motion(fmt::format("motions of {} must be valid", group));
  Rule own(fmt::format("each animation's parts and control points in {} must be valid", group));
  const std::uint64_t total = reader.size(group, "animation");
  for_each_batch(total, [&](std::uint64_t first, std::uint64_t count) {
    const auto values = reader.read<std::int8_t>(group, "in_proportion", first, count);
    for (std::size_t i = 0; i < count; ++i)
      proportion.expect(values[i] == 0 || (is_draws && values[i] == 1),
                        [&] { return fmt::format("animation {}", first + i); });
  });
  const KeptMotions motions(source, group);
  for (std::uint64_t i = 0; i < total; ++i) {
    std::string reason;
    const auto place = [&] { return fmt::format("animation {}: {}", i, reason); };
    const auto found = motions.animation(i, scene);
    if (!found) reason = found.error();
    motion.expect(found.ok(), place);
    const auto variation = motions.variation(i, scene);
    if (!variation) reason = variation.error();
    own.expect(variation.ok(), place);
  }
  for (const Rule* rule : {&proportion, &motion, &own})
    rule->report(findings);
}

void check_scene(const Source& source, const Reader& reader, Findings& findings) {
  const auto scene = scene_of(source);
  if (!scene) {
    findings.push_back(fmt::format("/scene: {}", scene.error()));
    return;
  }
  for (const std::string_view group : {k_animations, k_finds}) {
    if (!reader.has_group(group)) continue;
    bool is_whole = true;
    for (const char* dim : {"part", "point"}) {
      if (find_dataset(reader.group(group), dim) == nullptr) continue;
      const std::size_t before = findings.size();
      check_rows(reader, group, dim, findings);
      is_whole = is_whole && findings.size() == before;
    }
    if (is_whole) check_motions(source, reader, group, scene.value(), findings);
  }
}

void check_prior(const Reader& reader, Findings& findings) {
  for (const std::string_view group : {k_prior, k_sample_stats_prior}) {
    check_progression(reader, group, "chain", 1, findings);
    check_progression(reader, group, "draw", 1, findings);
  }
  if (reader.size(k_prior, "draw") != reader.size(k_sample_stats_prior, "draw")) {
    findings.emplace_back("/prior and /sample_stats_prior have different numbers of draws");
    return;
  }
  Rule sum("/sample_stats_prior/lp = log_prior + log_constraint");
  Rule truth("/sample_stats_prior/satisfied must be 0 or 1");
  for_each_batch(
      reader.elements(k_sample_stats_prior, "lp"), [&](std::uint64_t first, std::uint64_t count) {
        const auto lp = reader.read<double>(k_sample_stats_prior, "lp", first, count);
        const auto prior = reader.read<double>(k_sample_stats_prior, "log_prior", first, count);
        const auto constraint =
            reader.read<double>(k_sample_stats_prior, "log_constraint", first, count);
        const auto satisfied =
            reader.read<std::int8_t>(k_sample_stats_prior, "satisfied", first, count);
        for (std::size_t i = 0; i < count; ++i) {
          const auto here = [&] { return fmt::format("draw {}", first + i); };
          sum.expect(same(lp[i], prior[i] + constraint[i]), here);
          truth.expect(satisfied[i] == 0 || satisfied[i] == 1, here);
        }
      });
  sum.report(findings);
  truth.report(findings);
}

/// Checks that failure counts have known kinds and are never 0.
void check_failures(const Reader& reader, Findings& findings) {
  for (const Attribute& attribute : reader.group(k_root).attributes) {
    if (!attribute.name.starts_with(k_failed_prefix)) continue;
    const std::string_view kind = std::string_view(attribute.name).substr(k_failed_prefix.size());
    const auto* count = std::get_if<std::int64_t>(&attribute.value);
    if (!plan::failure_kind_of(kind))
      findings.push_back(fmt::format("/ {}: unknown kind of failure", attribute.name));
    else if (count == nullptr || *count < 1)
      findings.push_back(fmt::format("/ {}: expected an integer above 0", attribute.name));
  }
}

void check_digest(const Source& source, Findings& findings) {
  const auto stored = std::get<std::string>(
      find_attribute(find_group(source, k_root)->attributes, k_content_digest)->value);
  const std::string computed = digest(source);
  if (stored != computed) {
    findings.push_back(
        fmt::format("content_digest is {}, but the digest of the content is {}", stored, computed));
  }
}

}  // namespace

std::vector<std::string> verify(const Source& source) {
  Findings findings = check_structure(source);
  if (!findings.empty()) return findings;
  const Reader reader(source);
  check_failures(reader, findings);
  check_coordinates(reader, findings);
  check_scalars(reader, findings);
  check_proposals(reader, findings);
  AnimationCheck(reader).run(findings);
  check_finds(reader, findings);
  // If rows are out of place, skip the checks of the scene, which would report these rows again.
  if (findings.empty()) check_scene(source, reader, findings);
  check_prior(reader, findings);
  check_digest(source, findings);
  return findings;
}

}  // namespace sleight::archive
