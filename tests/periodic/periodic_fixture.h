#pragma once
/// \file
/// Small periodic cells, without a run.

#include <Eigen/Geometry>
#include <memory>

#include "micro/model/model.h"
#include "tests/support/run_scene.h"

namespace trame::micro::test {

/// A cell of single fibers of radius 1: `n_warp` along x, 5 apart from weft to weft, and `n_weft` along y, `spacing`
/// apart, the warp above by `rise`. Nothing is separated: they touch as they are laid out.
struct CellOptions {
  FiberModel model = FiberModel::enriched;
  Index n_warp = 2, n_weft = 2;
  Index n_elements = 2;   ///< so long that what crosses touches at points alone
  int weft_elements = 1;  ///< times that, of the weft
  bool is_strip = false;  ///< the warp has two ends
  double spacing = 1.95, rise = 1.95;
  double angle = Weave{}.angle;  ///< from the warp to the weft
};
inline Scene cell_scene(const CellOptions& o) {
  Scene scene;
  scene.name = "cell";
  scene.materials = {isotropic(1, 0.25)};
  scene.fiber_types = {{"f", 0, 1.0, o.model}};
  Weave weave;
  weave.angle = o.angle;
  const auto system = [&](Index n, Index n_elements, double spacing, double crossing_spacing) {
    YarnSystem yarns;
    yarns.kinds = {{.type = 0, .n_fibers = 1}};
    yarns.n_yarns = n;
    yarns.n_elements = n_elements;
    yarns.yarn_spacing = spacing;
    yarns.margin = 0.5 * crossing_spacing / weave.weft_direction().y();
    yarns.periodic = true;
    return yarns;
  };
  weave.warp = system(o.n_warp, o.n_elements, o.spacing, 5);
  weave.weft = system(o.n_weft, o.weft_elements * o.n_elements, 5, o.spacing);
  weave.warp.periodic = !o.is_strip;
  weave.warp_above.assign(o.n_weft, std::vector<bool>(o.n_warp, true));
  scene.weave = weave;
  scene.contact.friction_coefficient = 0.4;
  scene.solver.force_tolerance = 1e-9;
  Stage stage;
  stage.name = "load";
  scene.stages = {stage};
  return scene;
}

/// The assembly with the warp lifted.
inline Assembly lifted(const Scene& scene, double rise) {
  Assembly assembly = assemble_scene(scene);
  const FiberMesh& mesh = assembly.mesh;
  for (Index f = 0; f < mesh.n_fibers(); ++f)
    if (mesh.yarns[mesh.yarn_of_fiber[f]].family == YarnFamily::warp)
      for (Index n = mesh.first_node[f]; n < mesh.first_node[f + 1]; ++n) assembly.configuration.r[n].z() += rise;
  return assembly;
}

/// A stage's model at its start, with contacts looked for.
struct Cell {
  explicit Cell(const CellOptions& o)
      : scene(cell_scene(o)), assembly(lifted(scene, o.rise)), start(start_of(assembly)),
        model(std::make_unique<StageModel>(scene, assembly, scene.stages[0], start)), state(model->start) {}

  /// Gradient of all effects at a state that they look at anew.
  [[nodiscard]] std::vector<double> gradient(const State& at) const {
    std::vector<double> force(model->layout.n_dofs(), 0.0), magnitude(model->layout.n_vectors(), 0.0);
    Assembler assembler(model->layout, nullptr, 0, model->layout.n_nodes(), force.data(), magnitude.data(), nullptr,
                        Assembler::Tangent::none);
    for (const auto& effect : model->effects) {
      effect->begin_step(at, 1);
      effect->update(at);
      effect->add(at, assembler);
    }
    return force;
  }

  Scene scene;
  Assembly assembly;
  StageStart start;
  std::unique_ptr<StageModel> model;
  State state;
};

}  // namespace trame::micro::test
