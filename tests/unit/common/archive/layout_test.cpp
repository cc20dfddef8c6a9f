// Goal: an archive holds each value of a run in its dataset, and the digest depends only on the
// content. Method: write a made-up run into an in-memory archive, and compare the values with the
// run.
#include "common/archive/layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/archive/digest/digest.h"
#include "common/archive/digest/verify.h"
#include "common/archive/format.h"
#include "common/archive/summary.h"
#include "tests/archive/memory_archive.h"
#include "tests/unit/common/archive/fake_world.h"

namespace sleight::archive {
namespace {

using testing::FakeReader;
using testing::FakeRun;
using testing::FakeRunOptions;
using testing::filler;
using testing::options_for;

bool same(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}

template <class Element>
Element one(const Source& source, std::string_view group, std::string_view name,
            std::uint64_t place) {
  return std::get<std::vector<Element>>(source.read(group, name, place, 1)).at(0);
}

std::vector<std::string> dims_of(const Source& source, std::string_view group,
                                 std::string_view name) {
  std::vector<std::string> names;
  for (const Dimension& dim : find_dataset(*find_group(source, group), name)->dims) {
    names.push_back(dim.name + "=" + std::to_string(dim.size));
  }
  return names;
}

TEST(Layout, HoldsWhatATemperedRunLearntAndEachReplicasState) {
  // Goal: the archive of a tempered run holds the method's tables, the method's warning, and the
  // newest state of each replica. If a replica has no state, its values are NaN.
  const FakeRunOptions options;
  const testing::FakeTemperedRun run(options);
  MemoryArchive archive;
  write_digested(archive,
                 [&](Sink& sink) { write_archive(run, FakeReader(), options_for(options), sink); });
  EXPECT_THAT(verify(archive), ::testing::IsEmpty());
  EXPECT_THAT(dims_of(archive, k_tempering, "barrier"),
              ::testing::ElementsAre("chain=3", "round=2"));
  EXPECT_EQ(one<double>(archive, k_tempering, "barrier", 3), 4);
  EXPECT_TRUE(std::isnan(one<double>(archive, k_tempering, "barrier", 5)));
  EXPECT_EQ(one<double>(archive, k_tempering, "acceptance", 4), 4);
  EXPECT_EQ(one<std::string>(archive, k_tempering, "proposal_kind", 1), "one_normal");
  EXPECT_EQ(std::get<std::string>(
                find_attribute(find_group(archive, k_root)->attributes, k_warning)->value),
            "draws have weights");
  const auto scans = std::get<std::vector<std::int64_t>>(archive.read(k_replicas, "scan", 0, 6));
  EXPECT_THAT(scans, ::testing::ElementsAre(10, -1, 10, 20, 10, 20));
  EXPECT_EQ(one<double>(archive, k_replicas, "inverse_temperature", 2), 0.25);
  EXPECT_TRUE(std::isnan(one<double>(archive, k_replicas, "height_m", 1)));
}

TEST(Layout, HoldsEveryScanAndEveryThinnedState) {
  const FakeRunOptions options;
  MemoryArchive archive;
  write_digested(archive, filler(options));
  const FakeRun run(options);
  const FakeReader reader;
  EXPECT_THAT(dims_of(archive, k_posterior, "spin_radps"),
              ::testing::ElementsAre("chain=3", "draw=11", "collision=3", "axis=2"));
  EXPECT_THAT(dims_of(archive, k_sample_stats, "proposed"),
              ::testing::ElementsAre("chain=3", "draw=101", "proposal_kind=2"));
  for (std::uint32_t chain = 0; chain < 3; ++chain) {
    for (std::uint64_t scan = 0; scan < 101; ++scan) {
      const plan::ScanRecord record = run.record({chain}, scan);
      const std::uint64_t place = chain * 101 + scan;
      EXPECT_EQ(one<double>(archive, k_sample_stats, "lp", place),
                record.log_prior + record.log_constraint);
      EXPECT_EQ(one<std::int8_t>(archive, k_sample_stats, "satisfied", place), record.satisfied);
      EXPECT_EQ(one<double>(archive, k_sample_stats, "bounces", place), record.outcome[1]);
      EXPECT_EQ(one<std::int32_t>(archive, k_sample_stats, "accepted", 2 * place + 1),
                static_cast<std::int32_t>(record.accepted[1]));
      EXPECT_EQ(std::isnan(one<double>(archive, k_sample_stats, "acceptance_rate", place)),
                scan == 0);
      if (scan % 10 != 0) continue;
      const std::vector<double> values = reader.variables(record.state);
      const std::uint64_t draw = chain * 11 + scan / 10;
      EXPECT_EQ(one<std::int64_t>(archive, k_posterior, "draw", scan / 10),
                static_cast<std::int64_t>(scan));
      EXPECT_TRUE(same(one<double>(archive, k_posterior, "height_m", draw), values[0]));
      EXPECT_TRUE(same(one<double>(archive, k_posterior, "normal_rad", 3 * draw + 2), values[3]));
      EXPECT_TRUE(same(one<double>(archive, k_posterior, "spin_radps", 6 * draw + 5), values[9]));
    }
  }
}

TEST(Layout, ReplicasAreTheLastArchivedStates) {
  FakeRunOptions options;
  options.scans = 95;  // the last multiple of thin = 10 is 90
  MemoryArchive archive;
  write_digested(archive, filler(options));
  for (std::uint32_t chain = 0; chain < 3; ++chain) {
    EXPECT_EQ(one<std::int64_t>(archive, k_replicas, "scan", chain), 90);
    EXPECT_EQ(one<double>(archive, k_replicas, "log_prior", chain),
              FakeRun(options).record({chain}, 90).log_prior);
  }
}

TEST(Layout, AnimationsCarryTheirMotion) {
  const FakeRunOptions options;
  MemoryArchive archive;
  write_digested(archive, filler(options));
  const FakeRun run(options);
  const FakeReader reader;
  const std::uint64_t animations =
      find_dataset(*find_group(archive, k_animations), "animation")->dims[0].size;
  ASSERT_EQ(animations, 20U);
  for (std::uint64_t i = 0; i < animations; ++i) {
    const auto chain = one<std::int64_t>(archive, k_animations, "chain", i);
    const auto draw = one<std::int64_t>(archive, k_animations, "draw", i);
    const plan::ScanRecord record =
        run.record({static_cast<std::uint32_t>(chain)}, static_cast<std::uint64_t>(draw));
    const std::vector<motion::Segment> segments = reader.play(record.state).segments;
    const auto start =
        static_cast<std::uint64_t>(one<std::int64_t>(archive, k_animations, "segment_start", i));
    ASSERT_EQ(one<std::int64_t>(archive, k_animations, "segment_count", i),
              static_cast<std::int64_t>(segments.size()));
    for (std::uint64_t row = 0; row < segments.size(); ++row) {
      const motion::Segment& segment = segments[row];
      EXPECT_EQ(one<double>(archive, k_animations, "start_s", start + row), segment.start_s);
      EXPECT_EQ(one<double>(archive, k_animations, "position_m", 3 * (start + row) + 1),
                segment.position_m.y());
      EXPECT_EQ(one<std::int32_t>(archive, k_animations, "partner", start + row), segment.partner);
    }
    EXPECT_EQ(one<std::int8_t>(archive, k_animations, "in_proportion", i), 1);
  }
}

/// Returns the values' bits, so that NaN equals NaN.
std::string bits_of(const Values& values) {
  return std::visit(
      [](const auto& elements) {
        std::string bits;
        for (const auto& element : elements) {
          if constexpr (std::is_same_v<std::decay_t<decltype(element)>, std::string>)
            bits += element + '\0';
          else
            bits.append(reinterpret_cast<const char*>(&element), sizeof(element));
        }
        return bits;
      },
      values);
}

TEST(Layout, FindsLieBesideDraws) {
  // Goal: finds are stored in their own group and don't change draws or animations. Method: write
  // the archive of a run twice, with finds and without finds, and compare both. Also write the
  // archive of a search; a search has no chains.
  const FakeRunOptions options{.finds = 6};
  const FakeRun run(options);
  MemoryArchive archive;
  write_digested(archive, filler(options));
  MemoryArchive without;
  write_digested(without, filler({}));
  for (const std::string_view group : {k_posterior, k_sample_stats, k_animations}) {
    for (const DatasetSpec& spec : find_group(without, group)->datasets) {
      EXPECT_EQ(bits_of(archive.values(group, spec.name)),
                bits_of(without.values(group, spec.name)))
          << spec.name;
    }
  }
  EXPECT_EQ(find_group(without, k_finds), nullptr);
  const Summary summary = summary_of(archive);
  EXPECT_EQ(summary.format_version, k_format_version);
  EXPECT_EQ(summary.results_version, "0123456789abcdef");
  EXPECT_EQ(summary.run_id, "fake run");
  EXPECT_EQ(summary.finds.found, 6U);
  EXPECT_EQ(summary.finds.animations, 6U);
  EXPECT_EQ(summary.warning, "");
  EXPECT_EQ(one<std::int64_t>(archive, k_finds, "start", 5), 10);
  EXPECT_EQ(one<double>(archive, k_finds, "log_prior", 2), run.record({9}, 20).log_prior);
  EXPECT_EQ(find_dataset(*find_group(archive, k_finds), "log_prior_of_throw")->dims[0].size,
            k_throws);

  MemoryArchive search;
  write_digested(search, filler({.chains = 0, .scans = 0, .finds = 3}));
  EXPECT_EQ(summary_of(search).finds.animations, 3U);
  EXPECT_EQ(summary_of(search).scans, 0U);
  EXPECT_EQ(summary_of(search).warning, k_finds_warning);
}

TEST(Layout, SmallestRuns) {
  for (const double share : {0.0, 1.0}) {
    MemoryArchive archive;
    const FakeRunOptions options{.chains = 1, .scans = 1, .thin = 7, .satisfied_share = share};
    const std::string digest_written = write_digested(archive, filler(options));
    EXPECT_EQ(digest(archive), digest_written);
    const Summary summary = summary_of(archive);
    EXPECT_EQ(summary.format_version, k_format_version);
    EXPECT_EQ(summary.results_version, "0123456789abcdef");
    EXPECT_EQ(summary.run_id, "fake run");
    EXPECT_EQ(summary.scans, 1U);
    EXPECT_EQ(summary.states, 1U);
    EXPECT_EQ(summary.animations, share > 0 ? 1U : 0U);
    EXPECT_EQ(summary.content_digest, digest_written);
    EXPECT_EQ(summary.request_text, options_for(options).request_text);
    EXPECT_EQ(summary.thin, 7);
  }
}

TEST(Layout, AWarningIsKept) {
  // Goal: the archive contains the world's warning about its samples, and the digest depends on the
  // warning.
  const FakeRunOptions options;
  const auto archived = [&](MemoryArchive& archive, const std::string& warning) {
    return write_digested(archive, [&](Sink& sink) {
      write_archive(FakeRun(options), FakeReader(warning), options_for(options), sink);
    });
  };
  MemoryArchive plain;
  MemoryArchive biased;
  EXPECT_NE(archived(plain, ""), archived(biased, "biased kernel"));
  EXPECT_EQ(summary_of(plain).warning, "");
  EXPECT_EQ(find_attribute(plain.group(k_root).attributes, k_warning), nullptr);
  EXPECT_EQ(summary_of(biased).warning, "biased kernel");
  EXPECT_THAT(verify(biased), ::testing::IsEmpty());
}

class FailedRun : public FakeRun {
 public:
  FailedRun(const FakeRunOptions& options, const plan::FailureCounts& failures)
      : FakeRun(options), failures_(failures) {}
  plan::FailureCounts failures() const override { return failures_; }

 private:
  plan::FailureCounts failures_;
};

TEST(Layout, FailuresAreCountedByKindAndOnlyWhereThereAreSome) {
  // Goal: the archive has an attribute with the number of failures of each kind, and the digest
  // depends on these numbers. If a run has no failures, the attribute is missing.
  const FakeRunOptions options;
  const auto archived = [&](MemoryArchive& archive, const plan::FailureCounts& failures) {
    return write_digested(archive, [&](Sink& sink) {
      write_archive(FailedRun(options, failures), FakeReader(), options_for(options), sink);
    });
  };
  MemoryArchive without;
  MemoryArchive plain;
  EXPECT_EQ(archived(without, {}), write_digested(plain, filler(options)));
  for (const Attribute& attribute : without.group(k_root).attributes)
    EXPECT_FALSE(attribute.name.starts_with(k_failed_prefix)) << attribute.name;
  EXPECT_EQ(summary_of(without).failures.total(), 0U);

  const plan::FailureCounts failures{.by_kind = {2, 0, 0, 0, 1, 0}};
  const plan::FailureCounts more{.by_kind = {3, 0, 0, 0, 1, 0}};
  MemoryArchive failed;
  MemoryArchive failed_more;
  EXPECT_NE(archived(failed, failures), archived(failed_more, more));
  EXPECT_EQ(summary_of(failed).failures, failures);
  EXPECT_EQ(plan::to_string(failures), "search_gave_up 2, work_limit 1");
  EXPECT_THAT(verify(failed), ::testing::IsEmpty());
  const Attribute* count = find_attribute(failed.group(k_root).attributes, "failed_work_limit");
  ASSERT_NE(count, nullptr);
  EXPECT_EQ(std::get<std::int64_t>(count->value), 1);
}

class StuckReader : public FakeReader {
 public:
  Motion play(base::BytesView state) const override {
    if (key_of(state) % 2 != 0) return {.ends = PlaysOut::failed};
    return FakeReader::play(state);
  }
};

TEST(Layout, AnimationsThatFailAreCounted) {
  // Goal: if a satisfying animation can't be simulated to its end, it is counted but not kept.
  // Method: use a reader that fails for half of the motions. Then use a reader that never fails.
  const FakeRunOptions options;
  MemoryArchive stuck;
  write_digested(stuck, [&](Sink& sink) {
    write_archive(FakeRun(options), StuckReader(), options_for(options), sink);
  });
  MemoryArchive plain;
  write_digested(plain, filler(options));
  EXPECT_GT(summary_of(stuck).failed_animations, 0U);
  EXPECT_GT(summary_of(stuck).animations, 0U);
  EXPECT_THAT(verify(stuck), ::testing::IsEmpty());
  EXPECT_EQ(summary_of(plain).failed_animations, 0U);
  EXPECT_EQ(find_attribute(plain.group(k_animations).attributes, k_failed_animations), nullptr);
}

TEST(Digest, CoversContentAndLeavesOutTheVersion) {
  const FakeRunOptions options;
  MemoryArchive archive;
  const std::string before = write_digested(archive, filler(options));
  int left_out = 0;
  for (Attribute& attribute : archive.group(k_root).attributes) {
    if (attribute.name != k_inference_library_version && attribute.name != k_results_version &&
        attribute.name != k_run_id)
      continue;
    attribute.value = std::string("another version");
    ++left_out;
  }
  EXPECT_EQ(left_out, 3);
  EXPECT_EQ(digest(archive), before);

  // Each kind of change alters the digest. Undoing the change restores the digest.
  const auto changed = [&](auto&& change, auto&& undo) {
    change();
    EXPECT_NE(digest(archive), before);
    undo();
    EXPECT_EQ(digest(archive), before);
  };
  auto& lp = std::get<std::vector<double>>(archive.values(k_sample_stats, "lp"));
  changed([&] { std::swap(lp[3], lp[4]); }, [&] { std::swap(lp[3], lp[4]); });
  Group& posterior = archive.group(k_posterior);
  changed([&] { posterior.attributes[0].name = "thinned"; },
          [&] { posterior.attributes[0].name = "thin"; });
  DatasetSpec& normal = posterior.datasets.back();
  changed([&] { normal.attributes[1].value = "deg"; },
          [&] { normal.attributes[1].value = "rad/s"; });
  changed([&] { normal.dims[3].name = "side"; }, [&] { normal.dims[3].name = "axis"; });
}

TEST(Digest, IgnoresOrderOfCreationAndNanPayloads) {
  const auto fill = [](bool swapped, double nan) {
    return [swapped, nan](Sink& sink) {
      const auto put = [&](const char* name) {
        const auto handle = sink.create_dataset(k_root, {.name = name, .type = ElementType::f64});
        sink.append(handle, std::span<const double>(&nan, 1));
      };
      put(swapped ? "b" : "a");
      put(swapped ? "a" : "b");
    };
  };
  MemoryArchive first;
  MemoryArchive second;
  const double other_nan = std::bit_cast<double>(std::uint64_t{0xfff0000000000123});
  EXPECT_EQ(write_digested(first, fill(false, std::nan(""))),
            write_digested(second, fill(true, other_nan)));
  EXPECT_EQ(manifest(first), manifest(second));
}

TEST(DigestDeathTest, IncompleteArchivesAreBugs) {
  MemoryArchive archive;
  const auto incomplete = [](Sink& sink) {
    sink.create_dataset(k_root, {.name = "x", .dims = {{"x", 2}}});
  };
  EXPECT_DEATH(write_digested(archive, incomplete), "check failed");
  const auto without_coordinate = [](Sink& sink) {
    const auto handle = sink.create_dataset(k_root, {.name = "x", .dims = {{"y", 1}}});
    const double value = 1;
    sink.append(handle, std::span<const double>(&value, 1));
  };
  EXPECT_DEATH(write_digested(archive, without_coordinate), "coordinate");
}

TEST(Layout, SaysHowFarItIs) {
  // Goal: the writer reports its progress through each part of the archive, in order. Reports don't
  // change the archive.
  const FakeRunOptions run{.chains = 3, .scans = 50, .thin = 5};
  std::vector<WritingProgress> heard;
  MemoryArchive told;
  const std::string digest = write_digested(told, [&](Sink& sink) {
    write_archive(FakeRun(run), FakeReader(), options_for(run), sink,
                  [&](const WritingProgress& now) { heard.push_back(now); });
  });
  MemoryArchive silent;
  EXPECT_EQ(write_digested(silent, testing::filler(run)), digest);
  ASSERT_FALSE(heard.empty());
  std::uint64_t draws = 0;
  std::uint64_t animations = 0;
  for (std::size_t i = 0; i < heard.size(); ++i) {
    EXPECT_LE(heard[i].done, heard[i].total);
    if (i > 0) {
      EXPECT_GE(heard[i].part, heard[i - 1].part);
    }
    if (heard[i].part == WritingProgress::Part::draws) draws = heard[i].done;
    if (heard[i].part == WritingProgress::Part::animations) animations = heard[i].done;
  }
  EXPECT_EQ(draws, 150U);
  EXPECT_EQ(animations, find_dataset(*find_group(told, k_animations), "animation")->dims[0].size);
}

}  // namespace
}  // namespace sleight::archive
