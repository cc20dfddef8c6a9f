// The origin of a picture, stored in the file as lines `name: value` in an SVG's <metadata>.
//
// Programs accept notes as options (`--note commit=1f2e3d4c`), so the same figure with the same
// notes has the same bytes. deploy/figures passes command, commit and seed. Pure.
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

/// Parses texts `name=value`, in their order. Throws base::Error (usage) for other texts and for
/// duplicate names.
Notes notes_of(std::span<const std::string> texts);

}  // namespace sleight::plot
