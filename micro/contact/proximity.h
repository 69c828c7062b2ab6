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

#include <functional>

#include "micro/contact/closest_points.h"

namespace trame::micro {

/// A pair of points on the centre lines, a < b (or s_a < s_b on one fiber).
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
};

struct ProximitySearch {
  double spacing = 0.5;        ///< of samples, in element lengths
  double search_margin = 0.5;  ///< pairs up to this surface distance are returned, in radii (the mean of both)
  bool self_contact = false;
  std::function<bool(Index, Index)> wanted;  ///< pairs of fibers to look at; empty: all
};

/// All proximities, sorted by fibers and arc length. Result and order depend on the state alone.
[[nodiscard]] std::vector<Proximity> find_proximities(const FiberField& field, const State& state,
                                                      const ProximitySearch& search);

/// The same pair at another state: feet have slid to where the chord, with what leans on it, is shortest, at the mean
/// arc length of a sample. Where they would slide out of reach they stay.
void follow(const FiberField& field, const State& state, Proximity& pair);

/// Which share of a contact samples stand for, the rest being a point's, where the distance rises by `rise` over half a
/// spacing: 1 up to 0.005 R, 0 from 0.03 R on, smooth between.
[[nodiscard]] double share_of_samples(double rise, double radius);

}  // namespace trame::micro
