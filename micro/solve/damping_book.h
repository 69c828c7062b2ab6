#pragma once
/// \file
/// What forces take that store nothing.

#include <utility>
#include <vector>

#include "micro/core/archive.h"
#include "micro/core/types.h"

namespace trame::micro {

/// Work of forces on vectors of a state, each of which goes over a step from what it was after the last one to what it
/// is now: Σ ½ (f_n + f)·motion.
struct DampingBook {
  double dissipated = 0;
  std::vector<Vec3> force;  ///< after the last step

  /// Enters the motion of vector i in a step, at whose end this force acts.
  void enter(std::size_t i, const Vec3& now, const Vec3& motion) {
    if (force.size() <= i) force.resize(i + 1, Vec3::Zero());
    const Vec3 before = std::exchange(force[i], now);
    dissipated += 0.5 * (before + now).dot(motion);
  }
  void keep(Archive& archive, std::size_t n_vectors) {
    archive(dissipated, force);
    archive.require(force.empty() || force.size() == n_vectors, "forces of other fibers");
  }
};

}  // namespace trame::micro
