#include "worker/sampling/diagnostics/autocovariance.h"

#include <bit>
#include <numbers>
#include <utility>

#include "common/math/elementary.h"
#include "worker/sampling/diagnostics/transforms.h"

namespace sleight::sampling {
namespace {

/// A plain complex number. std::complex's product tests for NaN, which costs more than the product.
struct Complex {
  double real = 0;
  double imaginary = 0;
};

Complex operator+(Complex a, Complex b) {
  return {a.real + b.real, a.imaginary + b.imaginary};
}
Complex operator-(Complex a, Complex b) {
  return {a.real - b.real, a.imaginary - b.imaginary};
}
Complex operator*(Complex a, Complex b) {
  return {a.real * b.real - a.imaginary * b.imaginary, a.real * b.imaginary + a.imaginary * b.real};
}

/// Returns exp(-2 pi i k/size) for k = 0 .. size/2 - 1. REQUIRES: size is a power of two.
std::vector<Complex> unit_roots(std::size_t size) {
  std::vector<Complex> roots(size / 2);
  const double step = 2 * std::numbers::pi / static_cast<double>(size);
  for (std::size_t k = 0; k < roots.size(); ++k) {
    const double angle_rad = step * static_cast<double>(k);
    roots[k] = {math::cos(angle_rad), -math::sin(angle_rad)};
  }
  return roots;
}

/// Replaces z by its forward transform. REQUIRES: z.size() is a power of two with these roots.
void transform(std::vector<Complex>& z, const std::vector<Complex>& roots) {
  const std::size_t size = z.size();
  // Put each value at its bit-reversed index.
  for (std::size_t i = 1, reversed = 0; i < size; ++i) {
    std::size_t bit = size / 2;
    for (; (reversed & bit) != 0; bit /= 2)
      reversed ^= bit;
    reversed ^= bit;
    if (i < reversed) std::swap(z[i], z[reversed]);
  }
  // Join each pair of transforms of `half` values into a transform of 2 * half values.
  for (std::size_t half = 1; half < size; half *= 2) {
    const std::size_t stride = size / (2 * half);
    for (std::size_t begin = 0; begin < size; begin += 2 * half) {
      for (std::size_t k = 0; k < half; ++k) {
        const Complex even = z[begin + k];
        const Complex odd = z[begin + half + k] * roots[k * stride];
        z[begin + k] = even + odd;
        z[begin + half + k] = even - odd;
      }
    }
  }
}

}  // namespace

std::vector<double> mean_autocovariances(const Chains& draws) {
  check_shape(draws);
  const std::size_t size = std::bit_ceil(2 * draws.draws);
  const std::vector<Complex> roots = unit_roots(size);

  // Add up the squared moduli. Each transform handles two chains.
  std::vector<Complex> power(size);
  std::vector<Complex> z(size);
  for (std::size_t first = 0; first < draws.chains; first += 2) {
    z.assign(size, {});
    for (std::size_t i = 0; i < 2 && first + i < draws.chains; ++i) {
      const auto chain = draws.chain(first + i);
      const double mean = mean_of(chain);
      for (std::size_t d = 0; d < draws.draws; ++d)
        (i == 0 ? z[d].real : z[d].imaginary) = chain[d] - mean;
    }
    transform(z, roots);
    for (std::size_t k = 0; k < size; ++k)
      power[k].real += z[k].real * z[k].real + z[k].imaginary * z[k].imaginary;
  }

  // For real values, the forward transform is the conjugate of the inverse transform.
  transform(power, roots);
  const double scale = static_cast<double>(size) * static_cast<double>(draws.values.size());
  std::vector<double> autocovariances(draws.draws);
  for (std::size_t t = 0; t < draws.draws; ++t)
    autocovariances[t] = power[t].real / scale;
  return autocovariances;
}

}  // namespace sleight::sampling
