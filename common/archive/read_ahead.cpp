#include "common/archive/read_ahead.h"

#include <algorithm>
#include <variant>

#include "common/base/error.h"

namespace sleight::archive {
namespace {

Values part_of(const Values& block, std::uint64_t first, std::uint64_t count) {
  return std::visit(
      [&](const auto& values) -> Values {
        const auto begin = values.begin() + static_cast<std::ptrdiff_t>(first);
        return std::decay_t<decltype(values)>(begin, begin + static_cast<std::ptrdiff_t>(count));
      },
      block);
}

/// Returns a dataset's number of elements, or 0 for texts, which may be too long to read ahead.
std::uint64_t elements_of(const Source& source, std::string_view group, std::string_view dataset) {
  const Group* in = find_group(source, group);
  const DatasetSpec* spec = in == nullptr ? nullptr : find_dataset(*in, dataset);
  return spec == nullptr || spec->type == ElementType::text ? 0 : element_count(*spec);
}

}  // namespace

Values ReadAhead::read(std::string_view group, std::string_view dataset, std::uint64_t first,
                       std::uint64_t count) const {
  if (count == 0 || count >= k_read_ahead) return source_->read(group, dataset, first, count);
  Reading& reading = readings_[path_of(group, dataset)];
  const bool goes_on = first == reading.next && reading.next > 0;
  reading.next = first + count;
  const bool is_there = first >= reading.begin && first + count <= reading.end;
  if (is_there) return part_of(reading.block, first - reading.begin, count);
  const std::uint64_t elements = goes_on ? elements_of(*source_, group, dataset) : 0;
  if (first + count <= elements) {
    try {
      const std::uint64_t ahead = std::min(k_read_ahead, elements - first);
      reading.end = reading.begin;
      reading.block = source_->read(group, dataset, first, ahead);
      reading.begin = first;
      reading.end = first + ahead;
      return part_of(reading.block, 0, count);
    } catch (const base::Error&) {
      // Some part of the block is damaged, but the requested range may be intact.
    }
  }
  return source_->read(group, dataset, first, count);
}

}  // namespace sleight::archive
