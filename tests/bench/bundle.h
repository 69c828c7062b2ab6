#pragma once
/// \file
/// A bundle of touching fibers and its matrix, for benchmarks of what an increment consists of.

#include <memory>
#include <vector>

#include "micro/contact/contact.h"
#include "micro/fiber/enriched_beam.h"
#include "micro/fiber/rod.h"
#include "micro/solve/linear_solver.h"
#include "micro/weave/flat_start.h"

namespace trame::micro::bench {

/// A bundle of fibers of radius 1 that touch their neighbours all along, elements of length 10.
struct Bundle {
  Bundle(Index n_fibers, FiberModel model, Index n_elements = 40, double penalty = ContactLaw{}.penalty)
      : assembly(make_assembly(n_fibers, n_elements, model)),
        field(assembly.mesh, std::vector(n_fibers, model), layout),
        contact(field, {.penalty = penalty}, std::vector(n_fibers, 1.0)) {
    state.q.assign(layout.n_vectors(), Vec3::Zero());
    field.read_configuration(assembly.configuration, state);
    contact.begin_step(state, 1);
    contact.update(state);
    if (model == FiberModel::enriched)
      elastic =
          std::make_unique<EnrichedBeams>(field, std::vector(n_fibers, material()), assembly.configuration, false);
    else
      elastic = std::make_unique<Rods>(field, std::vector(n_fibers, material()));
    Pattern::Builder builder;
    contact.add_sparsity(builder);
    elastic->add_sparsity(builder);
    pattern = Pattern(layout, builder);
    values.resize(pattern.n_values());
    force.resize(layout.n_dofs());
    magnitude.resize(layout.n_vectors());
  }
  static Material material() { return {"m", 1, 1, 0.4, 0.25, 0.25, 0}; }
  static Assembly make_assembly(Index n_fibers, Index n_elements, FiberModel model) {
    Scene scene;
    scene.materials = {material()};
    scene.fiber_types = {{"f", 0, 1.0, model}};
    scene.bundles = {{"b", 0, {{0, 0, 0}, {10.0 * n_elements, 0, 0}}, n_elements, n_fibers, 0, 1.0, 0.5}};
    return assemble_scene(scene);
  }
  void assemble(const Effect& effect) {
    Assembler assembler(layout, &pattern, 0, layout.n_nodes(), force.data(), magnitude.data(), values.data(),
                        Assembler::Tangent::exact);
    effect.add(state, assembler);
  }

  /// The matrix of fibers and contacts, held so that the free bundle has no rigid motion.
  void assemble_matrix(double stiffness = 0.1) {
    assemble(*elastic);
    assemble(contact);
    for (Index j = 0; j < layout.n_nodes(); ++j)
      for (Index c = 0; c < 3 * layout.n_vectors(j); ++c)
        values[pattern.value_start(j) + static_cast<std::size_t>(c) * pattern.column_height(j) + c] += stiffness;
  }

  Assembly assembly;
  Layout layout;
  FiberField field;
  Contact contact;
  State state;
  std::unique_ptr<Effect> elastic;
  Pattern pattern;
  std::vector<double> values, force, magnitude;
};

}  // namespace trame::micro::bench
