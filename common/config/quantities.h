// Parses and formats sizes and times: "24 GB", "1.5 GiB", "10s", "5m", "1.5h".
//
// Pure; thread-safe.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sleight::config {

inline constexpr std::uint64_t k_bytes_max = std::uint64_t{1} << 53U;  ///< 9 PB, exact in JSON
inline constexpr double k_duration_s_max = 1e9;                        ///< 32 years

/// Parses a number, an optional space, and a unit in upper or lower case. Units are B, kB, MB, GB,
/// TB (powers of 1000) and KiB, MiB, GiB, TiB (powers of 1024). A number without a unit is in
/// bytes. Rounds to whole bytes. Returns nothing for other text, and for sizes above k_bytes_max.
std::optional<std::uint64_t> bytes_of(std::string_view text);

/// Parses "90", "90s", "5m" or "1.5h" to seconds. Returns nothing for other text, for 0, and for
/// times above k_duration_s_max.
std::optional<double> duration_s_of(std::string_view text);

/// Formats bytes in the largest decimal unit that gives a whole number: "24 GB", "1500 MB", "17 B".
/// bytes_of reads back the same value.
std::string bytes_text(std::uint64_t bytes);

/// Formats seconds as "10s", "5m" or "1.5h". duration_s_of reads back the same value.
std::string duration_text(double duration_s);

}  // namespace sleight::config
