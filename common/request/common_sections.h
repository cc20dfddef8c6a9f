// Binds the keys common to all worlds, for reading and for help. Internal to common/request.
#pragma once

#include <array>
#include <span>

#include "common/request/binder.h"
#include "common/request/direction_request.h"

namespace sleight::request {

/// The binders of the sections, in the order of the normalised text.
struct SectionBinders {
  Binder world;
  Binder constraint;
  Binder sampler;
  Binder stop;
  Binder output;

  SectionBinders(const Document& document, Diagnostics& diagnostics);

  std::array<const Binder*, 5> all() const {
    return {&world, &constraint, &sampler, &stop, &output};
  }
};

/// Binds the common keys to `request`, and the keys of the world that [world] names. Returns that
/// world. If the name is missing or unknown, returns null and binds no world's keys.
const WorldBinding* bind_sections(SectionBinders& sections, std::span<const WorldBinding> worlds,
                                  DirectionRequest& request);

/// Returns whether people often mistake this command-line option for a key of a request.
bool is_command_line_option(std::string_view key);

}  // namespace sleight::request
