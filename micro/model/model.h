#pragma once
/// \file
/// A stage of a scene as a system of effects. Only what the stage calls for is built.

#include <memory>
#include <vector>

#include "micro/model/stage_start.h"
#include "micro/solve/load_path.h"
#include "micro/solve/proximal.h"
#include "micro/weave/crossing_order.h"

namespace trame::micro {

/// Units of the computation: the mean radius of the fiber types that fibers are of and the largest axial modulus of
/// their materials, so that everything inside is of order 1. What no fiber has does not count.
struct Scales {
  double length = 1;  ///< m
  double stress = 1;  ///< Pa
  [[nodiscard]] double force() const { return stress * length * length; }
  [[nodiscard]] double energy() const { return force() * length; }
};
[[nodiscard]] Scales natural_scales(const Scene& scene);
/// The scene in its natural units.
[[nodiscard]] Scene nondimensional(const Scene& scene, const Scales& scales);

/// How a dof of a body is driven through a stage.
struct DofDrive {
  enum class Kind : std::uint8_t { held, displacement, force, follow } kind = Kind::held;
  double value = 0;  ///< displacement or force at an amplitude of 1: without one, at the stage's end
  Amplitude amplitude = {};
};

/// The equations of one stage.
struct StageModel {
  StageModel(const Scene& scene, const Assembly& assembly, const Stage& stage, const StageStart& from);
  StageModel(const StageModel&) = delete;
  StageModel& operator=(const StageModel&) = delete;

  /// The first stage time after `time` at which a drive or load turns; 1 where none does.
  [[nodiscard]] double next_turn(double time) const;
  [[nodiscard]] PrescribedMotion motion(const State& state, double from, double to) const;
  /// Force and moment with which a body pulls at its fibers and followers.
  /// (Of a period, the force that its drive acts with; effects must have followed `state`.)
  [[nodiscard]] std::pair<Vec3, Vec3> pull(const State& state, Index body) const;
  /// Whether a body stands for a period vector.
  [[nodiscard]] bool is_period(Index body) const {
    return body == assembly_.period_bodies[0] || body == assembly_.period_bodies[1];
  }
  /// The same of all bodies, 6 numbers each.
  [[nodiscard]] std::vector<double> body_forces(const State& state) const;
  /// The same as a stage begins. Nothing pulls at leaders yet: what their followers carry is what they take over; but
  /// dofs that are loaded start from the load of before.
  [[nodiscard]] std::vector<double> loads_at_start(const StageStart& from) const;
  [[nodiscard]] Index n_contact_elements() const;
  /// Whether there is anything that fibers can touch.
  [[nodiscard]] bool has_contact() const { return contact || surface_contact; }
  /// Of fibers in each other and in surfaces.
  [[nodiscard]] double max_penetration_over_radius() const;
  [[nodiscard]] std::string describe_dof(Index dof) const;

  Layout layout;
  RigidBodies bodies;
  FiberField field;
  State start;
  std::vector<DofDrive> drives;  ///< 6 per body
  Effects effects;
  // The effects that others ask; null where the stage does not call for them.
  Contact* contact = nullptr;
  SurfaceContact* surface_contact = nullptr;
  CrossingOrder* crossing_order = nullptr;
  Proximal* proximal = nullptr;
  Ties* ties = nullptr;
  Follow* follow = nullptr;
  BodyLoads* loads = nullptr;
  FiberLoads* fiber_loads = nullptr;
  std::vector<StandingLoad> standing_loads;  ///< what is on once the stage is over

 private:
  void resolve_drives(const Scene& scene, const Assembly& assembly, const Stage& stage, const StageStart& from);
  void add_fibers(const Scene& scene, const Assembly& assembly);
  void add_contact(const Scene& scene, const Assembly& assembly, const Stage& stage, const StageStart& from);
  void add_surfaces(const Scene& scene, const Assembly& assembly, const Stage& stage, const StageStart& from);
  void add_bodies(const Assembly& assembly, const Stage& stage, const StageStart& from);
  void add_fiber_loads(const Scene& scene, const Assembly& assembly, const Stage& stage, const StageStart& from);
  [[nodiscard]] std::vector<TieTerm> tie_terms(const Assembly& assembly, const Stage& stage) const;
  [[nodiscard]] std::vector<LoadTerm> load_terms(const StageStart& from) const;
  [[nodiscard]] Vec3 period_force(const State& state, Index body) const;

  const Assembly& assembly_;
  std::vector<FollowTerm> follow_terms_;
};

/// Whether a surface is there in a stage, and whether that is the first one.
[[nodiscard]] bool is_there(const SurfaceSpec& surface, const Scene& scene, const Stage& stage);
[[nodiscard]] bool comes_in(const SurfaceSpec& surface, const Scene& scene, const Stage& stage);
/// Material of each fiber.
[[nodiscard]] std::vector<Material> fiber_materials(const Scene& scene, const Assembly& assembly);
/// Fiber model of each fiber in a stage.
[[nodiscard]] std::vector<FiberModel> models_in_stage(const Scene& scene, const Assembly& assembly, const Stage& stage);
/// Yarn crossings as upper over lower.
[[nodiscard]] std::vector<YarnCrossing> ordered_crossings(const Assembly& assembly);

}  // namespace trame::micro
