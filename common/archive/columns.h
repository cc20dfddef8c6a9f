// Buffers between a layout, which produces single records, and a Sink, which expects long runs of
// elements.
//
// Each Column is one dataset. A Column passes elements on in batches of fixed size. So the calls
// into a sink depend only on the content, and so do a file's bytes.
#pragma once

#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "common/archive/format.h"
#include "common/archive/model.h"
#include "common/base/check.h"
#include "common/math/vector.h"

namespace sleight::archive {

/// A Column is one dataset of Element (double, int64_t, int32_t, or int8_t for booleans). The sink
/// must outlive the Column. Call flush() before finishing the archive. Not thread-safe.
template <class Element>
class Column {
 public:
  Column(Sink& sink, std::string_view group, const DatasetSpec& spec)
      : sink_(&sink), dataset_(sink.create_dataset(group, spec)) {
    waiting_.reserve(k_batch_elements);
  }

  void push(Element value) {
    // Store every NaN with the same bits, so that equal content has equal bytes.
    if constexpr (std::is_same_v<Element, double>) {
      if (std::isnan(value)) value = std::numeric_limits<double>::quiet_NaN();
    }
    waiting_.push_back(value);
    if (waiting_.size() == k_batch_elements) flush();
  }

  void flush() {
    if (waiting_.empty()) return;
    sink_->append(dataset_, std::span<const Element>(waiting_));
    waiting_.clear();
  }

 private:
  Sink* sink_;
  Sink::DatasetHandle dataset_;
  std::vector<Element> waiting_;
};

inline const Dimension k_axis{"axis_xyz", 3};
inline const Dimension k_quaternion{"quaternion_wxyz", 4};

/// Appends three elements along k_axis.
inline void push_vector(Column<double>& column, const math::Vec3& v) {
  for (const double value : {v.x(), v.y(), v.z()})
    column.push(value);
}

/// One dataset for each of a world's variables. All datasets have the same leading dimensions.
class VariableColumns {
 public:
  VariableColumns(Sink& sink, std::string_view group, const std::vector<Dimension>& leading,
                  const std::vector<Variable>& variables) {
    for (const Variable& variable : variables) {
      DatasetSpec spec{.name = variable.name, .type = ElementType::f64, .dims = leading};
      spec.dims.insert(spec.dims.end(), variable.dims.begin(), variable.dims.end());
      spec.attributes = {{"long_name", variable.meaning}, {"units", variable.unit}};
      columns_.emplace_back(Column<double>(sink, group, spec), variable.size());
      width_ += variable.size();
    }
  }

  /// Appends the values of all variables in order. REQUIRES: width() values.
  void push(std::span<const double> values) {
    CHECK_EQ(values.size(), width_);
    for (auto& [column, size] : columns_) {
      for (const double value : values.first(size))
        column.push(value);
      values = values.subspan(size);
    }
  }

  void flush() {
    for (auto& [column, size] : columns_)
      column.flush();
  }

  std::size_t width() const { return width_; }

 private:
  std::vector<std::pair<Column<double>, std::size_t>>
      columns_;  ///< column and its elements per row
  std::size_t width_ = 0;
};

}  // namespace sleight::archive
