#include "common/archive/remote/contents_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "common/archive/format.h"
#include "common/archive/limits.h"
#include "common/archive/remote/messages.h"
#include "common/archive/text.h"

namespace sleight::archive::remote {
namespace {

constexpr std::size_t k_shown_bytes_max = 4096;

std::string fault_of_attributes(const std::vector<Attribute>& attributes) {
  if (attributes.size() > k_attributes_max) return "too many attributes";
  std::set<std::string_view> names;
  for (const Attribute& attribute : attributes) {
    if (!is_plain_name(attribute.name)) return "an attribute has an invalid name";
    if (!names.insert(attribute.name).second)
      return fmt::format("two attributes are named {}", attribute.name);
    const auto* text = std::get_if<std::string>(&attribute.value);
    if (text != nullptr && (text->size() > k_attribute_bytes_max || !is_clean_line(*text)))
      return fmt::format("the attribute {} is too long or contains control characters",
                         attribute.name);
  }
  return {};
}

std::string fault_of_size(const DatasetSpec& spec) {
  const bool is_text = spec.type == ElementType::text;
  if (is_text ? spec.text_bytes == 0 || spec.text_bytes > k_text_bytes_max : spec.text_bytes != 0)
    return fmt::format("unexpected text size of {} bytes", spec.text_bytes);
  if (spec.dims.size() > k_rank_max)
    return fmt::format("expected at most {1} dimensions, found {0}", spec.dims.size(), k_rank_max);
  std::uint64_t bytes = is_text ? spec.text_bytes : size_of(spec.type);
  bool is_too_large = false;
  for (const Dimension& dim : spec.dims) {
    if (!is_plain_name(dim.name)) return "a dimension has an invalid name";
    is_too_large = is_too_large || dim.size > k_dataset_bytes_max ||
                   __builtin_mul_overflow(bytes, dim.size, &bytes);
  }
  if (is_too_large || bytes > k_dataset_bytes_max)
    return fmt::format("the values take more than {} bytes", k_dataset_bytes_max);
  return {};
}

std::string fault_of_dataset(const Group& group, const DatasetSpec& spec) {
  std::string fault = fault_of_size(spec);
  if (fault.empty()) fault = fault_of_attributes(spec.attributes);
  if (!fault.empty()) return fault;
  for (const Dimension& dim : spec.dims) {
    const DatasetSpec* scale = find_dataset(group, dim.name);
    if (scale == nullptr || scale->dims.size() != 1 || scale->dims[0].name != dim.name)
      return fmt::format("dimension {} has no scale", dim.name);
  }
  return {};
}

std::string fault_of_group(const Group& group) {
  std::string fault = fault_of_attributes(group.attributes);
  if (!fault.empty()) return fmt::format("{}: {}", group.name, fault);
  std::set<std::string_view> names;
  for (const DatasetSpec& spec : group.datasets) {
    if (!is_plain_name(spec.name))
      return fmt::format("{}: an object in the group has an invalid name", group.name);
    if (!names.insert(spec.name).second)
      return fmt::format("{}: the name occurs twice", path_of(group.name, spec.name));
  }
  for (const DatasetSpec& spec : group.datasets) {
    fault = fault_of_dataset(group, spec);
    if (!fault.empty()) return fmt::format("{}: {}", path_of(group.name, spec.name), fault);
  }
  return {};
}

std::string fault_of_format(const Group& root) {
  const Attribute* format = find_attribute(root.attributes, "format");
  const auto* name = format == nullptr ? nullptr : std::get_if<std::string>(&format->value);
  if (name == nullptr || *name != k_format_name) return "the root attribute format is missing";
  const Attribute* version = find_attribute(root.attributes, "format_version");
  const auto* number = version == nullptr ? nullptr : std::get_if<std::int64_t>(&version->value);
  if (number == nullptr || *number != k_format_version)
    return "this program does not read this format_version";
  return {};
}

}  // namespace

std::string fault_of_contents(const std::vector<Group>& groups) {
  if (groups.empty() || groups[0].name != k_root) return "the root group is missing";
  std::set<std::string> paths;
  for (const Group& group : groups) {
    const bool is_root = &group == &groups[0];
    if (!is_root && (!group.name.starts_with('/') || !is_plain_name(group.name.substr(1))))
      return "a group has an invalid name";
    if (!paths.insert(group.name).second)
      return fmt::format("{}: the name occurs twice", group.name);
    const std::string fault = fault_of_group(group);
    if (!fault.empty()) return fault;
    for (const DatasetSpec& spec : group.datasets) {
      if (!paths.insert(path_of(group.name, spec.name)).second)
        return fmt::format("{}: the name occurs twice", path_of(group.name, spec.name));
    }
    if (paths.size() > k_objects_max)
      return fmt::format("the file has more than {} objects", k_objects_max);
  }
  return fault_of_format(groups[0]);
}

bool is_text_for(std::string_view group, std::string_view dataset, std::string_view text) {
  return group == k_root && dataset == k_request ? is_clean_text(text) : is_clean_line(text);
}

std::string shown_text(std::string_view text) {
  std::string shown(text.substr(0, k_shown_bytes_max));
  // Our own messages are clean, unless the limit cut one inside a character. Such a message is
  // shown with '?' for each non-ASCII byte.
  if (is_clean_text(shown)) return shown;
  std::ranges::replace_if(
      shown, [](char c) { return c != '\n' && (c < ' ' || c > '~'); }, '?');
  return shown;
}

}  // namespace sleight::archive::remote
