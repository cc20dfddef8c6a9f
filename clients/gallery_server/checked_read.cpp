#include "clients/gallery_server/checked_read.h"

#include <fmt/format.h>

#include "clients/analysis/archive_rows.h"
#include "common/archive/format.h"
#include "common/base/error.h"

namespace sleight::gallery {

const archive::DatasetSpec* dataset_of(const archive::Source& source, std::string_view group,
                                       std::string_view dataset) {
  const archive::Group* found = archive::find_group(source, group);
  return found == nullptr ? nullptr : archive::find_dataset(*found, dataset);
}

bool has_numbers(const archive::Source& source, std::string_view group, std::string_view dataset,
                 std::uint64_t elements) {
  const archive::DatasetSpec* spec = dataset_of(source, group, dataset);
  return spec != nullptr && spec->type != archive::ElementType::text &&
         archive::element_count(*spec) == elements;
}

std::vector<double> checked_numbers(const archive::Source& source, std::string_view group,
                                    std::string_view dataset, std::uint64_t elements,
                                    std::uint64_t first, std::uint64_t count) {
  if (!has_numbers(source, group, dataset, elements)) {
    throw base::Error(base::ExitCode::bad_archive,
                      fmt::format("{}: {} is missing or has an unexpected shape", source.name(),
                                  archive::path_of(group, dataset)));
  }
  return analysis::as_doubles(source.read(group, dataset, first, count));
}

std::uint64_t prior_draws_of(const archive::Source& source) {
  const archive::DatasetSpec* draw = dataset_of(source, archive::k_sample_stats_prior, "draw");
  if (draw == nullptr || draw->dims.size() != 1) return 0;
  return draw->dims[0].size <= archive::k_prior_draws_max ? draw->dims[0].size : 0;
}

}  // namespace sleight::gallery
