#pragma once
/// \file
/// Separation of interpenetrating yarns: at each crossing of a warp and a weft yarn all pairs of fibers obey
/// z_a − z_b ≥ d where their plan views cross, a in the upper yarn, whatever their depth, with vertical forces, while d
/// rises from −(height of the flat yarns) to R_a + R_b.

#include <optional>

#include "micro/contact/contact_element.h"
#include "micro/solve/effect.h"

namespace trame::micro {

/// A crossing of two yarns: fiber ranges of the upper and of the lower one.
struct YarnCrossing {
  Index upper_yarn = 0, lower_yarn = 0;
};

class CrossingOrder final : public Effect {
 public:
  struct Settings {
    double start_depth = 0;                      ///< < 0: d at stage time 0, over R_a + R_b; at stage time 1 it is 1
    double penalty = 0;                          ///< force per length of gap to start with
    double p_reg = 0;                            ///< penetration below which it is quadratic, length
    std::optional<double> target_penetration{};  ///< length to which each crossing adapts its penalty; may be none
  };
  CrossingOrder(const FiberField& field, std::vector<YarnCrossing> crossings, const Settings& settings)
      : field_(field), crossings_(std::move(crossings)), penalty_scale_(crossings_.size(), 1.0), settings_(settings) {}

  [[nodiscard]] std::string_view name() const override { return "crossing order"; }
  void begin_step(const State& start, double stage_time) override;
  void update(const State& state, bool keep = false) override;
  bool follow(const State& state, Follow what, const Region& region) override;
  void add_sparsity(Pattern::Builder& builder) const override;
  void add(const State& state, Assembler& assembler) const override;
  [[nodiscard]] double energy(const State& state) const override;
  [[nodiscard]] Ledger ledger(const State& state) const override;
  void commit(const State& state) override;
  void keep(Archive& archive) override;
  /// A pair of fibers at a crossing, a in the upper yarn.
  struct Element {
    Foot a, b;  ///< where their plan views cross at the state last followed
    std::array<Foot, 2> feet_at_iteration;
    double reach = 0;  ///< R_a + R_b
    double penalty = 0;
    double gap = 0;  ///< z_a − z_b − d at the state last followed
    CoveredNodes covered;

    /// What tells how it goes on from the gap that it has.
    void keep(Archive& archive) { archive(a, b, reach, penalty, gap); }
  };
  [[nodiscard]] const std::vector<Element>& elements() const { return elements_; }
  /// What ordinary contact takes over from the fibers that press on each other: on which side they lie, and their
  /// penalty.
  [[nodiscard]] std::vector<ContactHistory> history() const;

 private:
  /// Slides the feet to where the plan views cross. Returns whether they do; where they do not, the feet stay.
  bool follow(const State& state, Element& element) const;
  [[nodiscard]] double work(const std::vector<Element>& elements, const State& state) const;

  const FiberField& field_;
  std::vector<YarnCrossing> crossings_;
  std::vector<double> penalty_scale_;  // of each crossing
  Settings settings_;
  double depth_ = 0;                                // d / (R_a + R_b) of this step
  double work_n_ = 0;                               // on fibers, up to the last accepted step
  State start_;                                     // of the step
  std::optional<std::vector<Element>> elements_n_;  // of the last accepted step; before it, of the first search
  std::vector<Element> elements_;                   // crossing by crossing
  std::vector<std::size_t> element_start_;
};

/// Arc lengths at which the plan views (along z) of two fibers cross; false where they do not.
[[nodiscard]] bool plan_crossing(const FiberField& field, const State& state, Index a, Index b, double& s_a,
                                 double& s_b);

/// Smallest vertical distance z_upper − z_lower of the fiber pairs of a crossing, each where its plan views cross;
/// nothing where a pair does not cross.
[[nodiscard]] std::optional<double> smallest_separation(const FiberField& field, const State& state,
                                                        const YarnCrossing& crossing);

}  // namespace trame::micro
