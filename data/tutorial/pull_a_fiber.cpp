/// Trame as a library: builds a scene, runs it, reads the force. SI units.

#include <cstdio>

#include "micro/simulate.h"

using namespace trame::micro;

int main() {
  Scene scene;
  scene.name = "pull_a_fiber";
  scene.materials = {{.name = "pa66",
                      .young_modulus_axial = 3e9,
                      .young_modulus_transverse = 3e9,
                      .shear_modulus_axial = 3e9 / (2 * 1.39),
                      .poisson_ratio_axial = 0.39,
                      .poisson_ratio_transverse = 0.39}};
  scene.fiber_types = {{.name = "filament", .radius = 10e-6}};
  scene.fibers = {{.name = "fiber", .points = {{0, 0, 0}, {1e-3, 0, 0}}, .n_elements = 4}};
  scene.bodies = {{.name = "left", .ties = {{.fibers = "fiber", .end = FiberEnd::start}}},
                  {.name = "right", .position = {1e-3, 0, 0}, .ties = {{.fibers = "fiber", .end = FiberEnd::end}}}};
  scene.stages = {{.name = "pull", .n_increments = 2, .drives = {{.bodies = "right", .value = 10e-6}}}};

  (void)simulate(scene, {.states = "states.h5"});
  const SnapshotReader states("states.h5");
  const Increment last = states.read(states.n_increments() - 1);
  std::printf("%.4f mN\n", 1e3 * last.bodies.force[1].x());
}
