#include "meso/bands/contrast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "meso/strain/statistics.h"

namespace trame::meso {
namespace {

Eigen::MatrixXd gaussian_kernel(Eigen::Index n, double sigma) {
  Eigen::MatrixXd kernel(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) kernel(i, j) = std::exp(-0.5 * std::pow(double(i - j) / sigma, 2));
  return kernel;
}

struct Place {
  Eigen::Index row = 0, column = 0;
};

std::vector<Place> places(const Mask& mask, Place first, Index side) {
  std::vector<Place> result;
  for (Eigen::Index c = std::max<Eigen::Index>(first.column, 0); c < std::min(first.column + side, mask.cols()); ++c)
    for (Eigen::Index r = std::max<Eigen::Index>(first.row, 0); r < std::min(first.row + side, mask.rows()); ++r)
      if (mask(r, c)) result.push_back({r, c});
  return result;
}

/// One of the eight ways to lay a square on itself, with one place laid on another.
class Move {
 public:
  Move(const Place& from, const Place& to, unsigned symmetry) : from_(from), to_(to), symmetry_(symmetry) {}

  /// Nothing where the place comes to lie outside the mask.
  [[nodiscard]] std::optional<Place> operator()(const Place& place, const Mask& mask) const {
    Eigen::Index down = place.row - from_.row, right = place.column - from_.column;
    if (symmetry_ & 1U) down = -down;
    if (symmetry_ & 2U) right = -right;
    if (symmetry_ & 4U) std::swap(down, right);
    const Place moved{to_.row + down, to_.column + right};
    const bool inside = moved.row >= 0 && moved.row < mask.rows() && moved.column >= 0 && moved.column < mask.cols() &&
                        mask(moved.row, moved.column);
    return inside ? std::optional(moved) : std::nullopt;
  }

 private:
  Place from_, to_;
  unsigned symmetry_;
};

}  // namespace

GaussianSmoother::GaussianSmoother(const Mask& mask, double sigma, SmoothOrder order)
    : mask_(mask), order_(order), vertical_(gaussian_kernel(mask.rows(), sigma)),
      horizontal_(gaussian_kernel(mask.cols(), sigma)) {
  const Picture mass = blurred(mask.cast<double>()).max(std::numeric_limits<double>::min());
  weight_one_ = 1 / mass;
  if (order == SmoothOrder::linear) fit_lines(mass);
}

/// The fit at x is T₁/m + (x − c)ᵀ S⁻¹ (T_x − c T₁)/m, with the blurred mass m, centroid c, second moments S and values
/// T: weights of T₁ and T_x that depend on the mask alone.
void GaussianSmoother::fit_lines(const Picture& mass) {
  const Eigen::Index rows = mask_.rows(), columns = mask_.cols();
  const Picture in = mask_.cast<double>();
  const auto centred = [](Eigen::Index n) {
    return Eigen::ArrayXd::LinSpaced(n, -0.5 * double(n - 1), 0.5 * double(n - 1));
  };
  x_ = centred(columns).transpose().replicate(rows, 1);
  y_ = centred(rows).replicate(1, columns);
  const Picture cx = blurred(in * x_) / mass, cy = blurred(in * y_) / mass;
  // Pixels on one line have no slope across it: a little is added to their second moments.
  const Picture sxx = blurred(in * x_ * x_) / mass - cx * cx + 1e-6,
                syy = blurred(in * y_ * y_) / mass - cy * cy + 1e-6;
  const Picture sxy = blurred(in * x_ * y_) / mass - cx * cy, det = sxx * syy - sxy * sxy;
  weight_x_ = (syy * (x_ - cx) - sxy * (y_ - cy)) / (det * mass);
  weight_y_ = (sxx * (y_ - cy) - sxy * (x_ - cx)) / (det * mass);
  weight_one_ -= weight_x_ * cx + weight_y_ * cy;
}

Picture GaussianSmoother::blurred(const Picture& picture) const {
  // Coefficient by coefficient: threads of the library's own would only be in the way of those over cuts.
  const Eigen::MatrixXd columns = vertical_.lazyProduct(picture.matrix());
  return columns.lazyProduct(horizontal_).array();
}

Picture GaussianSmoother::operator()(const Picture& values) const {
  const Picture in = mask_.select(values, 0.0);
  Picture estimate = weight_one_ * blurred(in);
  if (order_ == SmoothOrder::linear) estimate += weight_x_ * blurred(in * x_) + weight_y_ * blurred(in * y_);
  return estimate;
}

RobustScale robust_scale(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  RobustScale scale{.low = quantile(values, 0.01), .high = quantile(values, 0.99)};
  const auto moved =
      Eigen::Map<Eigen::ArrayXd>(values.data(), Eigen::Index(values.size())).max(scale.low).min(scale.high);
  scale.mean = moved.mean();
  scale.deviation = std::sqrt((moved - scale.mean).square().mean());
  scale.rms = std::sqrt(moved.square().mean());
  return scale;
}

Index label_regions(const Mask& mask, Eigen::ArrayXX<Index>& region) {
  region.setZero(mask.rows(), mask.cols());
  Index n_regions = 0;
  std::vector<std::array<Eigen::Index, 2>> open;
  const auto visit = [&](Eigen::Index row, Eigen::Index column) {
    if (row < 0 || row >= mask.rows() || column < 0 || column >= mask.cols()) return;
    if (!mask(row, column) || region(row, column) != 0) return;
    region(row, column) = n_regions;
    open.push_back({row, column});
  };
  for (Eigen::Index column = 0; column < mask.cols(); ++column)
    for (Eigen::Index row = 0; row < mask.rows(); ++row) {
      if (!mask(row, column) || region(row, column) != 0) continue;
      ++n_regions;
      visit(row, column);
      while (!open.empty()) {
        const auto [r, c] = open.back();
        open.pop_back();
        visit(r - 1, c);
        visit(r + 1, c);
        visit(r, c - 1);
        visit(r, c + 1);
      }
    }
  return n_regions;
}

Mask dilated(const Mask& mask, double distance) {
  Mask result = mask;
  const auto reach = static_cast<Eigen::Index>(std::floor(distance));
  for (Eigen::Index column = 0; column < mask.cols(); ++column)
    for (Eigen::Index row = 0; row < mask.rows(); ++row) {
      if (!mask(row, column)) continue;
      for (Eigen::Index c = std::max<Eigen::Index>(column - reach, 0); c <= std::min(column + reach, mask.cols() - 1);
           ++c)
        for (Eigen::Index r = std::max<Eigen::Index>(row - reach, 0); r <= std::min(row + reach, mask.rows() - 1); ++r)
          if (std::hypot(double(r - row), double(c - column)) <= distance) result(r, c) = true;
    }
  return result;
}

Picture shuffled_blocks(const Picture& values, const Mask& mask, Index side, std::mt19937& random) {
  constexpr int n_tries = 20;  // to find a place from which a block can be taken whole
  const std::vector<Place> all = places(mask, {0, 0}, static_cast<Index>(std::max(mask.rows(), mask.cols())));
  const auto draw = [&](const std::vector<Place>& from) { return from[random() % from.size()]; };
  const auto offset = [&] { return static_cast<Eigen::Index>(random() % static_cast<unsigned>(side)); };
  const Place start{-offset(), -offset()};
  Picture result = values;
  for (Eigen::Index column = start.column; column < mask.cols(); column += side)
    for (Eigen::Index row = start.row; row < mask.rows(); row += side) {
      std::vector<Place> block = places(mask, {row, column}, side);
      while (!block.empty()) {  // what a place does not give is taken from another one
        std::vector<Place> best_left = block;
        std::optional<Move> best;
        for (int k = 0; k < n_tries && !best_left.empty(); ++k) {
          const Move move(draw(block), draw(all), random() % 8);
          std::vector<Place> left;
          for (const Place& place : block)
            if (!move(place, mask)) left.push_back(place);
          if (left.size() >= best_left.size()) continue;
          best_left = std::move(left);
          best = move;
        }
        for (const Place& place : block)
          if (const auto source = (*best)(place, mask))
            result(place.row, place.column) = values(source->row, source->column);
        block = std::move(best_left);
      }
    }
  return result;
}

}  // namespace trame::meso
