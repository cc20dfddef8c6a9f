// Writes the kept animations into /animations and /finds. An animation has a source, a state, an
// outcome, a motion, and its own parts of the scene. Private to common/archive.
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

/// A column that identifies an animation's source, such as its chain or draw.
struct Address {
  const char* name;
  const char* meaning;
};

class AnimationsWriter {
 public:
  /// `in_proportion`: the animations are draws of the model, not merely finds. REQUIRES: the group
  /// exists.
  AnimationsWriter(const StateReader& reader, std::string_view group, const char* counted,
                   std::span<const Address> addresses, bool in_proportion, Sink& sink);
  ~AnimationsWriter();

  /// REQUIRES: one address per column.
  void push(std::initializer_list<std::int64_t> addresses, const plan::ScanRecord& record);
  void flush();

 private:
  struct Columns;
  std::unique_ptr<Columns> columns_;
};

}  // namespace sleight::archive
