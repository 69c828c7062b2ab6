#pragma once
/// \file
/// Contact and friction of fibers with the rigid surfaces of bodies.

#include <optional>
#include <string>
#include <vector>

#include "micro/contact/contact_element.h"
#include "micro/contact/contact_law.h"
#include "micro/rigid/rigid_body.h"
#include "micro/rigid/surface.h"

namespace trame::micro {

/// A surface of a body, with friction of its own.
struct BodySurface {
  Index body = 0;
  Surface surface;
  double friction_coefficient = 0;  ///< µ; 0: none
  std::string body_name;            ///< for messages
};

/// What history keeps of a place that touches a surface, between increments and stages.
struct SurfaceContactHistory {
  Index surface = 0, fiber = 0, sample = 0;
  double penalty_scale = 1, preload = 0, raised_at = 0;
  bool stuck = false;
  Vec3 traction = Vec3::Zero();  ///< Friction::force, in the frame of the body
  PenaltyLaw law;                ///< of the accepted increment
  double gap = 0;                ///< likewise

  void keep(Archive& archive) {
    archive(surface, fiber, sample, penalty_scale, preload, raised_at, stuck, traction, law.penalty, law.preload,
            law.p_reg, gap);
  }
};

/// A place of a fiber that may touch a surface:
///   g = φ(c) − R |w|,   w = (n·g₁, n·g₂),   n = ∇φ(c)     (rods: |w| = 1)
/// with the centre line c, the section vectors g and the signed distance φ of the surface. R |w| is how far the
/// deformed section reaches along n.
struct SurfaceContactElement : AugmentedPenalty {
  Index surface = 0, fiber = 0, sample = 0;
  double s = 0;       ///< arc length
  double length = 0;  ///< of fiber that the place stands for
  double radius = 0;
  CurveShape shape;
  Vec2 particle = Vec2::Zero();  ///< ξ of the particle that friction follows
  bool has_pressed = false;      ///< in the increment, since it was last looked for without `keep`

  /// The gap and what its derivatives need, at the state last followed, in the frame of space.
  struct Gap {
    double value = 0;
    SurfaceView view;
    Mat3 rotation = Mat3::Identity();  ///< of the body
    Vec3 arm = Vec3::Zero();           ///< of the centre line from the body's position
    std::array<Vec3, 2> section{Vec3::Zero(), Vec3::Zero()};
    Vec2 w = Vec2::Zero();                 ///< w/|w|
    double size = 0;                       ///< |w|; 0 where the section is seen edge on, and of rods
    Vec3 force_direction = Vec3::UnitZ();  ///< m of δg = m·δc
  } measured;

  [[nodiscard]] double gap() const { return measured.value; }
  [[nodiscard]] double force(double p_reg) const { return law(p_reg).force(gap()); }
  /// Of fiber and surface on each other: N = f |m|.
  [[nodiscard]] double normal_force(double p_reg) const { return force(p_reg) * measured.force_direction.norm(); }
  [[nodiscard]] double stiffness(double p_reg) const { return penalty_stiffness(gap() - preload, penalty, p_reg); }
  [[nodiscard]] double energy(double p_reg) const { return law(p_reg).energy(gap()); }
};

/// Penalty contact with Coulomb friction between fibers and surfaces. Fibers touch at fixed places, `spacing` apart or,
/// where a surface is more curved than that, as near as leaves no more than a small part of a radius between places.
class SurfaceContact final : public Effect {
 public:
  /// `modulus` per fiber: what a penalty is measured in (transverse modulus). µ of the law does not count.
  SurfaceContact(const FiberField& field, const RigidBodies& bodies, std::vector<BodySurface> surfaces,
                 const ContactLaw& law, std::vector<double> modulus);

  [[nodiscard]] std::string_view name() const override { return "contact with surfaces"; }
  void begin_step(const State& start, double stage_time) override;
  void update(const State& state, bool keep = false) override;
  bool follow(const State& state, Follow what, const Region& region) override;
  /// A fiber may go half of its distance to the nearest surface; its body likewise, which may not turn farther.
  void limit_reach(const State& state, std::span<double> reach) const override;
  void add_sparsity(Pattern::Builder& builder) const override;
  void add(const State& state, Assembler& assembler) const override;
  void add_unsymmetric(const State& state, UnsymmetricTerms& terms) const override;
  [[nodiscard]] double energy(const State& state) const override;
  [[nodiscard]] Ledger ledger(const State& state) const override;
  /// A centre line that has got behind a surface, be it on the way: it may have come out on the other side.
  [[nodiscard]] std::string inadmissibility(const State&, const State&) const override { return got_behind_; }
  void commit(const State& state) override;
  void keep(Archive& archive) override;
  [[nodiscard]] bool stiffen(const State& state, double elastic_energy, double slack) override;

  /// The first centre line that is behind a surface at a state, in words; empty where none is.
  [[nodiscard]] std::string behind_at(const State& state) const;
  [[nodiscard]] const std::vector<BodySurface>& surfaces() const { return surfaces_; }
  [[nodiscard]] const std::vector<SurfaceContactElement>& elements() const { return elements_; }
  [[nodiscard]] double regularisation(const SurfaceContactElement& element) const;
  /// Friction of an element, in the frame of its body.
  [[nodiscard]] Friction friction_of(std::size_t element, const State& state) const;
  [[nodiscard]] double max_penetration_over_radius() const;
  /// Force and moment with which a body pulls at fibers by its surfaces; the state last followed.
  [[nodiscard]] std::pair<Vec3, Vec3> pull(const State& state, Index body) const;
  [[nodiscard]] const std::vector<SurfaceContactHistory>& history() const { return history_; }
  void set_history(std::vector<SurfaceContactHistory> history);

 private:
  /// Where the places of a fiber at a surface are.
  struct Places {
    double spacing = 0;
    Index n = 0;
    bool ends = false;  ///< the first and the last stand for half as much
  };
  [[nodiscard]] Places places(Index surface, Index fiber) const;
  [[nodiscard]] std::string behind(const std::vector<SurfaceContactElement>& elements) const;
  [[nodiscard]] std::vector<Index> near_places(const State& state, Index surface, Index fiber) const;
  [[nodiscard]] SurfaceContactElement make_element(Index surface, Index fiber, Index sample) const;
  void measure(const State& state, SurfaceContactElement& element) const;
  void take_up(SurfaceContactElement& element, const SurfaceContactHistory* known) const;
  [[nodiscard]] StickSlip make_stick_slip(SurfaceContactElement& element, const SurfaceContactHistory* known) const;
  /// The particle that friction follows, in the frame of the body.
  [[nodiscard]] Vec3 relative_position(const SurfaceContactElement& element, const State& state) const;
  [[nodiscard]] const SurfaceContactHistory* find_history(const SurfaceContactElement& element) const;
  [[nodiscard]] bool rubs(const SurfaceContactElement& element) const {
    return !stick_slip_.empty() && surfaces_[element.surface].friction_coefficient > 0;
  }
  [[nodiscard]] double slip_energy(const State& state) const;
  [[nodiscard]] double penalty_energy_at(const State& state) const;
  /// Books what became of the contacts of the last accepted state on the way to `state`, the one last followed. Returns
  /// the force of each of `elements` at the step's start.
  std::vector<double> book_changes(const State& state);

  const FiberField& field_;
  const RigidBodies& bodies_;
  std::vector<BodySurface> surfaces_;
  ContactLaw law_;
  std::vector<double> modulus_;
  State start_;                                      // of the step
  std::string got_behind_;                           // what has got behind a surface in the step
  bool preloads_are_due_ = true;                     // at the last equilibrium
  std::vector<SurfaceContactElement> elements_;      // by surface, fiber, place
  std::vector<const SurfaceContactHistory*> known_;  // of each element; in history_
  std::vector<StickSlip> stick_slip_;                // in the frames of the bodies; empty without friction
  std::vector<SurfaceContactHistory> history_;       // of the last accepted increment, in the order of elements_
  std::optional<double> slip_energy_n_;              // of the last accepted increment
  Ledger booked_;                                    // of accepted increments; stores nothing
};

}  // namespace trame::micro
