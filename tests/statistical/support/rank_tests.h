// Rank tests and Monte Carlo errors for statistical tests, without any code of the sampler.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace sleight::statistical {

/// Returns P(D > d) of the two-sample Kolmogorov-Smirnov statistic for samples without ties, by the
/// asymptotic series with the small-sample correction of Stephens (1970).
double kolmogorov_smirnov_p(std::span<const double> a, std::span<const double> b);

/// Like kolmogorov_smirnov_p(), against the uniform distribution on (0, 1).
double uniformity_p(std::span<const double> values);

/// Returns a stationary series' effective sample size, by Geyer's initial monotone sequence (1992).
double effective_sample_size(std::span<const double> series);

struct MeanWithError {
  double mean = 0;
  double standard_error = 0;
};

/// Returns the mean of several chains' draws. The error includes autocorrelation.
MeanWithError mean_of_chains(std::span<const std::vector<double>> chains);

/// Returns the mean over independent chains of equal length that start from exact draws. The error
/// is that of the chains' means, so it is valid for any mixing.
MeanWithError mean_over_independent_chains(std::span<const std::vector<double>> chains);

MeanWithError mean_of_independent(std::span<const double> draws);

}  // namespace sleight::statistical
