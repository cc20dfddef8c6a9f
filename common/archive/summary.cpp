#include "common/archive/summary.h"

#include <fmt/format.h>

#include "common/archive/format.h"

namespace sleight::archive {
namespace {

const Group& group_of(const Source& source, std::string_view name) {
  const Group* group = find_group(source, name);
  if (group == nullptr) refuse_archive(source, fmt::format("the group {} is missing", name));
  return *group;
}

template <class T>
T attribute_of(const Source& source, std::string_view group, std::string_view name) {
  const Attribute* attribute = find_attribute(group_of(source, group).attributes, name);
  const T* value = attribute == nullptr ? nullptr : std::get_if<T>(&attribute->value);
  if (value == nullptr) {
    refuse_archive(
        source, fmt::format("{}: the attribute {} is missing or has the wrong type", group, name));
  }
  return *value;
}

std::string warning_of(const Source& source) {
  if (find_attribute(group_of(source, k_root).attributes, k_warning) == nullptr) return {};
  return attribute_of<std::string>(source, k_root, k_warning);
}

/// Returns the number of failures. If the attribute is absent, the number is 0.
std::uint64_t count_of_failures(const Source& source, std::string_view group,
                                std::string_view name) {
  if (find_attribute(group_of(source, group).attributes, name) == nullptr) return 0;
  const auto count = attribute_of<std::int64_t>(source, group, name);
  if (count < 1)
    refuse_archive(source, fmt::format("{}: expected at least 1, found {}", name, count));
  return static_cast<std::uint64_t>(count);
}

plan::FailureCounts failures_of(const Source& source) {
  plan::FailureCounts counts;
  for (std::size_t kind = 0; kind < plan::k_failure_kinds; ++kind) {
    counts.by_kind[kind] =
        count_of_failures(source, k_root, failed_attribute(static_cast<plan::FailureKind>(kind)));
  }
  return counts;
}

std::uint64_t size_of(const Source& source, std::string_view group, std::string_view dim) {
  const DatasetSpec* coordinate = find_dataset(group_of(source, group), dim);
  if (coordinate == nullptr || coordinate->dims.size() != 1) {
    refuse_archive(source, fmt::format("{}: the coordinate {} is missing", group, dim));
  }
  return coordinate->dims[0].size;
}

FindsSummary finds_of(const Source& source) {
  if (find_group(source, k_finds) == nullptr) return {};
  const auto found = attribute_of<std::int64_t>(source, k_finds, k_found);
  if (found < 1)
    refuse_archive(source,
                   fmt::format("/finds: the attribute found is {}, but must be at least 1", found));
  std::int64_t relax_scans = 0;
  if (find_attribute(group_of(source, k_finds).attributes, k_relax_scans) != nullptr)
    relax_scans = attribute_of<std::int64_t>(source, k_finds, k_relax_scans);
  if (relax_scans < 0)
    refuse_archive(source,
                   fmt::format("/finds: the attribute relax_scans is {}, but must be at least 0",
                               relax_scans));
  return {.found = static_cast<std::uint64_t>(found),
          .relax_scans = static_cast<std::uint64_t>(relax_scans),
          .animations = size_of(source, k_finds, "animation"),
          .segments = size_of(source, k_finds, "segment")};
}

std::string request_of(const Source& source) {
  const DatasetSpec* request = find_dataset(group_of(source, k_root), k_request);
  if (request == nullptr || request->type != ElementType::text || !request->dims.empty()) {
    refuse_archive(source, "/request is missing or is not a scalar text");
  }
  return std::get<std::vector<std::string>>(source.read(k_root, k_request, 0, 1)).at(0);
}

}  // namespace

Summary summary_of(const Source& source) {
  return {
      .format_version = attribute_of<std::int64_t>(source, k_root, "format_version"),
      .world = attribute_of<std::string>(source, k_root, "world"),
      .inference_library_version =
          attribute_of<std::string>(source, k_root, k_inference_library_version),
      .results_version = attribute_of<std::string>(source, k_root, k_results_version),
      .run_id = attribute_of<std::string>(source, k_root, k_run_id),
      .content_digest = attribute_of<std::string>(source, k_root, k_content_digest),
      .warning = warning_of(source),
      .request_text = request_of(source),
      .chains = size_of(source, k_sample_stats, "chain"),
      .scans = size_of(source, k_sample_stats, "draw"),
      .states = size_of(source, k_posterior, "draw"),
      .thin = attribute_of<std::int64_t>(source, k_posterior, "thin"),
      .keep_max = attribute_of<std::int64_t>(source, k_animations, "keep_max"),
      .keep_per_lineage = attribute_of<std::int64_t>(source, k_animations, "keep_per_lineage"),
      .animations = size_of(source, k_animations, "animation"),
      .segments = size_of(source, k_animations, "segment"),
      .failures = failures_of(source),
      .failed_animations = count_of_failures(source, k_animations, k_failed_animations),
      .finds = finds_of(source),
  };
}

}  // namespace sleight::archive
