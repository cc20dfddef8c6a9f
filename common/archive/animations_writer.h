// Writes kept animations: where each was found, its state and outcome, its motion, and what of the
// scene is its own. Of /animations and /finds. Private to common/archive.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <span>
#include <string_view>

#include "common/archive/model.h"
#include "common/archive/world_layout.h"
#include "common/plan/unit.h"

namespace sleight::archive {

/// A column that says where an animation was found.
struct Address {
  const char* name;
  const char* meaning;
};

class AnimationsWriter {
 public:
  /// `in_proportion`: the group's animations are draws of the model, not only found.
  /// REQUIRES: the group is there.
  AnimationsWriter(const StateReader& reader, std::string_view group, const char* counted,
                   std::span<const Address> addresses, bool in_proportion, Sink& sink);
  ~AnimationsWriter();

  /// REQUIRES: as many addresses as columns.
  void push(std::initializer_list<std::int64_t> addresses, const plan::ScanRecord& record);
  void flush();

 private:
  struct Columns;
  std::unique_ptr<Columns> columns_;
};

}  // namespace sleight::archive
