#include "service/coordinator/derive.h"

#include <fmt/format.h>

#include <optional>
#include <span>
#include <utility>

#include "common/archive/format.h"
#include "common/archive/hdf5/writer.h"
#include "common/archive/remembering_reader.h"
#include "common/base/clock.h"
#include "common/base/version.h"
#include "common/hash/sha256.h"
#include "common/store/stored_motions.h"
#include "common/store/stored_run.h"

namespace sleight::coordinator {
namespace {

/// Forwards an archive to another sink. Between batches, checks whether to stop.
class StoppableSink final : public archive::Sink {
 public:
  StoppableSink(archive::Sink& sink, std::function<void()> ask)
      : sink_(sink), ask_(std::move(ask)) {}

  void create_group(std::string_view path) override { sink_.create_group(path); }
  void set_attribute(std::string_view group, const archive::Attribute& attribute) override {
    sink_.set_attribute(group, attribute);
  }
  DatasetHandle create_dataset(std::string_view group, const archive::DatasetSpec& spec) override {
    ask_();
    return sink_.create_dataset(group, spec);
  }
  void append(DatasetHandle dataset, const archive::ValuesView& values) override {
    ask_();
    sink_.append(dataset, values);
  }
  void finish() override {
    ask_();
    sink_.finish();
  }

 private:
  archive::Sink& sink_;
  std::function<void()> ask_;
};

static_assert(request::k_prior_draws <= archive::k_prior_draws_max);

/// Runs `work` and adds its processor time to `*total_s`, unless that is null.
template <class Work>
auto timed(double* total_s, const Work& work) {
  const double begin_s = base::thread_processor_s();
  auto result = work();
  if (total_s != nullptr) *total_s += base::thread_processor_s() - begin_s;
  return result;
}

/// Measures the processor time for simulating motions. Each motion is simulated once per run.
class TimedReader final : public archive::ForwardingReader {
 public:
  TimedReader(const archive::StateReader& reader, double* motions_s)
      : ForwardingReader(reader), motions_s_(motions_s) {}

  archive::Motion play(base::BytesView state) const override {
    return timed(motions_s_, [&] { return ForwardingReader::play(state); });
  }

 private:
  double* motions_s_;
};

/// Returns a text that contains everything on which saved motions depend, except the states.
std::string owner_of_motions(const request::DirectionRequest& request) {
  return fmt::format("{}\n{}", base::version(), request::identity_text(request));
}

/// Returns an id that all archives of a run share, whatever their cut and whichever process derived
/// them.
std::string run_id(const request::DirectionRequest& request, const std::string& results_version) {
  return hash::sha256_hex(fmt::format("{}\n{}", run_identity(request), results_version));
}

/// Passes the cut's scans to a fresh plan. The plan learns from these scans again.
void teach(plan::Plan& learner, const store::StoredRun& view, const std::function<void()>& ask,
           const archive::HearWriting& hear) {
  archive::WritingProgress now{.part = archive::WritingProgress::Part::learning};
  view.replay([&](const plan::ReplicaKey& replica, base::ScanIndex first,
                  std::span<const plan::ScanRecord> records) {
    ask();
    learner.consume(replica, first, records);
    now.done += records.size();
    if (hear) hear(now);
  });
}

}  // namespace

std::string run_identity(const request::DirectionRequest& request) {
  return fmt::format("{}\n[output]\nthin = {}\n", request::identity_text(request),
                     request.output.thin);
}

std::string derive_archive(const DeriveInputs& inputs, const std::string& folder,
                           const std::string& output, request::Cut& cut,
                           const std::function<bool()>& stop) {
  const auto ask = [&stop, &inputs] {
    if (stop && stop()) throw DeriveStopped();
    if (inputs.fence) inputs.fence();
  };

  // Determine which scans of the cut are draws, and what the method learned from them.
  const auto run_store = inputs.store ? inputs.store : store::open_to_read(folder);
  const auto view_of = [&](std::uint32_t chains) {
    const bool has_takes = cut.relaxed > 0;
    return store::StoredRun(
        run_store, {.chains = chains,
                    .scans = cut.scans,
                    .finds = has_takes ? cut.relaxed : cut.found,
                    .relax_scans = has_takes ? inputs.request.sampler.relax_scans.value() : 0,
                    .prior_draws = cut.prior_draws,
                    .of_islands = cut.scans > 0 && inputs.request.stop.odds.has_value()});
  };
  std::optional<store::StoredRun> view(view_of(inputs.request.sampler.chains));
  if (cut.scans > 0) {
    const std::unique_ptr<plan::Plan> learner = inputs.plan_of(cut);
    if (learner->learns()) {
      teach(*learner, *view, ask, inputs.hear);
      view->set_report(learner->report());
      view->set_draws(learner->draws());
    }
  }
  if (view->draws() == 0) {
    cut.scans = 0;
    if (cut.found == 0) return {};
    view.emplace(view_of(0));
  }

  // Write the draws and their motions. A motion is read if it is saved, otherwise simulated.
  const request::OutputParameters& keep = inputs.request.output;
  const archive::ArchiveOptions options{
      .request_text = request::normalised_text_of(inputs.request, cut),
      .thin = keep.thin,
      .keep_max = keep.keep_max,
      .keep_per_lineage = keep.keep_per_lineage,
      .min_distance = keep.min_distance,
      .inference_library_version = std::string(base::version()),
      .results_version = inputs.results_version,
      .run_id = run_id(inputs.request, inputs.results_version)};
  store::StoredMotions motions(folder, owner_of_motions(inputs.request));
  const TimedReader timed(inputs.reader, inputs.motions_s);
  const archive::RememberingReader reader(timed, motions, ask);
  return archive::hdf5::write_file(output, inputs.files, [&](archive::Sink& file) {
    StoppableSink sink(file, ask);
    archive::write_archive(*view, reader, options, sink, inputs.hear);
  });
}

request::Cut committed_cut(const std::string& folder, plan::Plan& fresh_plan) {
  const auto run_store = store::open_to_read(folder);
  store::for_each_stored(*run_store, [&](const plan::ReplicaKey& replica, base::ScanIndex first,
                                         std::span<const plan::ScanRecord> records) {
    fresh_plan.consume(replica, first, records);
  });
  return cut_of(fresh_plan);
}

}  // namespace sleight::coordinator
