#pragma once
/// \file
/// Direction, thickness and length of a band from the values of the pixels in and around it.

#include <vector>

#include "micro/core/types.h"

namespace trame::meso {

struct BandPixel {
  Vec2 position;      ///< fiber distances
  double excess = 0;  ///< value minus what its surroundings would have without the band
};

/// Direction along which the excess varies least, degrees from the horizontal, counter-clockwise, in (−90, 90]: the one
/// for which a function of the distance across it explains most of the squares. Second moments of the region
/// would be simpler, but the outline of a yarn cuts bands off obliquely, which turns their principal axes by many
/// degrees where the yarn is few fibers thick.
struct BandDirection {
  double angle = 0;
  double straightness = 0;  ///< share of the sum of squares that is explained, 1 for a perfect straight band
};
[[nodiscard]] BandDirection band_direction(const std::vector<BandPixel>& pixels);

/// Equivalent width of the mean profile across a band, fiber distances: its integral over its plateau. The integral is
/// that of the peak, on both sides as far as it is above a tenth of its top; the plateau is the mean of the middle
/// third of the width. For shear it is the jump in displacement over the shear of the core. The full width at half
/// maximum, the more usual measure, jumps from one row of fibers to the next where a band is parallel to them; this one
/// does not.
[[nodiscard]] double band_thickness(const std::vector<BandPixel>& pixels, double angle);

}  // namespace trame::meso
