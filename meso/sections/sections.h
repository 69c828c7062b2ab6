#pragma once
/// \file
/// Cross-sections of a yarn: where a plane normal to its mean axis cuts its fibers, how large and how full the section
/// is, whether it is a lens or an ellipse, and how axial strain is spread over its width.

#include <cstdint>
#include <string_view>
#include <vector>

#include "meso/sections/outline.h"
#include "micro/fiber/fiber_mesh.h"

namespace trame::meso {

enum class SectionStatus : std::uint8_t {
  ok,
  beyond_end,  ///< the station is before the start of the yarn or after its end
  no_fiber     ///< the plane meets none of the yarn's fibers, or their directions cancel out
};

[[nodiscard]] std::string_view text(SectionStatus status);

/// Where a fiber passes through a section. Its outline is the ellipse centre + half_axes (cos t, sin t), in the plane
/// (horizontal, vertical) from the section's origin, m; a point where the fiber's radius is unknown.
struct FiberCut {
  Index fiber = 0;  ///< of the fiber mesh
  double s = 0;     ///< arc length of the fiber there, reference state, m
  Vec2 centre = Vec2::Zero();
  Eigen::Matrix2d half_axes = Eigen::Matrix2d::Zero();  ///< columns: conjugate half diameters

  [[nodiscard]] double area() const;  ///< m²
};

/// One section. The yarn's outline is the convex hull of the outlines of its fibers.
struct Section {
  SectionStatus status = SectionStatus::ok;
  double fraction = 0;           ///< of the fibers' lengths at which their mean is here, reference state, 0…1
  double arc_length = 0;         ///< of the mean curve from its start, in this state, m
  Vec3 origin = Vec3::Zero();    ///< on the mean curve, m
  Mat3 frame = Mat3::Zero();     ///< rows: axial, horizontal, vertical, see `yarn_frame`
  std::vector<FiberCut> fibers;  ///< without those that end before the plane or run along it (within 6°)
  std::vector<Vec2> outline;     ///< counter-clockwise, in the plane, m
  OutlineShape shape;
  double fiber_area = 0;  ///< sum over the fibers, m²
  double fill = 0;        ///< fiber_area / shape.area; above what packing allows where fibers interpenetrate; NaN
                          ///< where radii are unknown
};

/// Sections to a yarn where no one asks for another number.
inline constexpr Index default_stations = 12;

/// Cuts one yarn in one state, about the mean of its fibers at equal fractions of their lengths. All arguments of the
/// constructor must outlive the object.
class YarnSections {
 public:
  YarnSections(const micro::FiberMesh& mesh, const micro::Yarn& yarn, const micro::FiberConfiguration& fibers);

  [[nodiscard]] const micro::FiberConfiguration& fibers() const { return fibers_; }
  [[nodiscard]] double length() const { return arc_length_.back(); }  ///< of the mean curve in this state, m
  /// Of the mean curve at a fraction of the fibers' lengths, m.
  [[nodiscard]] Vec3 mean_position(double fraction) const;
  /// Section at an arc length of the mean curve, m.
  [[nodiscard]] Section at(double arc_length) const;
  /// Section at a fraction of the fibers' lengths: the same material in every state.
  [[nodiscard]] Section at_fraction(double fraction) const;
  /// `n` sections in the middles of n pieces of equal arc length.
  [[nodiscard]] std::vector<Section> series(Index n) const;

 private:
  const micro::FiberMesh& mesh_;
  const micro::Yarn& yarn_;
  const micro::FiberConfiguration& fibers_;
  std::vector<double> arc_length_;  // of the mean curve at equal steps of the fraction
};

/// Axial Green-Lagrange strain E_ss = ½(|r'_B|² / |r'_A|² − 1) of the fibers of a section, each the mean over the two
/// Gauss points of the 3-node element that the section cuts: what the fiber itself feels, known for every fiber, also
/// for those around which the yarn's mesh is inverted. It differs from E_axial of tetrahedra by the angle between fiber
/// and yarn. NaN for an element without length in A.
[[nodiscard]] std::vector<double> axial_strains(const micro::FiberMesh& mesh, const Section& section,
                                                const std::vector<Vec3>& r_a, const std::vector<Vec3>& r_b);

/// Means of a quantity of the fibers at the sides of a section (outer quarters of the outline's width) and in its
/// centre (middle half). NaN for a part without fibers.
struct SideToCentre {
  double side = 0, centre = 0;
  Index n_side = 0, n_centre = 0;
  /// side / centre; NaN where |centre| is less than 1 % of the largest value, or below 10⁻¹²: a ratio to nothing.
  double ratio = 0;
};

/// `values`: one for each of `section.fibers`; NaN are left out.
[[nodiscard]] SideToCentre side_to_centre(const Section& section, const std::vector<double>& values);

}  // namespace trame::meso
