#include "micro/scene/driven_dofs.h"

#include "micro/core/name_table.h"

namespace trame::micro {

std::vector<DrivenDof> driven_dofs(const Scene& scene, const std::vector<std::string>& body_names) {
  const NameTable bodies(body_names);
  std::vector<DrivenDof> all(n_body_dofs * body_names.size());
  for (std::size_t s = 0; s < scene.stages.size(); ++s)
    for (const Drive& drive : scene.stages[s].drives)
      for (const Index body : bodies.fitting(drive.bodies)) {
        DrivenDof& driven = all[n_body_dofs * static_cast<std::size_t>(body) + static_cast<std::size_t>(drive.dof)];
        driven.body = body;
        driven.dof = drive.dof;
        driven.modes.resize(scene.stages.size());
        driven.modes[s] = drive.mode;
      }
  std::erase_if(all, [](const DrivenDof& driven) { return driven.modes.empty(); });
  return all;
}

}  // namespace trame::micro
