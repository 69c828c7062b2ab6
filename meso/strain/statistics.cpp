#include "meso/strain/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace trame::meso {
namespace {

/// The same where values have weights.
double quantile(const std::vector<WeightedValue>& sorted, double weight, double share) {
  double sum = 0;
  for (const WeightedValue& v : sorted) {
    sum += v.weight;
    if (sum >= share * weight) return v.value;
  }
  return sorted.back().value;  // round-off
}

}  // namespace

double quantile(const std::vector<double>& sorted, double share) {
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::max(rank, std::size_t{1}) - 1];
}

Statistics weighted_statistics(std::vector<WeightedValue> values) {
  double weight = 0, sum = 0, squares = 0;
  for (const WeightedValue& v : values) {
    weight += v.weight;
    sum += v.weight * v.value;
  }
  if (!(weight > 0)) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, nan, nan, nan, nan, nan, nan};
  }
  Statistics result{.mean = sum / weight};
  for (const WeightedValue& v : values) squares += v.weight * (v.value - result.mean) * (v.value - result.mean);
  result.deviation = std::sqrt(squares / weight);
  std::sort(values.begin(), values.end(),
            [](const WeightedValue& a, const WeightedValue& b) { return a.value < b.value; });
  result.min = values.front().value;
  result.quantile_05 = quantile(values, weight, 0.05);
  result.median = quantile(values, weight, 0.5);
  result.quantile_95 = quantile(values, weight, 0.95);
  result.max = values.back().value;
  return result;
}

}  // namespace trame::meso
