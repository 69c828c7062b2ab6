#include "workflows/picture/picture_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace trame::workflows {
namespace {

constexpr double bar_strip = 0.06;     // of the picture's width, below the patch
constexpr double max_aspect = 2.0;     // height over width
constexpr double camera_distance = 4;  // in diagonals of the patch: about 14 degrees of view

/// Smallest box around points in the picture plane.
struct Box {
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::max());
  Vec2 high = Vec2::Constant(std::numeric_limits<double>::lowest());
};

/// The points as the camera sees them, in lengths at the focal point and relative to it.
Box projected(const std::vector<Vec3>& points, const Frame& frame) {
  const Vec3 right = frame.up.cross(frame.backward);
  Box box;
  for (const Vec3& point : points) {
    const Vec3 x = point - frame.focal_point;
    const double shrink = frame.parallel ? 1 : frame.distance / (frame.distance - x.dot(frame.backward));
    const Vec2 seen = shrink * Vec2(x.dot(right), x.dot(frame.up));
    box.low = box.low.cwiseMin(seen);
    box.high = box.high.cwiseMax(seen);
  }
  return box;
}

}  // namespace

Frame fit_frame(const std::vector<Vec3>& points, const Vec3& backward, const Vec3& up, bool parallel, int width) {
  Vec3 low = points.front(), high = points.front();
  for (const Vec3& point : points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  Frame frame;
  frame.backward = backward.normalized();
  frame.up = (up - up.dot(frame.backward) * frame.backward).normalized();
  frame.focal_point = 0.5 * (low + high);
  frame.distance = camera_distance * (high - low).norm();
  frame.parallel = parallel;
  frame.width = width;
  const double side = picture_margin * width, strip = bar_strip * width;
  // Moving the camera sideways changes what perspective makes of the points, but by less each time.
  for (int i = 0; i < 4; ++i) {
    const Box box = projected(points, frame);
    const Vec2 size = box.high - box.low, centre = 0.5 * (box.low + box.high);
    frame.pixel = std::max(size.x() / (width - 2 * side), size.y() / (max_aspect * width - 2 * side - strip));
    frame.height = static_cast<int>(std::ceil(size.y() / frame.pixel + 2 * side + strip));
    frame.focal_point +=
        centre.x() * frame.up.cross(frame.backward) + (centre.y() - 0.5 * strip * frame.pixel) * frame.up;
  }
  return frame;
}

ScaleBar choose_scale_bar(double longest) {
  const double power = std::pow(10.0, std::floor(std::log10(longest)));
  const double length = (longest >= 5 * power ? 5 : longest >= 2 * power ? 2 : 1) * power;
  if (length >= 1e6) return {length, fmt::format("{:g} m", length / 1e6)};
  if (length >= 1e3) return {length, fmt::format("{:g} mm", length / 1e3)};
  return {length, fmt::format("{:g} µm", length)};
}

}  // namespace trame::workflows
