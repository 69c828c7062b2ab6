/// A program outside Trame: builds a scene, runs it and reads a force.

#include <cstdio>

#include "micro/simulate.h"
#include "micro/states/snapshot.h"

constexpr const char* scene = R"(
[material.pa66]
model = "isotropic"
young_modulus = "3 GPa"
poisson_ratio = 0.39
[fiber_type.fiber]
material = "pa66"
diameter = "20 um"
[[fiber]]
name = "fiber"
fiber_type = "fiber"
points = [["0 mm", "0 mm", "0 mm"], ["1 mm", "0 mm", "0 mm"]]
elements = 4
[[body]]
name = "left"
position = ["0 mm", "0 mm", "0 mm"]
tie = [{fibers = "fiber", end = "start"}]
[[body]]
name = "right"
position = ["1 mm", "0 mm", "0 mm"]
tie = [{fibers = "fiber", end = "end"}]
[[stage]]
name = "pull"
increments = 2
drive = [{bodies = "right", dof = "x", displacement = "10 um"}]
)";

int main() {
  (void)trame::micro::simulate(trame::micro::parse_scene(scene, "scene"), {.states = "states.h5"});
  const trame::micro::SnapshotReader states("states.h5");
  std::printf("%.4f mN\n", 1e3 * states.read(states.n_increments() - 1).bodies.force[1].x());
}
