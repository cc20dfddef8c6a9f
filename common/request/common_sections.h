// The keys that every request has, whatever its world: bound here once for reading and for help.
// Internal to common/request.
#pragma once

#include <array>
#include <span>
#include <string>

#include "common/request/binder.h"
#include "common/request/direction_request.h"

namespace sleight::request {

/// One binder for each section, in the order of the normalised text.
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

/// Binds all keys to `request`: the common ones, and those of the world that [world] names. Returns
/// that world; null if the name is missing or unknown, and then no world's keys are bound.
const WorldBinding* bind_sections(SectionBinders& sections, std::span<const WorldBinding> worlds,
                                  DirectionRequest& request);

/// Names that people look for in a request though they belong to the command line.
bool is_command_line_option(std::string_view key);

}  // namespace sleight::request
