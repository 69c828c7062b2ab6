#pragma once
/// \file
/// How what is driven gets to its value through a stage.

#include <algorithm>
#include <vector>

namespace trame::micro {

/// Shares of a drive's value over stage time, straight from point to point; it begins at (0, 0). Without points it is
/// the ramp from 0 to 1.
struct Amplitude {
  struct Point {
    double time = 0, share = 0;
    bool operator==(const Point&) const = default;
  };
  std::vector<Point> points;  ///< times ascend to 1

  [[nodiscard]] double at(double time) const {
    if (points.empty()) return time;
    Point before;
    for (const Point& point : points) {
      if (time <= point.time)
        return before.share + (point.share - before.share) * (time - before.time) / (point.time - before.time);
      before = point;
    }
    return before.share;
  }
  bool operator==(const Amplitude&) const = default;
};

}  // namespace trame::micro
