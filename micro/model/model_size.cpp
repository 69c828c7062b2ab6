#include "micro/model/model_size.h"

#include <algorithm>

#include "micro/model/model.h"

namespace trame::micro {

ModelSize model_size(const Scene& scene) {
  const Assembly assembly = assemble_scene(scene);
  ModelSize size;
  size.n_fibers = assembly.mesh.n_fibers();
  size.n_nodes = assembly.mesh.n_nodes();
  size.n_bodies = static_cast<Index>(assembly.body_names.size());
  for (const Stage& stage : scene.stages) {
    Layout layout;
    const RigidBodies bodies(size.n_bodies, layout);
    const FiberField field(assembly.mesh, models_in_stage(scene, assembly, stage), layout, assembly.period_bodies);
    size.n_dofs_per_stage.push_back(layout.n_dofs());
    size.n_dofs = std::max<std::int64_t>(size.n_dofs, layout.n_dofs());
  }
  return size;
}

}  // namespace trame::micro
