// Helpers shared by the writers of the archive's groups: dataset descriptions, coordinates, and the
// densities of a record. Private to common/archive.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/archive/columns.h"
#include "common/archive/model.h"
#include "common/archive/world_layout.h"

namespace sleight::archive {

using Dims = std::vector<Dimension>;

/// REQUIRES: the value fits the result type.
std::int64_t signed_of(std::uint64_t value);
std::int32_t small_of(std::uint64_t value);

DatasetSpec spec_of(std::string name, ElementType type, Dims dims, std::string long_name,
                    std::string units = "1");

/// Writes the coordinate 0, step, 2 step, ... of a dimension.
void write_coordinate(Sink& sink, std::string_view group, const Dimension& dim,
                      std::string long_name, std::uint64_t step = 1);

/// Writes a coordinate for each dimension of a world's variables: the dimension's names, or 0, 1,
/// ... if it has none. Skips dimensions in `written`, and adds the others to `written`. REQUIRES:
/// dimensions of the same name, also those in `written`, have the same size and names.
void write_own_coordinates(Sink& sink, std::string_view group,
                           const std::vector<Variable>& variables, Dims& written);

/// Writes a dataset of words. The dataset's elements have the size of the longest word.
void write_words(Sink& sink, std::string_view group, const std::string& name, const Dims& dims,
                 const std::string& long_name, std::span<const std::string> words);

/// The columns that /sample_stats, /replicas, /animations and other groups have in common.
class DensityColumns {
 public:
  DensityColumns(Sink& sink, std::string_view group, const Dims& leading);
  void push(double log_prior, double log_constraint) {
    log_prior_.push(log_prior);
    log_constraint_.push(log_constraint);
  }
  void flush() {
    log_prior_.flush();
    log_constraint_.flush();
  }

 private:
  Column<double> log_prior_;
  Column<double> log_constraint_;
};

}  // namespace sleight::archive
