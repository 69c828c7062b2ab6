#pragma once
/// \file
/// Where the camera of a picture stands, and how long its scale bar is. Lengths in µm.

#include <string>
#include <vector>

#include "micro/core/types.h"

namespace trame::workflows {

constexpr double picture_margin = 0.025;  ///< of the picture's width

/// Where the camera stands and how large the picture gets.
struct Frame {
  Vec3 focal_point = Vec3::Zero();
  Vec3 backward = Vec3::UnitZ();  ///< unit, from the focal point to the camera
  Vec3 up = Vec3::UnitY();        ///< unit, normal to `backward`
  double distance = 1;            ///< from the focal point to the camera
  bool parallel = true;           ///< projection
  double pixel = 1;               ///< length that a pixel spans at the focal point
  int width = 0, height = 0;      ///< pixels
};

/// The frame that holds all points with a margin and room for the scale bar below. `backward` and `up` need not be
/// normal to each other.
[[nodiscard]] Frame fit_frame(const std::vector<Vec3>& points, const Vec3& backward, const Vec3& up, bool parallel,
                              int width);

/// Length and text of a scale bar: the longest of 1, 2, 5 × 10ⁿ µm that is not above `longest`, µm.
struct ScaleBar {
  double length = 0;  ///< µm
  std::string text;
};
[[nodiscard]] ScaleBar choose_scale_bar(double longest);

}  // namespace trame::workflows
