#pragma once
/// \file
/// The start of a simulation: fibers of a scene laid out as it says; the yarns of a weave straight and flat in one
/// plane, interpenetrating where they cross.

#include <array>
#include <string>
#include <vector>

#include "micro/fiber/fiber_mesh.h"
#include "micro/scene/scene.h"

namespace trame::micro {

/// A tie of one fiber end to a body.
struct EndTie {
  Index body = 0;
  Index fiber = 0;
  FiberEnd end = FiberEnd::start;
  TieKind kind = TieKind::clamped;
};

/// Crossing of warp yarn and weft yarn, as indices into FiberMesh::yarns.
struct WeaveCrossing {
  Index warp_yarn = 0, weft_yarn = 0;
  bool warp_above = false;
};

struct Assembly {
  FiberMesh mesh;
  FiberConfiguration configuration;  ///< free of stress
  std::vector<Index> type_of_fiber;  ///< index into Scene::fiber_types
  std::vector<std::string> body_names;
  std::vector<Vec3> body_positions;
  std::vector<EndTie> ties;
  std::vector<WeaveCrossing> crossings;
  Index n_skew_bodies = 0;  ///< the first of them, whose dofs count along `skew_axes`: warp, weft and z
  Mat3 skew_axes = Mat3::Identity();
  std::array<Index, 2> period_bodies{-1, -1};  ///< whose positions are the period vectors of a cell; negative: none
  double flat_height = 0;                      ///< how deep yarns start in those that they shall part from, at most
};

/// Lays out every fiber, yarn and body of a scene, in the unit of its lengths.
[[nodiscard]] Assembly assemble_scene(const Scene& scene);

}  // namespace trame::micro
