// Browsed archives and animations as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "clients/cli/browsed.h"

namespace sleight::cli {

/// {"archives": [...], "left_out": [...]}
nlohmann::ordered_json archives_json(const Browsed& browsed);

/// Its name, where it is, and its numbers; null where a number does not apply.
nlohmann::ordered_json animation_json(const Browsed& browsed, const Picked& picked);

/// What queries can speak of in this archive.
nlohmann::ordered_json names_json(const BrowsedArchive& archive);

/// JSON has no NaN and no infinity: null.
nlohmann::ordered_json number_json(double number);

}  // namespace sleight::cli
