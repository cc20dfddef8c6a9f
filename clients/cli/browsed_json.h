// Formats archives and animations as JSON for the browsing commands.
#pragma once

#include "clients/browse/archives/browsed.h"
#include "common/json/value.h"

namespace sleight::cli {

using Json = json::Value;

/// Returns {"archives": [...], "left_out": [...]}.
Json archives_json(const browse::Browsed& browsed);

/// Returns an animation's name, place and numbers. A number that doesn't apply is null.
Json animation_json(const browse::Browsed& browsed, const browse::Picked& picked);

/// Returns the names that queries can use in this archive.
Json names_json(const browse::BrowsedArchive& archive);

/// Returns null for NaN and infinity, which JSON lacks.
Json number_json(double number);

}  // namespace sleight::cli
