#pragma once
/// \file
/// How the axis of a fiber answers stretch λ, and where that is no fiber's behaviour any more. Rods and beams are
/// linear between E_ss and the second Piola stress, which holds for small strain. Under strong compression that law
/// softens: its nominal stress E λ (λ² − 1)/2 is least at λ = 1/√3 and vanishes at 0. So below λ₀ = 0.8 the nominal
/// stress goes on from there, with the slope that it has there, as a logarithm, P = P₀ + k ln(λ/λ₀), which never
/// softens and lets no finite stress press a fiber to nothing. No law of a fiber's is known there: strains beyond λ₀
/// are warned of, and states with fibers pressed to less than a twentieth of their length, or turned inside out, are
/// refused.

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "micro/fiber/fiber_field.h"

namespace trame::micro {

/// λ₀, and the least λ that is accepted.
inline constexpr double least_linear_stretch = 0.8, least_stretch = 0.05;

/// λ of E_ss.
[[nodiscard]] inline double stretch_of(double strain) { return std::sqrt(std::max(0.0, 1 + 2 * strain)); }

/// Of a unit of E_L A, at one E_ss.
struct AxialLaw {
  double energy, stress, stiffness;  ///< W, S = ∂W/∂E_ss, ∂S/∂E_ss
};

[[nodiscard]] inline AxialLaw axial_law(double strain) {
  constexpr double l0 = least_linear_stretch, e0 = 0.5 * (l0 * l0 - 1), p0 = l0 * e0, k = 0.5 * l0 * (3 * l0 * l0 - 1);
  if (strain >= e0) return {0.5 * strain * strain, strain, 1};
  constexpr double nothing = 1e-6;
  const double l = std::max(stretch_of(strain), nothing), p = p0 + k * std::log(l / l0), stress = p / l;
  return {0.5 * e0 * e0 + p0 * (l - l0) + k * (l * std::log(l / l0) - l + l0), stress, (k / l - stress) / (l * l)};
}

/// What is said of a fiber that has collapsed at arc length s: pressed to a strain E_ss, or turned inside out.
[[nodiscard]] inline std::string collapse_text(const FiberField& field, Index fiber, double s, double strain,
                                               bool inside_out) {
  return fmt::format(
      "{} collapsed: {} (try less compression there, more support for the fiber or a larger proximal term)",
      field.describe(fiber, s),
      inside_out ? "it is turned inside out"
                 : fmt::format("its stretch is {:.3f}, and below {:g} it is no fiber any more", stretch_of(strain),
                               least_stretch));
}

/// The place where fibers are pressed most.
struct MostPressed {
  Index fiber = -1;
  double s = 0, strain = 0;

  void see(Index other_fiber, double other_s, double other_strain) {
    if (other_strain < strain) *this = {other_fiber, other_s, other_strain};
  }
  /// What is said of it; nothing where the law is known there.
  [[nodiscard]] std::string text(const FiberField& field) const {
    const double stretch = stretch_of(strain);
    if (stretch >= least_linear_stretch) return {};
    return fmt::format("{} is pressed to {:.2f} of its length, where its elastic law is a guess (below {:g})",
                       field.describe(fiber, s), stretch, least_linear_stretch);
  }
};

}  // namespace trame::micro
