// Rank tests and Monte Carlo errors for statistical tests, with nothing that the sampler uses.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace sleight::statistical {

/// P(D > d) of the two-sample Kolmogorov-Smirnov statistic for samples of sizes n and m without
/// ties, by the asymptotic series with the small-sample correction of Stephens (1970).
double kolmogorov_smirnov_p(std::span<const double> a, std::span<const double> b);

/// The same against the uniform distribution on (0, 1).
double uniformity_p(std::span<const double> values);

/// The number of independent draws that estimate the mean of a stationary series as well, by
/// Geyer's initial monotone sequence (1992).
double effective_sample_size(std::span<const double> series);

struct MeanWithError {
  double mean = 0;
  double standard_error = 0;
};

/// The mean of the draws of several chains; the error allows for their autocorrelation.
MeanWithError mean_of_chains(std::span<const std::vector<double>> chains);

/// The mean over independent chains of equal length whose starts are exact draws; the error is that
/// of the chains' own means, so it is honest however slowly they mix.
MeanWithError mean_over_independent_chains(std::span<const std::vector<double>> chains);

/// The mean of independent draws.
MeanWithError mean_of_independent(std::span<const double> draws);

}  // namespace sleight::statistical
