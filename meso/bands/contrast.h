#pragma once
/// \file
/// Tools for pictures with a mask: smoothing, robust scale, connected regions, pictures shuffled in blocks.

#include <Eigen/Core>
#include <random>
#include <vector>

#include "meso/bands/strain_cut.h"

namespace trame::meso {

enum class SmoothOrder : std::uint8_t {
  mean,   ///< weighted mean
  linear  ///< weighted linear fit: follows gradients up to the outline
};

/// Estimates a picture from the pixels of a mask around each pixel, with Gaussian weights: normalized convolution
/// (Knutsson & Westin, CVPR 1993), of first order where it is `linear`.
class GaussianSmoother {
 public:
  /// `sigma`: pixels.
  GaussianSmoother(const Mask& mask, double sigma, SmoothOrder order);

  /// Values outside the mask are not looked at; the estimates cover all pixels.
  [[nodiscard]] Picture operator()(const Picture& values) const;

 private:
  [[nodiscard]] Picture blurred(const Picture& picture) const;
  void fit_lines(const Picture& mass);

  Mask mask_;
  SmoothOrder order_;
  Eigen::MatrixXd vertical_, horizontal_;     ///< one-dimensional kernels
  Picture x_, y_;                             ///< pixel coordinates, 0 in the middle
  Picture weight_one_, weight_x_, weight_y_;  ///< of the blurred moments in the estimate
};

/// A scale that a few wild values do not change: values beyond the 1st and the 99th percentile are moved there
/// (winsorized).
struct RobustScale {
  double low = 0, high = 0;                 ///< the percentiles
  double mean = 0, deviation = 0, rms = 0;  ///< of the moved values
};

/// `values`: finite, at least one.
[[nodiscard]] RobustScale robust_scale(std::vector<double> values);

/// Numbers the connected regions (neighbours share a side) of a mask 1, 2, …; 0 elsewhere. Returns how many there are.
Index label_regions(const Mask& mask, Eigen::ArrayXX<Index>& region);

/// The mask and what is within `distance` pixels of it.
[[nodiscard]] Mask dilated(const Mask& mask, double distance);

/// Puts a picture together anew from square blocks taken at random places, with replacement, turned and mirrored at
/// random: what is left is the order within blocks (block bootstrap, Künsch, Ann. Stat. 17, 1989).
/// `side`: pixels.
[[nodiscard]] Picture shuffled_blocks(const Picture& values, const Mask& mask, Index side, std::mt19937& random);

}  // namespace trame::meso
