#pragma once
/// \file
/// Strains and forces of a woven patch, from its side bodies, or from the periods of a cell.

#include <array>
#include <vector>

#include "micro/model/model.h"

namespace trame::micro {

/// Distances between and forces on the side bodies of a weave, along warp and weft. All zero without a weave.
class SideGauge {
 public:
  explicit SideGauge(const Assembly& assembly);

  /// Strains count from the start of the first stage that drives the sides, and go on in all that follow; but where a
  /// stage moves the yarns' ends without the sides, they begin anew with the next one that drives them. A cell, which
  /// has no such ends, does that in stages with a proximal term: there it is woven.
  /// `last`: strains at the end of the stage before, from which they go on although leaders are placed anew.
  void begin_stage(const StageModel& model, const std::array<double, 2>& last);

  struct Reading {
    std::array<double, 2> strain{};
    std::array<double, 2> force{};  ///< mean of the pulls on both sides, natural units
  };
  [[nodiscard]] Reading read(const StageModel& model, const State& state) const;

  void keep(Archive& archive) { archive(reference_[0], reference_[1], strained_); }

 private:
  struct Sides {
    Index period;  // of a cell; negative: there are sides
    Index start, end;
    std::vector<Index> start_yarns, end_yarns;
  };
  [[nodiscard]] double distance(const StageModel& model, const State& state, int d) const;
  std::vector<Sides> sides_;
  std::array<double, 2> reference_{};
  bool present_ = false, strained_ = false;
};

}  // namespace trame::micro
