// Sizes and times as people write them: "24 GB", "1.5 GiB", "10s", "5m", "1.5h".
//
// Pure; thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sleight::config {

inline constexpr std::uint64_t k_bytes_max = std::uint64_t{1}
                                             << 53U;  ///< 9 PB: JSON has it exactly
inline constexpr double k_duration_s_max = 1e9;       ///< 32 years

/// A number, a space if wanted, and B, kB, MB, GB, TB (powers of 1000) or KiB, MiB, GiB, TiB
/// (powers of 1024); upper and lower case are the same, and without a unit it is bytes. Rounded to
/// whole bytes. None for anything else, and beyond k_bytes_max.
std::optional<std::uint64_t> bytes_of(std::string_view text);

/// Seconds of "90", "90s", "5m" or "1.5h". None for anything else, 0 and above k_duration_s_max.
std::optional<double> duration_s_of(std::string_view text);

/// The largest unit of 1000 that leaves a whole number: "24 GB", "1500 MB", "17 B". bytes_of reads
/// it back to the same.
std::string bytes_text(std::uint64_t bytes);

/// "10s", "5m", "1.5h": duration_s_of reads it back to the same.
std::string duration_text(double duration_s);

}  // namespace sleight::config
