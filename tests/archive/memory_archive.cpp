#include "tests/archive/memory_archive.h"

#include <algorithm>

#include "common/archive/format.h"
#include "common/base/check.h"

namespace sleight::archive {
namespace {

Values no_values(ElementType type) {
  switch (type) {
    case ElementType::f64:
      return std::vector<double>();
    case ElementType::i64:
      return std::vector<std::int64_t>();
    case ElementType::i32:
      return std::vector<std::int32_t>();
    case ElementType::boolean:
      return std::vector<std::int8_t>();
    case ElementType::text:
      return std::vector<std::string>();
  }
  base::check_failed("a known element type", std::to_string(static_cast<int>(type)));
}

}  // namespace

MemoryArchive::MemoryArchive() : groups_{Group{.name = std::string(k_root)}} {}

void MemoryArchive::create_group(std::string_view group) {
  groups_.push_back({.name = std::string(group)});
}

void MemoryArchive::set_attribute(std::string_view group_name, const Attribute& attribute) {
  group(group_name).attributes.push_back(attribute);
}

Sink::DatasetHandle MemoryArchive::create_dataset(std::string_view group_name,
                                                  const DatasetSpec& spec) {
  group(group_name).datasets.push_back(spec);
  places_.push_back({std::string(group_name), spec.name});
  values_.emplace(path_of(group_name, spec.name), no_values(spec.type));
  return places_.size() - 1;
}

void MemoryArchive::append(DatasetHandle dataset, const ValuesView& values) {
  CHECK_LT(dataset, places_.size());
  Values& held = values_.at(path_of(places_[dataset].group, places_[dataset].dataset));
  CHECK_EQ(held.index(), values.index());
  std::visit(
      [&held](const auto& span) {
        using Element = typename std::decay_t<decltype(span)>::value_type;
        auto& vector = std::get<std::vector<Element>>(held);
        vector.insert(vector.end(), span.begin(), span.end());
      },
      values);
}

void MemoryArchive::finish() {
  for (Group& group : groups_) {
    for (DatasetSpec& spec : group.datasets) {
      if (spec.dims.empty() || spec.dims.front().size != k_growing) continue;
      spec.dims.front().size = 1;
      const std::uint64_t row = element_count(spec);
      const std::uint64_t held = count_of(view_of(values_.at(path_of(group.name, spec.name))));
      spec.dims.front().size = row == 0 ? 0 : held / row;
    }
  }
}

Values MemoryArchive::read(std::string_view group_name, std::string_view dataset,
                           std::uint64_t first, std::uint64_t count) const {
  const auto found = values_.find(path_of(group_name, dataset));
  CHECK(found != values_.end());
  return std::visit(
      [first, count](const auto& vector) -> Values {
        CHECK_LE(first, vector.size());
        CHECK_LE(count, vector.size() - first);
        const auto begin = vector.begin() + static_cast<std::ptrdiff_t>(first);
        return std::decay_t<decltype(vector)>(begin, begin + static_cast<std::ptrdiff_t>(count));
      },
      found->second);
}

Values& MemoryArchive::values(std::string_view group_name, std::string_view dataset) {
  return values_.at(path_of(group_name, dataset));
}

Group& MemoryArchive::group(std::string_view name) {
  const auto found = std::ranges::find(groups_, name, &Group::name);
  CHECK(found != groups_.end());
  return *found;
}

}  // namespace sleight::archive
