#pragma once
/// \file
/// Sections of yarns as SVG: outlines of fibers, strain maps, colour bars. Drawings that share a window have one scale.

#include <array>
#include <string>
#include <vector>

#include "meso/bands/band_survey.h"

namespace trame::workflows {

/// What a drawing shows of a section's plane, and how large. User units of the SVG are µm, y down.
struct Window {
  Vec2 low = Vec2::Zero(), high = Vec2::Zero();  ///< m
  double pixels = 0;                             ///< width of the drawing
};

/// The smallest window that holds all the sections with a margin; a drawing of it is `pixels` wide.
[[nodiscard]] Window window_around(const std::vector<const meso::Section*>& sections, double pixels);

[[nodiscard]] std::string section_svg(const meso::Section& section, const Window& window,
                                      const std::string& fill_colour);

enum class ColourMap : std::uint8_t {
  diverging,  ///< blue, grey, red: signs and sizes (Moreland's cool-warm)
  sequential  ///< viridis: sizes
};

/// Values and the colours that show them; what is beyond the range has the colour of its end.
struct ColourScale {
  ColourMap map = ColourMap::diverging;
  double low = 0, high = 0;
};

/// "#rrggbb"; t: 0…1 along the map.
[[nodiscard]] std::string colour(ColourMap map, double t);

/// The scale that shows all but the outermost 5 % of the finite values: about zero where they have signs, from zero
/// where they have none.
[[nodiscard]] ColourScale scale_for(std::vector<double> values, ColourMap map);

/// With its ends and middle in percent.
[[nodiscard]] std::string colour_bar_svg(const ColourScale& scale);

/// Values (NaN where there are none) as coloured pixels under the outlines of the section's fibers, and the edges of
/// the regions that `bands` marks: solid for significant ones, dotted for the others.
[[nodiscard]] std::string strain_map_svg(const meso::YarnCut& cut, const meso::Picture& values,
                                         const ColourScale& scale, const meso::Section& section, const Window& window,
                                         const meso::SectionBands& bands);

/// Areas of bands by the direction of their length: a rose with sectors of 15°, its two halves alike. Empty without
/// bands.
[[nodiscard]] std::string rose_svg(const std::vector<meso::ShearBand>& bands);

/// A colour and a value for each direction, as of meso::DirectionalCorrelation.
struct DirectionCurve {
  std::string colour;
  std::array<double, meso::DirectionalCorrelation::n_directions> values = {};
};

/// Values by direction as distances from the middle, a closed curve for each; negative ones and NaN are in the middle.
/// The circle is at `full`, a dotted one at `noise`. Empty where no curve has a value.
[[nodiscard]] std::string direction_curves_svg(const std::vector<DirectionCurve>& curves, double full, double noise);

}  // namespace trame::workflows
