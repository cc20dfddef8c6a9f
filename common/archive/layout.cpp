#include "common/archive/layout.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "common/archive/animations_writer.h"
#include "common/archive/distinct.h"
#include "common/archive/format.h"
#include "common/archive/scene_groups.h"
#include "common/archive/specs.h"
#include "common/base/check.h"

namespace sleight::archive {
namespace {

std::uint64_t archived_states(const RunView& view, const ArchiveOptions& options) {
  return view.draws() == 0 ? 0 : (view.draws() - 1) / options.thin + 1;
}

class PosteriorWriter {
 public:
  PosteriorWriter(const RunView& view, const StateReader& reader, const ArchiveOptions& options,
                  Sink& sink)
      : reader_(reader), thin_(options.thin) {
    sink.create_group(k_posterior);
    sink.set_attribute(k_posterior, {"thin", signed_of(options.thin)});
    Dims dims{{"chain", view.chains()}, {"draw", archived_states(view, options)}};
    write_coordinate(sink, k_posterior, dims[0], "number of the independent chain");
    write_coordinate(sink, k_posterior, dims[1], "scan after which the state was recorded",
                     options.thin);
    const Dims leading = dims;
    write_own_coordinates(sink, k_posterior, reader.layout().variables, dims);
    states_.emplace(sink, k_posterior, leading, reader.layout().variables);
  }

  void push(base::ScanIndex scan, const plan::ScanRecord& record) {
    if (scan.value % thin_ != 0) return;
    CHECK(!record.state.empty());
    states_->push(reader_.variables(record.state));
  }

  void flush() { states_->flush(); }

 private:
  const StateReader& reader_;
  std::uint64_t thin_;
  std::optional<VariableColumns> states_;
};

Column<std::int64_t> lineage_column(Sink& sink, std::string_view group, const Dims& dims) {
  return {sink, group,
          spec_of("lineage", ElementType::i64, dims,
                  "number of the visit to the prior from which the state descends")};
}

void write_kinds(Sink& sink, std::string_view group, const Dimension& dim,
                 const std::vector<std::string>& kinds) {
  for (const std::string& kind : kinds)
    CHECK(is_plain_name(kind));
  write_words(sink, group, dim.name, {dim}, "kind of proposal", kinds);
}

/// Columns that contain, for each scan and kind, the numbers of proposals and acceptances.
class ProposalColumns {
 public:
  ProposalColumns(Sink& sink, const Dims& leading, const std::vector<std::string>& kinds) {
    const Dimension kind{"proposal_kind", kinds.size()};
    write_kinds(sink, k_sample_stats, kind, kinds);
    Dims dims = leading;
    dims.push_back(kind);
    proposed_.emplace(
        sink, k_sample_stats,
        spec_of("proposed", ElementType::i32, dims, "number of proposals in the scan"));
    accepted_.emplace(
        sink, k_sample_stats,
        spec_of("accepted", ElementType::i32, dims, "number of accepted proposals in the scan"));
    rate_.emplace(
        sink, k_sample_stats,
        spec_of("acceptance_rate", ElementType::f64, leading,
                "accepted share of proposals of all kinds; NaN if there were no proposals"));
    kinds_ = kinds.size();
  }

  void push(const plan::ScanRecord& record) {
    CHECK_EQ(record.proposed.size(), kinds_);
    CHECK_EQ(record.accepted.size(), kinds_);
    std::uint64_t proposed = 0;
    std::uint64_t accepted = 0;
    for (std::size_t kind = 0; kind < kinds_; ++kind) {
      proposed_->push(small_of(record.proposed[kind]));
      accepted_->push(small_of(record.accepted[kind]));
      proposed += record.proposed[kind];
      accepted += record.accepted[kind];
    }
    // If there are no proposals, 0 / 0 gives NaN, which means "does not apply".
    rate_->push(static_cast<double>(accepted) / static_cast<double>(proposed));
  }

  void flush() {
    proposed_->flush();
    accepted_->flush();
    rate_->flush();
  }

 private:
  std::optional<Column<std::int32_t>> proposed_;
  std::optional<Column<std::int32_t>> accepted_;
  std::optional<Column<double>> rate_;
  std::size_t kinds_ = 0;
};

class SampleStatsWriter {
 public:
  SampleStatsWriter(const RunView& view, const WorldLayout& layout, Sink& sink) {
    sink.create_group(k_sample_stats);
    const Dims dims{{"chain", view.chains()}, {"draw", view.draws()}};
    write_coordinate(sink, k_sample_stats, dims[0], "number of the independent chain");
    write_coordinate(sink, k_sample_stats, dims[1], "scan");
    Dims written = dims;
    write_own_coordinates(sink, k_sample_stats, layout.outcomes, written);
    lp_.emplace(sink, k_sample_stats,
                spec_of("lp", ElementType::f64, dims, "log_prior + log_constraint"));
    densities_.emplace(sink, k_sample_stats, dims);
    satisfied_.emplace(sink, k_sample_stats,
                       spec_of("satisfied", ElementType::boolean, dims,
                               "whether the outcome satisfies the constraint"));
    lineage_ = lineage_column(sink, k_sample_stats, dims);
    proposals_.emplace(sink, dims, layout.proposal_kinds);
    outcomes_.emplace(sink, k_sample_stats, dims, layout.outcomes);
  }

  void push(const plan::ScanRecord& record) {
    lp_->push(record.log_prior + record.log_constraint);
    densities_->push(record.log_prior, record.log_constraint);
    satisfied_->push(record.satisfied ? 1 : 0);
    lineage_->push(signed_of(record.lineage));
    proposals_->push(record);
    outcomes_->push(record.outcome);
  }

  void flush() {
    lp_->flush();
    densities_->flush();
    satisfied_->flush();
    lineage_->flush();
    proposals_->flush();
    outcomes_->flush();
  }

 private:
  std::optional<Column<double>> lp_;
  std::optional<DensityColumns> densities_;
  std::optional<Column<std::int8_t>> satisfied_;
  std::optional<Column<std::int64_t>> lineage_;
  std::optional<ProposalColumns> proposals_;
  std::optional<VariableColumns> outcomes_;
};

/// A replica's newest archived state.
struct NewestState {
  base::ScanIndex scan;
  plan::ScanRecord record;
};
using NewestStates =
    std::vector<std::vector<std::optional<NewestState>>>;  ///< by chain, by replica

void write_replicas(const NewestStates& newest, const StateReader& reader, Sink& sink) {
  sink.create_group(k_replicas);
  Dims dims{{"chain", newest.size()}, {"replica", newest.empty() ? 1 : newest.front().size()}};
  write_coordinate(sink, k_replicas, dims[0], "number of the independent chain");
  write_coordinate(sink, k_replicas, dims[1], "replica of the chain");
  const Dims leading = dims;
  write_own_coordinates(sink, k_replicas, reader.layout().variables, dims);
  Column<std::int64_t> scan(
      sink, k_replicas,
      spec_of("scan", ElementType::i64, leading, "scan after which the state was recorded"));
  Column<double> beta(sink, k_replicas,
                      spec_of("inverse_temperature", ElementType::f64, leading,
                              "exponent of the constraint's density in the sampled distribution"));
  DensityColumns densities(sink, k_replicas, leading);
  VariableColumns states(sink, k_replicas, leading, reader.layout().variables);
  constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();
  std::size_t width = 0;
  for (const Variable& variable : reader.layout().variables)
    width += variable.size();
  const plan::ScanRecord no_record{.log_prior = k_nan,
                                   .log_constraint = k_nan,
                                   .satisfied = false,
                                   .lineage = 0,
                                   .inverse_temperature = k_nan,
                                   .proposed = {},
                                   .accepted = {},
                                   .outcome = {},
                                   .state = {}};
  for (const auto& chain : newest) {
    for (const std::optional<NewestState>& replica : chain) {
      const plan::ScanRecord& record = replica ? replica->record : no_record;
      scan.push(replica ? signed_of(replica->scan.value) : -1);
      beta.push(record.inverse_temperature);
      densities.push(record.log_prior, record.log_constraint);
      states.push(replica ? reader.variables(record.state) : std::vector<double>(width, k_nan));
    }
  }
  scan.flush();
  beta.flush();
  densities.flush();
  states.flush();
}

NewestStates newest_states(const RunView& view, std::uint64_t thin, NewestStates plain) {
  if (view.replicas() == 1) return plain;
  NewestStates all(view.chains());
  for (std::uint32_t i = 0; i < view.chains(); ++i) {
    all[i].resize(view.replicas());
    view.for_each_replica(
        base::ChainId{i}, thin,
        [&](base::ReplicaId replica, base::ScanIndex scan, const plan::ScanRecord& record) {
          CHECK_LT(replica.value, view.replicas());
          all[i][replica.value] = NewestState{scan, record};
        });
  }
  return all;
}

void write_report(const plan::Report& report, const WorldLayout& layout, Sink& sink) {
  if (report.empty()) return;
  sink.create_group(k_tempering);
  sink.set_attribute(k_tempering, {"log_natural_throw", layout.log_natural_throw});
  Dims written;
  for (const plan::Table& table : report.tables) {
    Dims dims;
    for (const auto& [name, size] : table.dims) {
      dims.push_back({name, size});
      const auto same = std::ranges::find(written, name, &Dimension::name);
      if (same != written.end()) {
        CHECK_EQ(same->size, size);
        continue;
      }
      written.push_back(dims.back());
      if (name == "proposal_kind") {
        CHECK_EQ(size, layout.proposal_kinds.size());
        write_kinds(sink, k_tempering, dims.back(), layout.proposal_kinds);
      } else {
        write_coordinate(sink, k_tempering, dims.back(), "number of the " + name);
      }
    }
    Column<double> column(sink, k_tempering,
                          spec_of(table.name, ElementType::f64, dims, table.meaning));
    for (const double value : table.values)
      column.push(value);
    column.flush();
  }
}

/// Returns whether draws have weights. Weighted draws don't occur in the model's proportions.
bool has_weights(const plan::Report& report) {
  return std::ranges::any_of(report.tables,
                             [](const plan::Table& table) { return table.name == "log_weight"; });
}

/// Counts how many steps of a part are finished, and reports the count to `hear`.
class Counted {
 public:
  Counted(const HearWriting& hear, WritingProgress::Part part, std::uint64_t total)
      : hear_(hear), now_{.part = part, .done = 0, .total = total} {
    tell();
  }
  void count() {
    ++now_.done;
    tell();
  }

 private:
  void tell() const {
    if (hear_) hear_(now_);
  }
  const HearWriting& hear_;
  WritingProgress now_;
};

void write_animations(DistinctSelector& selector, const StateReader& reader,
                      const ArchiveOptions& options, bool in_proportion, Sink& sink,
                      const HearWriting& hear) {
  sink.create_group(k_animations);
  sink.set_attribute(k_animations, {"keep_max", signed_of(options.keep_max)});
  sink.set_attribute(k_animations, {"keep_per_lineage", signed_of(options.keep_per_lineage)});
  sink.set_attribute(k_animations, {"min_distance", options.min_distance});
  constexpr std::array k_addresses{
      Address{"chain", "chain of the animation"}, Address{"draw", "scan of the animation"},
      Address{"lineage", "number of the visit to the prior from which the state descends"}};
  AnimationsWriter animations(reader, k_animations, "kept animation, by (draw, chain)", k_addresses,
                              in_proportion, sink);
  // The selector has already requested each kept animation's motion; the writer requests the motion
  // again (remembering_reader.h).
  const std::vector<KeptAnimation> all_kept = selector.finish();
  Counted written(hear, WritingProgress::Part::animations, all_kept.size());
  for (const KeptAnimation& kept : all_kept) {
    animations.push({kept.chain.value, signed_of(kept.scan.value), signed_of(kept.record.lineage)},
                    kept.record);
    written.count();
  }
  if (selector.failed() > 0) {
    sink.set_attribute(k_animations,
                       {std::string(k_failed_animations), signed_of(selector.failed())});
  }
  animations.flush();
}

std::string warning_of_finds(const RunView& view) {
  return std::string(view.relax_scans() > 0 ? k_takes_warning : k_finds_warning);
}

/// Writes /finds: the finds of a search. Log densities of blind throws are added for comparison.
void write_finds(const RunView& view, const StateReader& reader, const ArchiveOptions& options,
                 Sink& sink, const HearWriting& hear) {
  if (view.finds() == 0) return;
  sink.create_group(k_finds);
  sink.set_attribute(k_finds, {"keep_max", signed_of(options.keep_max)});
  sink.set_attribute(k_finds, {std::string(k_found), signed_of(view.finds())});
  if (view.relax_scans() > 0)
    sink.set_attribute(k_finds, {std::string(k_relax_scans), signed_of(view.relax_scans())});
  sink.set_attribute(k_finds, {std::string(k_warning), warning_of_finds(view)});
  const std::vector<double> throws = reader.log_priors_of_throws(k_throws);
  const Dims blind_throw{{"throw", throws.size()}};
  write_coordinate(sink, k_finds, blind_throw[0], "blind throw");
  Column<double> log_prior(sink, k_finds,
                           spec_of("log_prior_of_throw", ElementType::f64, blind_throw,
                                   "log density of a blind throw, for comparison with log_prior"));
  for (const double value : throws)
    log_prior.push(value);
  log_prior.flush();

  constexpr std::array k_addresses{
      Address{"start", "number of the search start that led to the find"}};
  AnimationsWriter animations(reader, k_finds, "find, by start", k_addresses, false, sink);
  std::uint64_t kept = 0;
  Counted written(hear, WritingProgress::Part::animations,
                  std::min(view.finds(), options.keep_max));
  view.for_each_find([&](std::uint64_t start, const plan::ScanRecord& record) {
    if (kept++ >= options.keep_max) return;
    animations.push({signed_of(start)}, record);
    written.count();
  });
  animations.flush();
}

void write_root(const WorldLayout& layout, const plan::Report& report, const RunView& view,
                const ArchiveOptions& options, Sink& sink) {
  sink.set_attribute(k_root, {"format", std::string(k_format_name)});
  sink.set_attribute(k_root, {"format_version", k_format_version});
  sink.set_attribute(k_root, {"world", layout.world});
  sink.set_attribute(k_root, {"inference_library", std::string(k_inference_library)});
  sink.set_attribute(k_root,
                     {std::string(k_inference_library_version), options.inference_library_version});
  sink.set_attribute(k_root, {std::string(k_results_version), options.results_version});
  sink.set_attribute(k_root, {std::string(k_run_id), options.run_id});
  const bool is_search = view.draws() == 0;
  const std::string warning = is_search                ? warning_of_finds(view)
                              : layout.warning.empty() ? report.warning
                                                       : layout.warning;
  if (!warning.empty()) sink.set_attribute(k_root, {std::string(k_warning), warning});
  const plan::FailureCounts failures = view.failures();
  for (std::size_t kind = 0; kind < plan::k_failure_kinds; ++kind) {
    if (failures.by_kind[kind] == 0) continue;
    sink.set_attribute(k_root, {failed_attribute(static_cast<plan::FailureKind>(kind)),
                                signed_of(failures.by_kind[kind])});
  }
  DatasetSpec request{.name = std::string(k_request), .type = ElementType::text};
  request.attributes = {{"long_name", std::string("request that reproduces this archive, TOML")}};
  request.text_bytes = options.request_text.size();
  const Sink::DatasetHandle dataset = sink.create_dataset(k_root, request);
  sink.append(dataset, std::span<const std::string>(&options.request_text, 1));
}

}  // namespace

void write_archive(const RunView& view, const StateReader& reader, const ArchiveOptions& options,
                   Sink& sink, const HearWriting& hear) {
  CHECK(view.draws() == 0 ? view.finds() > 0 : view.chains() > 0);
  CHECK_GE(options.thin, 1U);
  CHECK(!options.request_text.empty());
  const plan::Report report = view.report();
  write_root(reader.layout(), report, view, options, sink);

  write_scene(reader.scene(), sink);
  write_prior(view, reader, sink);

  // Visit the run once, chain by chain. Write scalars and states, and offer animations to the
  // selector.
  PosteriorWriter posterior(view, reader, options, sink);
  SampleStatsWriter sample_stats(view, reader.layout(), sink);
  DistinctSelector selector(reader,
                            {options.keep_max, options.keep_per_lineage, options.min_distance});
  NewestStates newest(view.chains(), std::vector<std::optional<NewestState>>(1));
  const std::uint64_t states = archived_states(view, options);
  Counted walked(hear, WritingProgress::Part::draws, view.chains() * view.draws());
  const std::uint64_t newest_scan = states == 0 ? 0 : (states - 1) * options.thin;
  for (std::uint32_t i = 0; i < view.chains(); ++i) {
    const base::ChainId chain{i};
    std::uint64_t draws = 0;
    view.for_each_draw(chain, [&](base::ScanIndex scan, const plan::ScanRecord& record) {
      CHECK_EQ(scan.value, draws++);
      posterior.push(scan, record);
      sample_stats.push(record);
      if (view.may_be_kept(chain, scan)) selector.offer(chain, scan, record);
      if (scan.value == newest_scan) newest[i][0] = NewestState{scan, record};
      walked.count();
    });
    CHECK_EQ(draws, view.draws());
  }
  posterior.flush();
  sample_stats.flush();

  write_replicas(newest_states(view, options.thin, std::move(newest)), reader, sink);
  write_report(report, reader.layout(), sink);

  write_animations(selector, reader, options, !has_weights(report), sink, hear);
  write_finds(view, reader, options, sink, hear);
}

}  // namespace sleight::archive
