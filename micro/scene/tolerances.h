#pragma once
/// \file
/// What increments may end on.

#include <algorithm>

#include "micro/scene/scene.h"

namespace trame::micro {

/// What Newton's method ends on: residual over the forces that fibers get from outside.
[[nodiscard]] inline double force_tolerance(const SolverSettings& solver) {
  return std::min(solver.force_tolerance, solver.geometry_tolerance);
}

/// Residual of an increment once limits of friction are renewed, which a certificate of balance is held against. Limits
/// that follow forces that follow limits may go to and fro a little below that.
[[nodiscard]] inline double friction_tolerance(const SolverSettings& solver) {
  constexpr double over_force_tolerance = 100, least = 1e-6;
  return std::max(over_force_tolerance * force_tolerance(solver), least);
}

}  // namespace trame::micro
