#pragma once
/// \file
/// Initially curved rods in space by shooting: an independent solution of what the fiber models discretise.
///
/// Simo–Reissner rod with the frame Λ = [d₁ d₂ d₃], d₁ along the undeformed tangent, r' = Λ Γ, Λ' = Λ skew(K), and the
/// balance n = P (a dead force at the end), m' = −r' × n, m(L) = M. Section law in the quadratic measures of the fibers
/// with g₁ = α₁ d₂, g₂ = α₂ d₃,
///   E_ss = ½(|Γ|² − 1), E_11 = ½(α₁² − 1), E_22 = ½(α₂² − 1), 2E_s1 = α₁Γ₂, 2E_s2 = α₂Γ₃, g₁'·g₂ = α₁α₂K₁,
///   κ₁ = r'·g₁' = α₁(Γ₃K₁ − Γ₁K₃), κ₂ = r'·g₂' = α₂(Γ₁K₂ − Γ₂K₁),
/// W = A/2 E:C:E + EI/2 Σ(κ − κ⁰)² + GJ/2 (α₁α₂K₁)², stationary in α₁, α₂ (their gradients left out: they are (R/L)²
/// smaller). With EA and GA → ∞ it is Kirchhoff's rod, in a plane Euler's elastica.
///
/// Where twist and stretch are coupled, with g₁' = α₁ K × d₂, g₂' = α₂ K × d₃ and the changes of
///   m₁ = |g₁'|² + |g₂'|² = α₁²(K₁² + K₃²) + α₂²(K₁² + K₂²), m₂ = |g₁'|² − |g₂'|², m₃ = 2 g₁'·g₂' = −2α₁α₂K₂K₃,
/// E_ss has (R²/8) m₁ on top, and W EA R⁴/192 (½m₁² + m₂² + m₃²). Without the coupling E_ss has that times 4νG/E.

#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "micro/core/types.h"
#include "micro/solve/system.h"

namespace trame::micro::test {

/// Stiffnesses of a section. Infinite EA and GA are allowed.
struct RodSection {
  double axial = 0, shear = 0, bending = 0, torsion = 0;  ///< EA, GA, EI, GJ
  double poisson_ratio = 0;
  bool stretches = true;  ///< false: α₁ = α₂ = 1, as in rods
  double radius = 0;      ///< R
  double mean_share = 0;  ///< of (R²/8) m₁ in E_ss: 1 with the coupling
  bool deviates = false;  ///< energy of the deviation from that mean, too
};

struct RodProblem {
  RodSection section;
  double length = 0;
  Vec3 position = Vec3::Zero();    ///< of the clamp
  Mat3 frame = Mat3::Identity();   ///< of the clamp
  Vec3 curvature = Vec3::Zero();   ///< K at rest, constant along the rod, in the frame, without twist
  Vec3 end_force = Vec3::Zero();   ///< P
  Vec3 end_moment = Vec3::Zero();  ///< M
  int n_steps = 200;               ///< of the fourth-order Runge–Kutta method
};

struct RodPoint {
  Vec3 r;
  Mat3 frame;
  Vec3 moment;
};

/// Strains Γ and K of forces n, m in the section's frame: fixed-point iteration of the section law.
inline void rod_strains(const RodProblem& p, const Vec3& n, const Vec3& moment, Vec3& gamma, Vec3& k) {
  const auto& [ea, ga, ei, gj, nu, stretches, radius, mean_share, deviates] = p.section;
  const double mean = mean_share * radius * radius / 8, deviation = deviates ? ea * std::pow(radius, 4) / 192 : 0;
  const Vec3& k0 = p.curvature;
  gamma = Vec3::UnitX();
  k = p.curvature;
  double a1 = 1, a2 = 1, n1 = 0,
         n2 = 0;                // stretches of the section and the forces that squeeze it, −α ∂W/∂α less A C E
  Vec3 by_mean = Vec3::Zero();  // moments of what m₁, m₂, m₃ cost
  for (int i = 0; i < 20; ++i) {
    const Vec3 m = moment - by_mean;
    const double b1 = -m[2] / (ei * a1 * gamma[0]), b2 = m[1] / (ei * a2 * gamma[0]);  // κ − κ⁰
    const double tension = (n[0] - ei * (a2 * b2 * k[1] - a1 * b1 * k[2])) / gamma[0];
    const double shear_1 = (n[1] - tension * gamma[1] + ei * a2 * b2 * k[0]) / (a1 * a1);  // GA Γ₂
    const double shear_2 = (n[2] - tension * gamma[2] - ei * a1 * b1 * k[0]) / (a2 * a2);
    gamma[1] = shear_1 / ga;
    gamma[2] = shear_2 / ga;
    const double g1 = a1 * a1 * (k[0] * k[0] + k[2] * k[2]), g2 = a2 * a2 * (k[0] * k[0] + k[1] * k[1]),
                 g1_0 = k0[2] * k0[2], g2_0 = k0[1] * k0[1];  // |g'|²; no twist at rest
    gamma[0] = std::sqrt(1 + 2 * (tension - nu * (n1 + n2)) / ea - 2 * mean * (g1 + g2 - g1_0 - g2_0) -
                         gamma[1] * gamma[1] - gamma[2] * gamma[2]);
    // ∂W/∂m₁, ∂W/∂m₂, ∂W/∂m₃
    const double p1 = tension * mean + deviation * (g1 + g2 - g1_0 - g2_0),
                 p2 = 2 * deviation * (g1 - g2 - g1_0 + g2_0),
                 p3 = 2 * deviation * (-2 * a1 * a2 * k[1] * k[2] + 2 * k0[1] * k0[2]);
    k[0] = (m[0] - ei * (a1 * b1 * gamma[2] - a2 * b2 * gamma[1])) / (gj * a1 * a1 * a2 * a2);
    const double c1 = (b1 - p.curvature[2]) / a1, c2 = (b2 + p.curvature[1]) / a2;  // κ / α
    k[1] = (c2 + gamma[1] * k[0]) / gamma[0];
    k[2] = (gamma[2] * k[0] - c1) / gamma[0];
    by_mean = {2 * ((p1 + p2) * a1 * a1 + (p1 - p2) * a2 * a2) * k[0],
               2 * (p1 - p2) * a2 * a2 * k[1] - 2 * p3 * a1 * a2 * k[2],
               2 * (p1 + p2) * a1 * a1 * k[2] - 2 * p3 * a1 * a2 * k[1]};
    if (!stretches) continue;
    n1 = -(ei * b1 * c1 / a1 + shear_1 * gamma[1] + gj * a2 * a2 * k[0] * k[0] +
           2 * (p1 + p2) * (k[0] * k[0] + k[2] * k[2]) - 2 * p3 * a2 / a1 * k[1] * k[2]);
    n2 = -(ei * b2 * c2 / a2 + shear_2 * gamma[2] + gj * a1 * a1 * k[0] * k[0] +
           2 * (p1 - p2) * (k[0] * k[0] + k[1] * k[1]) - 2 * p3 * a1 / a2 * k[1] * k[2]);
    a1 = std::sqrt(1 + 2 * (n1 - nu * (n2 + tension)) / ea);
    a2 = std::sqrt(1 + 2 * (n2 - nu * (n1 + tension)) / ea);
  }
}

inline RodPoint rod_derivative(const RodProblem& p, const RodPoint& at) {
  Vec3 gamma, k;
  rod_strains(p, at.frame.transpose() * p.end_force, at.frame.transpose() * at.moment, gamma, k);
  const Vec3 tangent = at.frame * gamma;
  return {tangent, at.frame * skew(k), -tangent.cross(p.end_force)};
}

/// The end of the rod that starts with the moment `clamp_moment`. `visit` (may be empty) sees every step.
inline RodPoint integrate_rod(const RodProblem& p, const Vec3& clamp_moment,
                              const std::function<void(double, const RodPoint&)>& visit = {}) {
  const double h = p.length / p.n_steps;
  RodPoint at{p.position, p.frame, clamp_moment};
  const auto moved = [&](const RodPoint& rate, double by) {
    return RodPoint{at.r + by * rate.r, at.frame + by * rate.frame, at.moment + by * rate.moment};
  };
  for (int i = 0; i < p.n_steps; ++i) {
    if (visit) visit(i * h, at);
    const RodPoint a = rod_derivative(p, at), b = rod_derivative(p, moved(a, h / 2)),
                   c = rod_derivative(p, moved(b, h / 2)), d = rod_derivative(p, moved(c, h));
    const double w = h / 6;
    at = {at.r + w * (a.r + 2 * b.r + 2 * c.r + d.r), at.frame + w * (a.frame + 2 * b.frame + 2 * c.frame + d.frame),
          at.moment + w * (a.moment + 2 * b.moment + 2 * c.moment + d.moment)};
  }
  if (visit) visit(p.length, at);
  return at;
}

/// Finds the clamp moment for which the end moment is right, loads growing in `n_load_steps`; returns the rod's end.
/// Throws std::runtime_error where Newton's method fails.
inline RodPoint shoot_rod(RodProblem problem, int n_load_steps = 10,
                          const std::function<void(double, const RodPoint&)>& visit = {}) {
  const Vec3 force = problem.end_force, moment = problem.end_moment;
  const double scale = force.norm() * problem.length + moment.norm();
  Vec3 clamp = Vec3::Zero();
  for (int step = 1; step <= n_load_steps; ++step) {
    problem.end_force = force * step / n_load_steps;
    problem.end_moment = moment * step / n_load_steps;
    const auto mismatch = [&](const Vec3& m) -> Vec3 { return integrate_rod(problem, m).moment - problem.end_moment; };
    bool converged = false;
    for (int iteration = 0; iteration < 30 && !converged; ++iteration) {
      const Vec3 error = mismatch(clamp);
      converged = error.norm() < 1e-11 * scale;
      if (converged) break;
      Mat3 jacobian;
      const double h = 1e-6 * scale;
      for (int c = 0; c < 3; ++c)
        jacobian.col(c) = (mismatch(clamp + h * Vec3::Unit(c)) - mismatch(clamp - h * Vec3::Unit(c))) / (2 * h);
      clamp -= jacobian.partialPivLu().solve(error);
    }
    if (!converged) throw std::runtime_error("shooting does not converge");
  }
  return integrate_rod(problem, clamp, visit);
}

/// Section of a circular enriched fiber of isotropic material, G·2I as torsional stiffness.
inline RodSection circular_section(double young_modulus, double poisson_ratio, double radius,
                                   bool twist_stretch = true) {
  const double area = std::numbers::pi * radius * radius, inertia = area * radius * radius / 4;
  const double shear_modulus = young_modulus / (2 * (1 + poisson_ratio));
  return {young_modulus * area,
          shear_modulus * area,
          young_modulus * inertia,
          2 * shear_modulus * inertia,
          poisson_ratio,
          true,
          radius,
          twist_stretch ? 1 : 2 * poisson_ratio / (1 + poisson_ratio),
          twist_stretch};
}

/// The same of a rod, which neither shears nor squeezes nor knows of twist.
inline RodSection rod_section(double young_modulus, double radius) {
  RodSection section = circular_section(young_modulus, 0, radius);
  section.shear = std::numeric_limits<double>::infinity();
  section.stretches = section.deviates = false;
  section.mean_share = 0;
  return section;
}

}  // namespace trame::micro::test
