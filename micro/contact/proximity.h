#pragma once
/// \file
/// Where fibers come close: found with a grid in O(n log n), as samples along stretches that stay close and as points
/// where one place is closest.
///
/// Of two fibers that come near each other the distance d(s_a, s_b) has a valley. Where the valley is flat, fibers
/// touch along a line: it is sampled at (k + ½) spacings of the mean arc length τ = ½(s_a + σ s_b), σ = ±1 their sense,
/// so that a sample keeps its identity while the fibers move, and those of fibers side by side stay away from where
/// elements join. Where it is steep they touch at its lowest point. What tells them apart is how far d rises over half
/// a spacing, not an angle: fibers that wind around each other stay at one distance at any angle. In between both kinds
/// act, with weights that add up to one and go over into each other. Swapping a and b changes nothing.

#include <span>
#include <tuple>
#include <vector>

#include "micro/contact/closest_points.h"
#include "micro/contact/contact_law.h"

namespace trame::micro {

/// A pair of points on the centre lines, a < b (or s_a < s_b on one fiber).
///
/// In a periodic cell b may be an image. Of all pairs that are the same but for whole periods there is one: the image
/// of a is the fiber itself; so is that of b along a period by which either fiber comes back, whose arc length then
/// counts on; and where both come back by the same one, samples have 0 ≤ τ and points 0 ≤ s_a less than one period.
struct Proximity {
  Chord chord;
  double length = 0;         ///< length of contact that it stands for
  double share = 1;          ///< part of its surroundings that it stands for
  bool point = false;        ///< the shortest chord nearby, not a sample along a line
  Hold hold;                 ///< σ and τ₀ of both kinds; a sample stays at τ₀
  Vec2 lean = Vec2::Zero();  ///< slope by (s_a, s_b) of what is minimised with ½|c|²: none while pairs are looked for

  /// The chord by its feet alone: where it is followed from.
  void keep(Archive& archive) {
    archive(chord.a, chord.b, length, share, point, hold.stiffness, hold.sense, hold.mean_arc_length, lean[0], lean[1]);
  }

  [[nodiscard]] Index fiber_a() const { return chord.a.fiber; }
  [[nodiscard]] Index fiber_b() const { return chord.b.fiber; }
  [[nodiscard]] double s_a() const { return chord.a.s; }
  [[nodiscard]] double s_b() const { return chord.b.s; }
  [[nodiscard]] const Image& image() const { return chord.b.image; }
};

/// How far the arc lengths (s_a, s_b) of a pair of fibers change with a whole number of periods by which both come
/// back.
[[nodiscard]] inline Vec2 whole_periods(const FiberField& field, Index fiber_a, Index fiber_b, double n) {
  return n * Vec2(field.mesh().length(fiber_a), field.mesh().length(fiber_b));
}
/// A difference of such arc lengths, less the whole periods in it.
[[nodiscard]] inline Vec2 without_periods(const FiberField& field, Index fiber_a, Index fiber_b, const Vec2& ds) {
  if (!field.come_back_together(fiber_a, fiber_b)) return ds;
  return ds - whole_periods(field, fiber_a, fiber_b, std::round(ds[0] / field.mesh().length(fiber_a)));
}

/// A pair for people: both arc lengths within their fibers, all periods in the image of b. And back.
struct PlacesInCell {
  double s_a, s_b;
  Image image;
};
[[nodiscard]] PlacesInCell in_first_periods(const FiberMesh& mesh, Index fiber_a, Index fiber_b, PlacesInCell pair);
[[nodiscard]] PlacesInCell counted_on(const FiberMesh& mesh, Index fiber_a, Index fiber_b, PlacesInCell pair);

/// A point that pressed when the last increment was accepted, and the length of contact that it stood for.
struct KnownPoint {
  Index fiber_a = 0, fiber_b = 0;
  Image image{};
  double s_a = 0, s_b = 0, length = 0;
  [[nodiscard]] std::tuple<Index, Index, Image> pair() const { return {fiber_a, fiber_b, image}; }
};

/// All proximities, sorted by fibers and arc length. Result and order depend on the state and on `known` points alone,
/// which are sorted by pairs. Those stay, and lose what they stand for but slowly: otherwise fibers would sink until
/// there is a point, which would lift them until there is none.
[[nodiscard]] std::vector<Proximity> find_proximities(const FiberField& field, const State& state,
                                                      const ProximitySearch& search,
                                                      std::span<const KnownPoint> known = {});

/// The same pair at another state: feet have slid to where the chord, with what leans on it, is shortest, at the mean
/// arc length of a sample. Where they would slide out of reach they stay.
void follow(const FiberField& field, const State& state, Proximity& pair);

/// Which share of a contact samples stand for, the rest being a point's, where the distance rises by `rise` over half a
/// spacing: 1 up to 0.005 R, 0 from 0.03 R on, smooth between.
[[nodiscard]] double share_of_samples(double rise, double radius);

}  // namespace trame::micro
