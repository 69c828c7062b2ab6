#pragma once
/// \file
/// Rigid bodies: their unknowns, the ties of fiber ends to them, bodies that follow other bodies, and loads on them.
/// A body has one node of two vectors: position c and rotation R. Reference coordinates X are kept in the body's own
/// frame.

#include <string>

#include "micro/core/amplitude.h"
#include "micro/fiber/fiber_field.h"
#include "micro/rigid/body_dof.h"
#include "micro/solve/effect.h"

namespace trame::micro {

/// Pose of a body.
struct Pose {
  Vec3 position = Vec3::Zero();
  Mat3 rotation = Mat3::Identity();

  void keep(Archive& archive) { archive(position, rotation); }
};

/// The bodies of a scene and where their unknowns stand: body i is node i of the layout.
class RigidBodies {
 public:
  /// Adds a node per body to `layout`, which must be empty. The dofs x, y, z and rx, ry, rz of the first `n_skew`
  /// bodies count along and about `axes`, the columns, of length 1.
  RigidBodies(Index n_bodies, Layout& layout, Index n_skew = 0, const Mat3& axes = Mat3::Identity());
  /// What a vector is in the dofs of a body; and a force in those that are conjugate to them, so that the sum of their
  /// products is its work.
  [[nodiscard]] Vec3 in_dofs(Index body, const Vec3& vector) const { return axes(body).inverse() * vector; }
  [[nodiscard]] Vec3 force_in_dofs(Index body, const Vec3& force) const { return axes(body).transpose() * force; }
  /// The force that is 1 in dof d (0, 1, 2) of a body and nothing in its others; its product with a vector is the
  /// vector's in that dof.
  [[nodiscard]] Vec3 unit_force(Index body, int d) const { return axes(body).inverse().transpose() * Vec3::Unit(d); }
  [[nodiscard]] Index n_bodies() const { return n_bodies_; }
  [[nodiscard]] Index node(Index body) const { return body; }
  /// Dof of the system that holds dof d (x, y, z, rx, ry, rz) of a body.
  [[nodiscard]] Index dof(Index body, BodyDof d) const { return n_body_dofs * body + static_cast<Index>(d); }
  [[nodiscard]] Pose pose(const State& state, Index body) const { return {state.q[2 * body], state.rotations[body]}; }
  /// How a step shifts and turns a body, and its pose before the step that led to `state`.
  [[nodiscard]] const Vec3& shift(const Vec3* step, Index body) const { return step[2 * body]; }
  [[nodiscard]] const Vec3& turn(const Vec3* step, Index body) const { return step[2 * body + 1]; }
  [[nodiscard]] Pose pose_before(const State& state, const Vec3* step, Index body) const {
    return {state.q[2 * body] - shift(step, body), rotation_matrix(-turn(step, body)) * state.rotations[body]};
  }
  void set_pose(State& state, Index body, const Pose& pose) const {
    state.q[2 * body] = pose.position;
    state.rotations[body] = pose.rotation;
  }

 private:
  [[nodiscard]] Mat3 axes(Index body) const { return body < n_skew_ ? axes_ : Mat3(Mat3::Identity()); }
  Index n_bodies_, n_skew_;
  Mat3 axes_;
};

/// Unknown vectors whose mean v̄ is held by a body, ½ k n |e|²:
///   point       e = P (v̄ − c − R X)
///   vector      e = P (v̄ − R X)
///   direction   e = P (v̄ − |v̄| R X), |X| = 1: where v̄ points, whatever its length
struct TieTerm {
  enum class Holds : std::uint8_t { point, vector, direction };
  Index body = 0;
  std::vector<std::pair<Index, int>> members;  ///< node and vector
  Holds holds = Holds::point;
  Vec3 reference = Vec3::Zero();      ///< X in the body's frame
  Mat3 projector = Mat3::Identity();  ///< P in the body's frame; turned with the body once a step
  double stiffness = 0;               ///< k of each member
};

/// Fiber ends that follow bodies. The penalty is stiff against the fiber (10³ EA/h), so that its compliance does not
/// show.
class Ties final : public Effect {
 public:
  Ties(const Layout& layout, const RigidBodies& bodies, std::vector<TieTerm> terms);
  [[nodiscard]] std::string_view name() const override { return "ties"; }
  void begin_step(const State& start, double stage_time) override;
  void add_sparsity(Pattern::Builder& builder) const override;
  void add(const State& state, Assembler& assembler) const override;
  [[nodiscard]] double energy(const State& state) const override;
  /// Force and moment with which the body pulls at its fibers.
  [[nodiscard]] std::pair<Vec3, Vec3> pull(const State& state, Index body) const;
  [[nodiscard]] std::size_t n_terms() const { return terms_.size(); }

 private:
  struct Deviation {
    Vec3 arm, e;     // e = P (v̄ − [c] − arm), arm = R X or |v̄| R X
    Mat3 projector;  // P
    Vec3 unit;       // v̄/|v̄| of a direction
    Mat3 by_mean;    // ∂e/∂v̄
  };
  [[nodiscard]] Vec3 mean(const Vec3* vectors, const TieTerm& term) const;
  [[nodiscard]] Deviation deviation(const Vec3& mean, const Pose& pose, const TieTerm& term) const;
  [[nodiscard]] Deviation deviation(const State& state, const TieTerm& term) const;
  /// e at the start of the last step, and its change with that to first order.
  [[nodiscard]] Vec3 expected(const State& state, const Vec3* last_step, const TieTerm& term) const;
  const Layout& layout_;
  const RigidBodies& bodies_;
  std::vector<TieTerm> terms_;
  std::vector<Mat3> frozen_rotation_;  // per body, for the projectors
};

/// A translation dof of a body that moves with the rigid motion of a leader since a start pose.
struct FollowTerm {
  Index follower = 0, leader = 0;
  int axis = 0;  ///< 0, 1, 2
  Pose leader_start;
  Vec3 follower_start = Vec3::Zero();
  double stiffness = 0;
};

/// ½ k (c_f − target)² in that dof of the follower, target = c_l + R_l R_l,startᵀ (c_f,start − c_l,start).
class Follow final : public Effect {
 public:
  Follow(const RigidBodies& bodies, std::vector<FollowTerm> terms) : bodies_(bodies), terms_(std::move(terms)) {}
  [[nodiscard]] std::string_view name() const override { return "follow"; }
  void add_sparsity(Pattern::Builder& builder) const override;
  void add(const State& state, Assembler& assembler) const override;
  [[nodiscard]] double energy(const State& state) const override;
  /// Force and moment with which a leader pulls at its followers.
  [[nodiscard]] std::pair<Vec3, Vec3> pull(const State& state, Index leader) const;
  /// Each term after those of which its follower is the leader.
  [[nodiscard]] std::vector<FollowTerm> outermost_first() const;

 private:
  struct Deviation {
    double e;
    Vec3 arm;
  };
  [[nodiscard]] Deviation deviation(const Pose& leader, const Pose& follower, const FollowTerm& term) const;
  [[nodiscard]] Deviation deviation(const State& state, const FollowTerm& term) const;
  [[nodiscard]] double expected(const State& state, const Vec3* last_step, const FollowTerm& term) const;
  const RigidBodies& bodies_;
  std::vector<FollowTerm> terms_;
};

/// A force or moment on a body's dof that goes from `start` to `end` and beyond, as its amplitude says.
struct LoadTerm {
  Index body = 0;
  BodyDof dof = BodyDof::x;
  double start = 0, end = 0;
  Amplitude amplitude = {};
};

/// Dead forces and moments on bodies. A moment acts about the fixed axis on the current rotation.
class BodyLoads final : public Effect {
 public:
  BodyLoads(const RigidBodies& bodies, std::vector<LoadTerm> terms) : bodies_(bodies), terms_(std::move(terms)) {}
  [[nodiscard]] std::string_view name() const override { return "body loads"; }
  void begin_step(const State&, double stage_time) override { stage_time_ = stage_time; }
  void add_sparsity(Pattern::Builder&) const override {}
  void add(const State& state, Assembler& assembler) const override;
  /// −F·c of the forces; a moment has no potential and is left out.
  [[nodiscard]] double energy(const State& state) const override;
  /// Nothing: the work of loads is that of the bodies, which are moved in other ways, too.
  [[nodiscard]] Ledger ledger(const State&) const override { return {}; }

 private:
  [[nodiscard]] double value(const LoadTerm& term) const {
    return term.start + term.amplitude.at(stage_time_) * (term.end - term.start);
  }
  const RigidBodies& bodies_;
  std::vector<LoadTerm> terms_;
  double stage_time_ = 0;
};

}  // namespace trame::micro
