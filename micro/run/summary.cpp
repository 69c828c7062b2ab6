#include "micro/run/summary.h"

#include <algorithm>

namespace trame::micro {

void SimulationSummary::count(const SolverRecord& increment, Index n_contact_elements) {
  n_contact_elements_max = std::max(n_contact_elements_max, n_contact_elements);
  ++n_increments;
  n_cut_increments += increment.n_cuts;
  n_newton_iterations += increment.n_newton_iterations;
  n_factorizations += increment.n_factorizations;
  n_unstable_increments += increment.unstable;
  max_penetration_over_radius = increment.max_penetration_over_radius;
  if (increment.proximal == 0)
    deepest_penetration_over_radius = std::max(deepest_penetration_over_radius, increment.max_penetration_over_radius);
  force_imbalance = increment.force_imbalance;
  moment_imbalance = increment.moment_imbalance;
  energy = increment.energy;
}

}  // namespace trame::micro
