// How much a worker holds of samples for their replicas' next units, unless told.
#pragma once

#include <cstddef>

namespace sleight::run {

/// Some hundred thousand samples of balls that spell.
inline constexpr std::size_t k_cache_bytes_max = std::size_t{256} << 20U;

}  // namespace sleight::run
