#pragma once
/// \file
/// When a fiber has collapsed under compression. The laws of beams and rods are linear between E_ss and its second
/// Piola stress, so that a fiber of stretch λ carries the nominal stress E λ (λ² − 1)/2: in compression at most 0.19245
/// E, at λ = 1/√3. Beyond, it softens down to λ = 0 and hardens again on a branch on which it is turned inside out;
/// neither is a fiber's behaviour.

#include <fmt/format.h>

#include <string>

#include "micro/fiber/fiber_field.h"

namespace trame::micro {

/// E_ss at λ = 1/√3.
inline constexpr double softening_strain = -1.0 / 3;

/// What is said of a fiber that has collapsed at arc length s: softened to a strain E_ss, or turned inside out.
[[nodiscard]] inline std::string collapse_text(const FiberField& field, Index fiber, double s, double strain,
                                               bool inside_out) {
  return fmt::format(
      "{} collapsed: {} (try less compression there, more support for the fiber or a larger proximal term)",
      field.describe(fiber, s),
      inside_out ? "it is turned inside out"
                 : fmt::format("its stretch is {:.3f}, and below 0.577 its elastic law softens",
                               std::sqrt(std::max(0.0, 1 + 2 * strain))));
}

}  // namespace trame::micro
