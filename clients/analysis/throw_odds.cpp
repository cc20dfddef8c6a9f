#include "clients/analysis/throw_odds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace sleight::analysis {
namespace {

constexpr double k_ln_10 = 2.302585092994045684;

/// A count in words. The unit is separate, so that a range shows it once.
struct Words {
  std::string digits;
  std::string unit;
};

/// `significant`: number of digits, 2 to 4.
Words words_of(double log10_count, int significant) {
  // Round before choosing the unit, so that 999,999 becomes 1.0 million.
  double exponent = std::floor(log10_count);
  double digits = std::round(std::pow(10.0, log10_count - exponent + significant - 1));
  if (digits >= std::pow(10.0, significant)) {
    digits /= 10;
    exponent += 1;
  }
  const auto shown = [&](double power) {
    const int decimals = std::max(significant - 1 - static_cast<int>(power), 0);
    return fmt::format("{:.{}f}", digits * std::pow(10.0, power - significant + 1), decimals);
  };
  if (exponent >= 12) return {fmt::format("{}e{:.0f}", shown(0), exponent), ""};
  if (exponent >= 9) return {shown(exponent - 9), " billion"};
  if (exponent >= 6) return {shown(exponent - 6), " million"};
  std::string count = shown(exponent);
  if (exponent >= 3) count.insert(count.end() - 3, ',');
  return {count, ""};
}

/// Returns how many digits show that the ends of a range differ, within limits.
int digits_for(double log10_low, double log10_high) {
  const double width = log10_high - log10_low;
  if (width < 0.004) return 4;
  return width < 0.08 ? 3 : 2;
}

}  // namespace

const char* name_of(ErrorFrom from, bool weighted) {
  switch (from) {
    case ErrorFrom::unknown:
      return "unknown";
    case ErrorFrom::jackknife:
      return weighted ? "spread of weights within chains" : "jackknife within ladders";
    case ErrorFrom::between:
      return weighted ? "standard error between chains" : "standard error between ladders";
    case ErrorFrom::mean_of_logs:
      return weighted ? "half the variance between chains" : "half the variance between ladders";
    case ErrorFrom::islands:
      return "spread of islands";
  }
  return "unknown";
}

CombinedEstimate combined(std::span<const LogEstimate> ladders) {
  std::vector<LogEstimate> known;
  std::ranges::copy_if(ladders, std::back_inserter(known),
                       [](const LogEstimate& ladder) { return std::isfinite(ladder.value); });
  CombinedEstimate all{
      .log = {k_nan, k_nan}, .ladders = known.size(), .own_error = k_nan, .between_error = k_nan};
  if (known.empty()) return all;
  const auto count = static_cast<double>(known.size());

  // Compute the mean of the logs, and its error from the ladders' own errors.
  double sum = 0;
  double squared_errors = 0;
  for (const LogEstimate& ladder : known) {
    sum += ladder.value;
    squared_errors += ladder.error * ladder.error;
  }
  all.log.value = sum / count;
  all.own_error = std::sqrt(squared_errors) / count;

  // Estimate the error from the spread of ladders.
  double squares = 0;
  for (const LogEstimate& ladder : known)
    squares += (ladder.value - all.log.value) * (ladder.value - all.log.value);
  if (known.size() >= 2) all.between_error = std::sqrt(squares / (count - 1) / count);
  const double half_variance = all.between_error * all.between_error * count / 2;

  // Take the largest error; a comparison with NaN is false.
  const auto consider = [&](double error, ErrorFrom from) {
    if (std::isnan(error) || error <= all.log.error) return;
    all.log.error = error;
    all.error_from = from;
  };
  consider(all.own_error, ErrorFrom::jackknife);
  consider(all.between_error, ErrorFrom::between);
  consider(half_variance, ErrorFrom::mean_of_logs);
  return all;
}

CombinedEstimate combined(const math::IslandOdds& islands) {
  CombinedEstimate all{.log = {k_nan, k_nan},
                       .error_from = ErrorFrom::islands,
                       .ladders = 0,
                       .own_error = k_nan,
                       .between_error = k_nan};
  if (!std::isfinite(islands.log_mean)) return all;
  all.log = {islands.log_mean, islands.log_error()};
  all.own_error = all.log.error;
  all.ladders = islands.islands;
  return all;
}

ThrowOdds odds_of(const LogEstimate& log_p_satisfied, double log_natural_throw) {
  const auto log10_of = [&](double log_p) {
    const double log10 = (log_natural_throw - log_p) / k_ln_10;
    return std::isnan(log10) ? k_nan : std::max(log10, 0.0);
  };
  return {.log10_throws = log10_of(log_p_satisfied.value),
          .log10_low = log10_of(log_p_satisfied.value + log_p_satisfied.error),
          .log10_high = log10_of(log_p_satisfied.value - log_p_satisfied.error)};
}

std::string in_words(const ThrowOdds& odds) {
  const bool has_range = std::isfinite(odds.log10_low) && std::isfinite(odds.log10_high);
  const int digits = has_range ? digits_for(odds.log10_low, odds.log10_high) : 2;
  const Words throws = words_of(odds.log10_throws, digits);
  const std::string first = fmt::format("one throw in {}{}", throws.digits, throws.unit);
  if (!has_range) return first + " (error unknown)";
  const Words low = words_of(odds.log10_low, digits);
  const Words high = words_of(odds.log10_high, digits);
  return fmt::format("{} ({}{} to {}{})", first, low.digits, low.unit == high.unit ? "" : low.unit,
                     high.digits, high.unit);
}

}  // namespace sleight::analysis
