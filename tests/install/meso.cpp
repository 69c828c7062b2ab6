/// A program outside Trame: strains of the yarns of a run's states.

#include <cstdio>

#include "meso/comparison.h"

int main(int, char** argv) {
  const trame::meso::RunStates states(argv[1]);
  const trame::meso::YarnComparer comparer(states);
  for (const auto& yarn : comparer.compare({0, states.n_increments() - 1}).yarns)
    std::printf("%s: %d tetrahedra\n", states.header().mesh.yarns[yarn.yarn].name.c_str(),
                yarn.on_mesh().summary.n_tets);
}
