// A small archive in memory for tests of pictures.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/archive/format.h"
#include "common/archive/model.h"

namespace sleight::archive {

/// An archive of two chains, each of four scans. All animations have the same segments. Animation i
/// is from scan 3 of chain i.
class StoredArchive : public archive::Source {
 public:
  StoredArchive(std::string world, std::string request, double animations)
      : request_(std::move(request)), animations_(static_cast<std::size_t>(animations)) {
    groups_ = {
        {.name = "/",
         .attributes = {{"format_version", archive::k_format_version},
                        {"world", std::move(world)},
                        {"inference_library_version", "0"},
                        {"results_version", "0"},
                        {"run_id", "0"},
                        {"content_digest", ""}},
         .datasets = {{.name = "request", .type = archive::ElementType::text}}},
        {.name = "/posterior", .attributes = {{"thin", std::int64_t{1}}}},
        {.name = "/sample_stats"},
        {.name = "/animations",
         .attributes = {{"keep_max", std::int64_t{9}}, {"keep_per_lineage", std::int64_t{9}}}}};
    add("/posterior", "draw", {{"draw", 4}}, {0, 1, 2, 3});
    add("/sample_stats", "chain", {{"chain", 2}}, {0, 1});
    add("/sample_stats", "draw", {{"draw", 4}}, {0, 1, 2, 3});
    add_statistic("lp", {-9, -5, -5, -3, -9, -9, -9, -5});
  }

  std::string name() const override { return "small.h5"; }
  const std::vector<archive::Group>& groups() const override { return groups_; }
  archive::Values read(std::string_view group, std::string_view dataset, std::uint64_t first,
                       std::uint64_t count) const override {
    if (dataset == "request") return std::vector<std::string>{request_};
    const std::vector<double>& values = values_.at(archive::path_of(group, dataset));
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(first);
    return std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(count));
  }

 protected:
  void add_statistic(const char* name, std::vector<double> values) {
    add("/sample_stats", name, {{"chain", 2}, {"draw", 4}}, std::move(values));
  }

  /// Adds the datasets of /animations, except the segments' columns. Each animation has `segments`
  /// segments.
  void add_animations(std::size_t segments) {
    segments_ = segments;
    const auto each = [&](double first, double step) {
      std::vector<double> values(animations_);
      for (std::size_t i = 0; i < animations_; ++i)
        values[i] = first + step * static_cast<double>(i);
      return values;
    };
    const auto rows = static_cast<double>(segments);
    for (const auto& [name, values] :
         {std::pair{"animation", each(0, 1)}, std::pair{"chain", each(0, 1)},
          std::pair{"draw", each(3, 0)}, std::pair{"lineage", each(0, 0)},
          std::pair{"segment_start", each(0, rows)}, std::pair{"segment_count", each(rows, 0)}})
      add("/animations", name, {{"animation", animations_}}, values);
    add_column("segment", {}, std::vector<double>(segments));
  }

  void add_of_animations(const char* name, std::vector<archive::Dimension> dims,
                         std::vector<double> values) {
    dims.insert(dims.begin(), {"animation", animations_});
    add("/animations", name, std::move(dims), std::move(values));
  }

  /// Adds a dataset to any group. Creates the group if necessary.
  void add_anywhere(const char* group, const char* name, std::vector<archive::Dimension> dims,
                    std::vector<double> values) {
    if (std::ranges::find(groups_, group, &archive::Group::name) == groups_.end())
      groups_.push_back({.name = group});
    add(group, name, std::move(dims), std::move(values));
  }

  /// Adds a column of segments. `values` has one animation's values; all animations get the same
  /// values.
  void add_column(const char* name, std::vector<archive::Dimension> dims,
                  const std::vector<double>& values) {
    dims.insert(dims.begin(), {"segment", animations_ * segments_});
    std::vector<double> all;
    for (std::size_t i = 0; i < animations_; ++i)
      all.insert(all.end(), values.begin(), values.end());
    add("/animations", name, std::move(dims), std::move(all));
  }

 private:
  void add(std::string_view group, const char* dataset, std::vector<archive::Dimension> dims,
           std::vector<double> values) {
    const auto found = std::ranges::find(groups_, group, &archive::Group::name);
    found->datasets.push_back({.name = dataset, .dims = std::move(dims)});
    values_[archive::path_of(group, dataset)] = std::move(values);
  }

  std::string request_;
  std::size_t animations_;
  std::size_t segments_ = 0;
  std::vector<archive::Group> groups_;
  std::map<std::string, std::vector<double>> values_;
};

/// An archive of the named world. The only animation has no data.
class BareArchive final : public StoredArchive {
 public:
  explicit BareArchive(std::string world) : StoredArchive(std::move(world), "", 1) {
    add_animations(1);
  }
};

}  // namespace sleight::archive
