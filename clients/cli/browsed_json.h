// Browsed archives and animations as JSON.
#pragma once

#include "clients/browse/archives/browsed.h"
#include "common/json/value.h"

namespace sleight::cli {

/// {"archives": [...], "left_out": [...]}
json::Value archives_json(const browse::Browsed& browsed);

/// Its name, where it is, and its numbers; null where a number does not apply.
json::Value animation_json(const browse::Browsed& browsed, const browse::Picked& picked);

/// What queries can speak of in this archive.
json::Value names_json(const browse::BrowsedArchive& archive);

/// JSON has no NaN and no infinity: null.
json::Value number_json(double number);

}  // namespace sleight::cli
