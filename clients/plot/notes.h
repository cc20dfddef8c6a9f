// Where a picture comes from, kept within its file: lines `name: value` in an SVG's <metadata>.
//
// Programs take them as they are given (`--note commit=1f2e3d4c`), so the same figure with the same
// notes gives the same bytes. deploy/figures gives command, commit and seed. Pure.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace sleight::plot {

struct Note {
  std::string name;   ///< lower-case letters and underscores
  std::string value;  ///< one line
  friend bool operator==(const Note&, const Note&) = default;
};
using Notes = std::vector<Note>;

/// Of texts `name=value`, in their order. Throws base::Error (usage) for another text, and for a
/// name that comes twice.
Notes notes_of(std::span<const std::string> texts);

}  // namespace sleight::plot
