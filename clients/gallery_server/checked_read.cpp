#include "clients/gallery_server/checked_read.h"

#include <fmt/format.h>

#include "clients/analysis/archive_rows.h"
#include "common/archive/format.h"
#include "common/base/error.h"

namespace sleight::gallery {

bool has_numbers(const archive::Source& source, std::string_view group, std::string_view dataset,
                 std::uint64_t elements) {
  const archive::Group* found = archive::find_group(source, group);
  const archive::DatasetSpec* spec =
      found == nullptr ? nullptr : archive::find_dataset(*found, dataset);
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
  const archive::Group* group = archive::find_group(source, archive::k_sample_stats_prior);
  const archive::DatasetSpec* draw =
      group == nullptr ? nullptr : archive::find_dataset(*group, "draw");
  if (draw == nullptr || draw->dims.size() != 1) return 0;
  return draw->dims[0].size <= archive::k_prior_draws_max ? draw->dims[0].size : 0;
}

}  // namespace sleight::gallery
