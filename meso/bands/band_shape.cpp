#include "meso/bands/band_shape.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace trame::meso {
namespace {

/// Mean excess as a function of the distance across a direction; each pixel is shared by the two nearest points.
struct Profile {
  double step = 0;
  std::vector<double> weight = {}, sum = {};

  [[nodiscard]] std::size_t size() const { return sum.size(); }
  [[nodiscard]] double mean(std::size_t i) const { return weight[i] > 0 ? sum[i] / weight[i] : 0; }
};

Profile profile_across(const std::vector<BandPixel>& pixels, double degrees, double step) {
  const Vec2 across = Eigen::Rotation2Dd(degrees * std::numbers::pi / 180) * Vec2::UnitY();
  std::vector<double> at;
  for (const BandPixel& pixel : pixels) at.push_back(across.dot(pixel.position) / step);
  const auto [low, high] = std::minmax_element(at.begin(), at.end());
  Profile profile{.step = step};
  profile.weight.assign(static_cast<std::size_t>(*high - *low) + 2, 0.0);
  profile.sum = profile.weight;
  for (std::size_t p = 0; p < pixels.size(); ++p) {
    const double x = at[p] - *low;
    const auto i = static_cast<std::size_t>(x);
    for (const auto& [j, share] : {std::pair(i, 1 - (x - double(i))), std::pair(i + 1, x - double(i))}) {
      profile.weight[j] += share;
      profile.sum[j] += share * pixels[p].excess;
    }
  }
  return profile;
}

/// Sum of squares that the mean profile explains.
double explained(const std::vector<BandPixel>& pixels, double degrees) {
  const Profile profile = profile_across(pixels, degrees, 0.5);
  double squares = 0;
  for (std::size_t i = 0; i < profile.size(); ++i) squares += profile.mean(i) * profile.sum[i];
  return squares;
}

/// Highest point of a profile, of those that enough pixels stand for.
std::size_t top(const Profile& profile) {
  const double enough = 0.2 * *std::max_element(profile.weight.begin(), profile.weight.end());
  const auto height = [&](std::size_t i) { return profile.weight[i] >= enough ? profile.mean(i) : 0.0; };
  std::size_t best = 0;
  for (std::size_t i = 1; i < profile.size(); ++i)
    if (height(i) > height(best)) best = i;
  return best;
}

/// Mean of the points from `first` to `last` within `reach` steps of `middle`.
double mean_around(const Profile& profile, std::size_t first, std::size_t last, double middle, double reach) {
  double sum = 0, weight = 0;
  for (std::size_t i = first; i <= last; ++i) {
    if (std::abs(double(i) - middle) > reach) continue;
    sum += profile.sum[i];
    weight += profile.weight[i];
  }
  return sum / weight;
}

}  // namespace

BandDirection band_direction(const std::vector<BandPixel>& pixels) {
  std::vector<double> squares;  // at −89°, −88°, …, 90°
  for (int degrees = -89; degrees <= 90; ++degrees) squares.push_back(explained(pixels, degrees));
  const auto best = static_cast<std::size_t>(std::max_element(squares.begin(), squares.end()) - squares.begin());
  const double before = squares[(best + 179) % 180], at = squares[best], after = squares[(best + 1) % 180];
  const double bend = 2 * at - before - after;
  double angle = double(best) - 89 + (bend > 0 ? 0.5 * (after - before) / bend : 0);  // top of the parabola
  if (angle > 90) angle -= 180;
  double total = 0;
  for (const BandPixel& pixel : pixels) total += pixel.excess * pixel.excess;
  return {angle, total > 0 ? at / total : 0};
}

double band_thickness(const std::vector<BandPixel>& pixels, double angle) {
  const Profile profile = profile_across(pixels, angle, 0.25);
  const std::size_t peak = top(profile);
  const double floor = 0.1 * profile.mean(peak);
  std::size_t first = peak, last = peak;
  while (first > 0 && profile.mean(first - 1) > floor) --first;
  while (last + 1 < profile.size() && profile.mean(last + 1) > floor) ++last;
  double integral = 0, moment = 0;
  for (std::size_t i = first; i <= last; ++i) {
    integral += profile.mean(i) * profile.step;
    moment += profile.mean(i) * profile.step * double(i);
  }
  double plateau = profile.mean(peak);
  for (int k = 0; k < 3; ++k) {  // the middle third depends on the width; it settles at once
    const double reach = std::max(integral / plateau / 6 / profile.step, 0.5);
    plateau = mean_around(profile, first, last, moment / integral, reach);
  }
  return integral / plateau;
}

}  // namespace trame::meso
