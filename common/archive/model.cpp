#include "common/archive/model.h"

#include <algorithm>

#include <fmt/format.h>

#include "common/archive/format.h"
#include "common/base/check.h"
#include "common/base/error.h"

namespace sleight::archive {

std::string_view name_of(ElementType type) {
  switch (type) {
    case ElementType::f64:
      return "f64";
    case ElementType::i64:
      return "i64";
    case ElementType::i32:
      return "i32";
    case ElementType::boolean:
      return "bool";
    case ElementType::text:
      return "text";
  }
  base::check_failed("the element type is known", std::to_string(static_cast<int>(type)));
}

ElementType type_of(const ValuesView& values) {
  return static_cast<ElementType>(values.index());
}

std::size_t count_of(const ValuesView& values) {
  return std::visit([](const auto& span) { return span.size(); }, values);
}

ValuesView view_of(const Values& values) {
  return std::visit(
      [](const auto& vector) -> ValuesView {
        using Element = typename std::decay_t<decltype(vector)>::value_type;
        return std::span<const Element>(vector);
      },
      values);
}

std::uint64_t element_count(const DatasetSpec& spec) {
  std::uint64_t product = 1;
  for (const Dimension& dim : spec.dims) {
    CHECK_NE(dim.size, k_growing);
    CHECK(!__builtin_mul_overflow(product, dim.size, &product));
  }
  return product;
}

std::string path_of(std::string_view group, std::string_view dataset) {
  std::string path(group);
  if (path != k_root) path += '/';
  return path.append(dataset);
}

bool is_plain_name(std::string_view name) {
  constexpr std::string_view allowed =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.-";
  if (name.empty() || name.size() > k_name_bytes_max || name == "." || name == "..") return false;
  return name.find_first_not_of(allowed) == std::string_view::npos;
}

const Attribute* find_attribute(const std::vector<Attribute>& attributes, std::string_view name) {
  const auto found = std::ranges::find(attributes, name, &Attribute::name);
  return found == attributes.end() ? nullptr : &*found;
}

const DatasetSpec* find_dataset(const Group& group, std::string_view name) {
  const auto found = std::ranges::find(group.datasets, name, &DatasetSpec::name);
  return found == group.datasets.end() ? nullptr : &*found;
}

const Group* find_group(const Source& source, std::string_view name) {
  const auto found = std::ranges::find(source.groups(), name, &Group::name);
  return found == source.groups().end() ? nullptr : &*found;
}

void refuse_archive(const Source& source, const std::string& reason) {
  throw base::Error(base::ExitCode::bad_archive, fmt::format("{}: {}", source.name(), reason));
}

}  // namespace sleight::archive
