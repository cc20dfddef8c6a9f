#include "common/archive/csv.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <ostream>

#include "common/archive/format.h"
#include "common/base/error.h"

namespace sleight::archive {
namespace {

struct Table {
  std::string_view name;
  std::string_view group;
  std::vector<std::string> index;  ///< leading dimensions; their coordinates come first
};

const std::array<Table, 13>& tables() {
  static const std::array<Table, 13> all{{
      {"posterior", k_posterior, {"chain", "draw"}},
      {"sample_stats", k_sample_stats, {"chain", "draw"}},
      {"replicas", k_replicas, {"chain", "replica"}},
      {"animations", k_animations, {"animation"}},
      {"segments", k_animations, {"segment"}},
      {"finds", k_finds, {"animation"}},
      {"find_segments", k_finds, {"segment"}},
      {"prior", k_prior, {"chain", "draw"}},
      {"sample_stats_prior", k_sample_stats_prior, {"chain", "draw"}},
      {"features", k_scene, {"feature"}},
      {"parts", k_scene, {"part"}},
      {"points", k_animations, {"point"}},
      {"find_points", k_finds, {"point"}},
  }};
  return all;
}

/// Maximum columns of a table, so that a hostile archive can't cause a header of gigabytes.
constexpr std::uint64_t k_columns_max = 1'000'000;

std::string quoted(const std::string& field) {
  if (field.find_first_of(",\"\r\n") == std::string::npos) return field;
  std::string text = "\"";
  for (const char letter : field) {
    if (letter == '"') text += '"';
    text += letter;
  }
  return text + '"';
}

void print_element(const Values& values, std::size_t i, std::string& line) {
  const auto print = [i, &line](const auto& elements) {
    using Element = typename std::decay_t<decltype(elements)>::value_type;
    if constexpr (std::is_same_v<Element, std::string>) {
      line += quoted(elements[i]);
    } else if constexpr (std::is_same_v<Element, std::int8_t>) {
      fmt::format_to(std::back_inserter(line), "{}", static_cast<int>(elements[i]));
    } else {
      fmt::format_to(std::back_inserter(line), "{}", elements[i]);
    }
  };
  std::visit(print, values);
}

const DatasetSpec& coordinate_of(const Source& source, const Group& group, const std::string& dim) {
  const DatasetSpec* coordinate = find_dataset(group, dim);
  if (coordinate == nullptr || coordinate->dims.size() != 1 || coordinate->dims[0].name != dim) {
    refuse_archive(source, fmt::format("{}: the dimension {} has no coordinate", group.name, dim));
  }
  return *coordinate;
}

Values whole(const Source& source, const Group& group, const DatasetSpec& spec) {
  return source.read(group.name, spec.name, 0, element_count(spec));
}

/// Returns the labels that stand for a dimension's indices in column names. If the coordinate is
/// text, its words are the labels; otherwise numbers are.
std::vector<std::string> labels_of(const Source& source, const Group& group, const Dimension& dim) {
  const DatasetSpec& coordinate = coordinate_of(source, group, dim.name);
  if (coordinate.type == ElementType::text && coordinate.dims[0].size == dim.size) {
    return std::get<std::vector<std::string>>(whole(source, group, coordinate));
  }
  std::vector<std::string> labels(dim.size);
  for (std::size_t i = 0; i < dim.size; ++i)
    labels[i] = std::to_string(i);
  return labels;
}

/// Returns the names of a dataset's columns: "x", or "x[0,0]", "x[0,1]", ... The last index changes
/// fastest.
std::vector<std::string> column_names(const Source& source, const Group& group,
                                      const DatasetSpec& spec, std::size_t index_dims) {
  std::vector<std::string> suffixes{""};
  for (std::size_t d = index_dims; d < spec.dims.size(); ++d) {
    if (spec.dims[d].size * suffixes.size() > k_columns_max) {
      refuse_archive(source,
                     fmt::format("{}: too many columns for CSV", path_of(group.name, spec.name)));
    }
    std::vector<std::string> longer;
    for (const std::string& suffix : suffixes) {
      for (const std::string& label : labels_of(source, group, spec.dims[d])) {
        longer.push_back(suffix.empty() ? label : suffix + "," + label);
      }
    }
    suffixes = std::move(longer);
  }
  std::vector<std::string> names;
  for (const std::string& suffix : suffixes) {
    names.push_back(quoted(suffix.empty() ? spec.name : fmt::format("{}[{}]", spec.name, suffix)));
  }
  return names;
}

bool is_column(const DatasetSpec& spec, const std::vector<std::string>& index) {
  if (spec.dims.size() < index.size()) return false;
  if (spec.dims.size() == 1 && spec.dims[0].name == spec.name) return false;  // a coordinate
  return std::ranges::equal(index, std::span(spec.dims).first(index.size()), {}, {},
                            &Dimension::name);
}

struct RowRange {
  std::uint64_t first = 0;
  std::uint64_t count = 0;
};

struct DataColumn {
  const DatasetSpec* spec = nullptr;
  std::uint64_t width = 1;  ///< elements per row
};

class Exporter {
 public:
  Exporter(const Source& source, const Group& group, const std::vector<std::string>& index)
      : source_(source), group_(group) {
    for (const std::string& dim : index) {
      const DatasetSpec& coordinate = coordinate_of(source, group, dim);
      if (coordinate.dims[0].size > k_index_max) {
        refuse_archive(source, fmt::format("{}: too long for CSV", path_of(group.name, dim)));
      }
      coordinates_.push_back(whole(source, group, coordinate));
      sizes_.push_back(coordinate.dims[0].size);
      rows_ *= coordinate.dims[0].size;
      header_ += (header_.empty() ? "" : ",") + dim;
    }
    for (const DatasetSpec& spec : group.datasets) {
      if (is_column(spec, index)) add_column(spec, index.size());
    }
    // A batch has at most k_batch_elements elements of each dataset, but at least one row.
    for (const DataColumn& column : columns_) {
      batch_rows_ = std::min<std::uint64_t>(
          batch_rows_,
          std::max<std::uint64_t>(1, k_batch_elements / std::max<std::uint64_t>(1, column.width)));
    }
  }

  std::uint64_t rows() const { return rows_; }

  /// REQUIRES: the table contains the ranges.
  void run(std::span<const RowRange> ranges, std::ostream& out) const {
    out << header_ << '\n';
    for (const RowRange& range : ranges) {
      const std::uint64_t end = range.first + range.count;
      for (std::uint64_t first = range.first; first < end && out.good(); first += batch_rows_)
        print_batch(first, std::min(batch_rows_, end - first), out);
    }
  }

 private:
  /// Longest coordinate that is read as a whole. A coordinate of 10^9 scans would need 8 GB.
  static constexpr std::uint64_t k_index_max = 200'000'000;

  void add_column(const DatasetSpec& spec, std::size_t index_dims) {
    DataColumn column{.spec = &spec};
    for (std::size_t d = 0; d < spec.dims.size(); ++d) {
      if (d >= index_dims) {
        column.width *= spec.dims[d].size;
      } else if (spec.dims[d].size != sizes_[d]) {
        refuse_archive(source_, fmt::format("{}: dimension {} and its coordinate differ in size",
                                            path_of(group_.name, spec.name), spec.dims[d].name));
      }
      if (column.width > k_columns_max) {
        refuse_archive(
            source_, fmt::format("{}: too many columns for CSV", path_of(group_.name, spec.name)));
      }
    }
    for (const std::string& name : column_names(source_, group_, spec, index_dims)) {
      if (column.width != 0) header_ += "," + name;
    }
    columns_.push_back(column);
  }

  void print_batch(std::uint64_t first, std::uint64_t rows, std::ostream& out) const {
    std::vector<Values> batches;
    for (const DataColumn& column : columns_) {
      batches.push_back(
          source_.read(group_.name, column.spec->name, first * column.width, rows * column.width));
    }
    std::string text;
    for (std::uint64_t row = 0; row < rows; ++row) {
      print_index(first + row, text);
      for (std::size_t c = 0; c < columns_.size(); ++c) {
        for (std::uint64_t i = 0; i < columns_[c].width; ++i) {
          text += ',';
          print_element(batches[c], row * columns_[c].width + i, text);
        }
      }
      text += '\n';
    }
    out << text;
  }

  void print_index(std::uint64_t row, std::string& text) const {
    std::uint64_t inner = rows_;
    for (std::size_t d = 0; d < sizes_.size(); ++d) {
      inner /= sizes_[d];
      if (d != 0) text += ',';
      print_element(coordinates_[d], row / inner % sizes_[d], text);
    }
  }

  const Source& source_;
  const Group& group_;
  std::vector<Values> coordinates_;
  std::vector<std::uint64_t> sizes_;
  std::uint64_t rows_ = 1;
  std::vector<DataColumn> columns_;
  std::uint64_t batch_rows_ = k_batch_elements;
  std::string header_;
};

}  // namespace

namespace {

std::vector<std::int64_t> numbers_of(const Source& source, const Group& group,
                                     std::string_view name) {
  const DatasetSpec* spec = find_dataset(group, name);
  if (spec == nullptr || spec->dims.size() != 1)
    refuse_archive(source, fmt::format("{}: {} is missing", group.name, name));
  const Values values = whole(source, group, *spec);
  const auto* numbers = std::get_if<std::vector<std::int64_t>>(&values);
  if (numbers == nullptr)
    refuse_archive(source, fmt::format("{}: expected integers", path_of(group.name, name)));
  return *numbers;
}

[[noreturn]] void refuse_number(const Source& source, std::uint64_t animation,
                                std::uint64_t animations) {
  throw base::Error(base::ExitCode::usage,
                    fmt::format("{}: no animation {}; the archive has {}, numbered from 0",
                                source.name(), animation, animations));
}

std::vector<RowRange> single_rows(const Source& source, std::uint64_t rows,
                                  std::span<const std::uint64_t> animations) {
  std::vector<RowRange> ranges;
  for (const std::uint64_t animation : animations) {
    if (animation >= rows) refuse_number(source, animation, rows);
    ranges.push_back({.first = animation, .count = 1});
  }
  return ranges;
}

std::vector<RowRange> rows_of(const Source& source, const Group& group, const std::string& dim,
                              std::uint64_t rows, std::span<const std::uint64_t> animations) {
  const std::vector<std::int64_t> starts = numbers_of(source, group, dim + "_start");
  const std::vector<std::int64_t> counts = numbers_of(source, group, dim + "_count");
  std::vector<RowRange> ranges;
  for (const std::uint64_t animation : animations) {
    if (animation >= starts.size() || animation >= counts.size())
      refuse_number(source, animation, starts.size());
    const auto first = static_cast<std::uint64_t>(starts[animation]);
    const auto count = static_cast<std::uint64_t>(counts[animation]);
    if (first > rows || count > rows - first)
      refuse_archive(source,
                     fmt::format("{}: animation {} refers to missing rows along dimension {}",
                                 group.name, animation, dim));
    ranges.push_back({.first = first, .count = count});
  }
  return ranges;
}

}  // namespace

std::vector<std::string> csv_tables() {
  std::vector<std::string> names;
  for (const Table& table : tables())
    names.emplace_back(table.name);
  return names;
}

void export_csv(const Source& source, std::string_view table_name, std::ostream& out,
                std::span<const std::uint64_t> animations) {
  const auto table = std::ranges::find(tables(), table_name, &Table::name);
  if (table == tables().end()) {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("{}: no table '{}'; expected one of {}", source.name(),
                                  table_name, fmt::join(csv_tables(), ", ")));
  }
  const Group* group = find_group(source, table->group);
  if (group == nullptr && table->group == k_finds) {
    throw base::Error(
        base::ExitCode::usage,
        fmt::format("{}: no table '{}', because the run had no search", source.name(), table_name));
  }
  if (group == nullptr || find_dataset(*group, table->index.front()) == nullptr) {
    // The table of surface points may be missing, because only some worlds have surfaces.
    if (table->index.front() != "point")
      refuse_archive(source, fmt::format("the group {} is missing", table->group));
    throw base::Error(base::ExitCode::usage,
                      fmt::format("{}: this archive has no table '{}'", source.name(), table_name));
  }
  const Exporter exporter(source, *group, table->index);
  if (animations.empty()) {
    const RowRange all{.first = 0, .count = exporter.rows()};
    exporter.run({&all, 1}, out);
    return;
  }
  const std::string& dim = table->index.front();
  if (dim == "animation") {
    exporter.run(single_rows(source, exporter.rows(), animations), out);
    return;
  }
  if (dim != "segment" && dim != "point") {
    throw base::Error(base::ExitCode::usage,
                      fmt::format("animations can't be selected in table '{}'", table_name));
  }
  exporter.run(rows_of(source, *group, dim, exporter.rows(), animations), out);
}

}  // namespace sleight::archive
