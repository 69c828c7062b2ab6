/// The same strains, wherever the nodes come from.

#include <gtest/gtest.h>

#include "tests/support/analyse.h"
#include "tests/support/fiber_files.h"
#include "tests/support/lattice_yarns.h"
#include "tests/support/temporary_folder.h"
#include "workflows/strains/fiber_nodes.h"

namespace trame::workflows {
namespace {

using micro::test::LatticeYarns;
using micro::test::mapped;
using test::Hdf5File;
using test::polylines;
using test::write_vtp;
using trame::test::TemporaryFolder;
namespace fs = std::filesystem;

TEST(FiberNodes, GiveTheSameStrainsAsAStateFile) {
  const TemporaryFolder folder;
  const LatticeYarns yarns{.n_yarns = 2};
  const micro::FiberMesh mesh = yarns.mesh();
  micro::Increment states[2];
  states[0].fibers = yarns.configuration();
  states[1].fibers = mapped(yarns.configuration(), Vec3(1.02, 1, 0.96).asDiagonal());
  {
    micro::SnapshotWriter writer(folder / "states.h5", {"1", "scene", "", mesh, {}});
    Hdf5File nodes(folder / "nodes.h5");
    nodes.put("fibers/start", std::vector<int>(mesh.first_node.begin(), mesh.first_node.end()));
    nodes.put("fibers/yarn", std::vector<int>(mesh.yarn_of_fiber.begin(), mesh.yarn_of_fiber.end()));
    for (int i = 0; i < 2; ++i) {
      writer.append(states[i]);
      nodes.put("increments/" + std::to_string(i) + "/position", states[i].fibers.r);
      write_vtp(folder / (std::to_string(i) + ".vtp"),
                polylines(states[i].fibers.r, mesh.first_node, {mesh.yarn_of_fiber.begin(), mesh.yarn_of_fiber.end()}));
    }
  }
  const auto analysis = [](const std::vector<fs::path>& files) {
    return meso::test::analyse(*open_states(files), {.to = {1}}).strains;
  };
  const auto run = analysis({folder / "states.h5"});
  for (const auto& other : {analysis({folder / "nodes.h5"}), analysis({folder / "0.vtp", folder / "1.vtp"})}) {
    ASSERT_EQ(other.size(), 2u);
    for (int y = 0; y < 2; ++y) {
      EXPECT_EQ(other[y].n_tets, run[y].n_tets);
      EXPECT_NEAR(other[y].axial.mean, 0.5 * (1.02 * 1.02 - 1), 1e-12);
      EXPECT_NEAR(other[y].vertical.max, 0.5 * (0.96 * 0.96 - 1), 1e-12);
      EXPECT_NEAR(other[y].gamma_max.mean, run[y].gamma_max.mean, 1e-12);
    }
  }
}

}  // namespace
}  // namespace trame::workflows
