#pragma once
/// \file
/// Distributions of values that stand for volumes.

#include <vector>

namespace trame::meso {

/// A value and the volume that it holds for.
struct WeightedValue {
  double value = 0, weight = 0;
};

/// The smallest of the sorted values at or below which lies the given share of them (nearest rank). At least one value.
[[nodiscard]] double quantile(const std::vector<double>& sorted, double share);

/// Quantiles: at or below them lie 5 %, half and 95 % of the weight. All NaN where there is no weight.
struct Statistics {
  double mean = 0, deviation = 0;
  double min = 0, quantile_05 = 0, median = 0, quantile_95 = 0, max = 0;
};

/// Values are finite, weights ≥ 0.
[[nodiscard]] Statistics weighted_statistics(std::vector<WeightedValue> values);

}  // namespace trame::meso
