#pragma once
/// \file
/// Where fibers come close: proximity zones and their intermediate geometry, found with a grid in O(n log n).
///
/// Two stretches that run side by side have as intermediate geometry the midpoints of the chords that are normal to the
/// mean tangent, parametrised by the mean arc length τ = ½(s_a + σ s_b), σ = ±1 their sense. It is sampled at multiples
/// of a spacing, so that a sample keeps its identity while the fibers move. Stretches that cross at more than 30° meet
/// in one point of closest approach. Swapping a and b changes nothing.

#include <functional>

#include "micro/fiber/fiber_field.h"

namespace trame::micro {

/// A pair of particles on the centre lines, a < b (or s_a < s_b on one fiber).
struct Proximity {
  Index fiber_a = 0, fiber_b = 0;
  double s_a = 0, s_b = 0;
  Vec3 chord = Vec3::Zero();  ///< r_b − r_a
  double length = 0;          ///< length of fiber that the sample stands for
  bool crossing = false;      ///< closest approach of fibers that cross
};

struct ProximitySearch {
  double spacing = 0.5;        ///< of samples, in element lengths
  double search_margin = 0.5;  ///< pairs up to this surface distance are returned, in radii (the mean of both)
  bool self_contact = false;
  std::function<bool(Index, Index)> wanted;  ///< pairs of fibers to look at; empty: all
};

/// The same particles with the chord that they have at another state, less what of it is not normal to the fibers
/// there.
[[nodiscard]] Proximity facing(const FiberField& field, const State& state, Proximity pair);

/// All proximities, sorted by fibers and arc length. Result and order depend on the state alone.
[[nodiscard]] std::vector<Proximity> find_proximities(const FiberField& field, const State& state,
                                                      const ProximitySearch& search);

/// The chord normal to the mean tangent at mean arc length tau; false where it leaves a fiber. `u` is a first guess
/// of ½(s_a − σ s_b) and gets the solution.
[[nodiscard]] bool intermediate_chord(const FiberField& field, const State& state, Proximity& pair, double sense,
                                      double tau, double& u);
/// Closest approach of two fibers from a first guess in `pair`; false where it lies outside of a fiber.
[[nodiscard]] bool closest_approach(const FiberField& field, const State& state, Proximity& pair);

}  // namespace trame::micro
