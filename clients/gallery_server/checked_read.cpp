#include "clients/gallery_server/checked_read.h"

#include <fmt/format.h>

#include "clients/cli/trace.h"
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
                      fmt::format("{}: {}: missing, or of another shape than expected",
                                  source.name(), archive::path_of(group, dataset)));
  }
  return cli::as_doubles(source.read(group, dataset, first, count));
}

}  // namespace sleight::gallery
