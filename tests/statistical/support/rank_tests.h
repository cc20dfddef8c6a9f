// Rank tests and Monte Carlo errors for statistical tests. These functions use no code of the
// sampler.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace sleight::statistical {

/// Returns P(D > d), where d is the Kolmogorov-Smirnov statistic of two samples. Uses the
/// asymptotic series with Stephens's small-sample correction (1970). REQUIRES: no ties.
double kolmogorov_smirnov_p(std::span<const double> a, std::span<const double> b);

/// Like kolmogorov_smirnov_p(), but compares one sample with the uniform distribution on (0, 1).
double uniformity_p(std::span<const double> values);

/// Returns the effective sample size of a stationary series, by Geyer's initial monotone sequence
/// (1992).
double effective_sample_size(std::span<const double> series);

struct MeanWithError {
  double mean = 0;
  double standard_error = 0;
};

/// Returns the mean of several chains' draws. The error includes autocorrelation.
MeanWithError mean_of_chains(std::span<const std::vector<double>> chains);

/// Returns the mean over independent chains. The error comes from the spread of the chains' means,
/// so it is valid for any mixing. REQUIRES: chains have equal lengths and start from exact draws.
MeanWithError mean_over_independent_chains(std::span<const std::vector<double>> chains);

MeanWithError mean_of_independent(std::span<const double> draws);

}  // namespace sleight::statistical
