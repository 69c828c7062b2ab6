#include "meso/bands/orientation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "meso/bands/contrast.h"

namespace trame::meso {

void DirectionalCorrelation::add(const Picture& values, double pixels_per_distance) {
  std::vector<double> finite;
  for (const double x : values.reshaped())
    if (std::isfinite(x)) finite.push_back(x);
  if (finite.empty()) return;
  const RobustScale scale = robust_scale(std::move(finite));
  const Picture centred =  // NaN stays
      values.unaryExpr([&](double x) { return std::clamp(x, scale.low, scale.high) - scale.mean; });
  for (std::size_t k = 0; k < n_directions; ++k) {
    const double a = angle(k) * std::numbers::pi / 180, pixels = lag * pixels_per_distance;
    const auto down = static_cast<Eigen::Index>(std::lround(pixels * std::sin(a))),
               right = static_cast<Eigen::Index>(std::lround(pixels * std::cos(a)));
    const Eigen::Index first = std::max<Eigen::Index>(0, -down), end = centred.rows() - std::max<Eigen::Index>(0, down);
    for (Eigen::Index c = 0; c + right < centred.cols(); ++c)
      for (Eigen::Index r = first; r < end; ++r) {
        const double p = centred(r, c), q = centred(r + down, c + right);
        if (!std::isfinite(p) || !std::isfinite(q)) continue;
        products_[k] += p * q;
        squares_[k] += 0.5 * (p * p + q * q);
      }
  }
}

std::array<double, DirectionalCorrelation::n_directions> DirectionalCorrelation::values() const {
  std::array<double, n_directions> result{};
  for (std::size_t k = 0; k < n_directions; ++k)
    result[k] = squares_[k] > 0 ? products_[k] / squares_[k] : std::numeric_limits<double>::quiet_NaN();
  return result;
}

}  // namespace trame::meso
