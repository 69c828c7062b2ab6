#pragma once
/// \file
/// Newton's method for the equilibrium of a set of effects.

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "micro/solve/step_finder.h"

namespace trame::micro {

struct NewtonSettings {
  // A scene's; there are no others.
  double force_tolerance = 0;  ///< residual norm over that of the forces that fibers get from outside
  int max_iterations = 0;
  double step_cap = 0;  ///< largest change of any vector in one iteration, in its unit

  double force_floor = 1e-12;  ///< residual norm that counts as zero whatever the magnitudes, force
  LinearSettings linear{};
  /// Largest change of any vector before contact is looked for again, in its unit.
  double travel_cap = std::numeric_limits<double>::infinity();
  /// Damp what is soft instead of scaling whole steps down to the cap. For paths of equilibria: where fibers travel
  /// far, held back by a proximal term, single ones that are free to go run ahead into others.
  bool damps_soft_modes = true;
  std::vector<double> units{};  ///< of each vector: what counts as far
  /// Moments over these lengths count as forces, and forces times them as moments, where there are no others.
  double longest_arm = std::numeric_limits<double>::infinity(), shortest_arm = 0;
  /// Consecutive vectors that must be in equilibrium by themselves, as those of a fiber: what others are loaded with
  /// does not excuse a part of which next to nothing is asked.
  struct Part {
    Index begin = 0, end = 0;
    double negligible = 0;  ///< residual norm that is nothing for it, force
  };
  std::vector<Part> parts{};
  bool renews_limits = true;                          ///< of friction, with each of the first iterations
  std::function<bool()> stop = [] { return false; };  ///< asked before each iteration: whether to end without a result
};

struct NewtonOutcome {
  enum class Status : std::uint8_t {
    converged,
    travelled,
    held_up,
    too_many_iterations,
    not_a_number,
    not_positive_definite,
    stopped
  };
  Status status = Status::converged;
  int n_iterations = 0;
  int n_factorizations = 0;
  int n_linear_iterations = 0;  ///< of conjugate gradients
  double residual = 0;          ///< relative, at the end
  double remaining = 0;         ///< part of the prescribed motion still to be made, where it travelled
  double indefinite_at = std::numeric_limits<double>::infinity();  ///< least relative residual with such a tangent
  Index worst_dof = 0;                                             ///< where the residual is largest
  [[nodiscard]] bool converged() const { return status == Status::converged; }
};
[[nodiscard]] std::string_view describe(NewtonOutcome::Status status);

/// Residual of the free dofs, and what fibers get from outside: contact, friction, bodies, loads. (Axial forces would
/// hide all of it.) Forces, on positions, and moments, on all other vectors, each against their own: the moments at the
/// ends of a long fiber, which count in radii, would hide its forces.
struct Residual {
  struct Kind {
    double norm = 0, scale = 0;
    [[nodiscard]] double relative() const { return scale > 0 ? norm / scale : norm; }
  };
  Kind forces, moments;
  Index worst_dof = 0;
  double worst_part = 0;  ///< norm of a part over what it may be; 1 is just equilibrium
  [[nodiscard]] double norm() const { return std::hypot(forces.norm, moments.norm); }
  [[nodiscard]] double relative() const { return std::max(forces.relative(), moments.relative()); }
};

/// Keeps what is worth keeping between systems of the same layout: pattern, symbolic factorisation, workspaces.
class NewtonSolver {
 public:
  /// Of the fibers of a region; all other nodes must be prescribed, and stay where they are.
  NewtonSolver(const Layout& layout, NewtonSettings settings, int n_threads, Timers& timers, Region region = {});

  /// Makes the pattern cover the sparsity of the effects; a pattern that covers it already is kept. Returns true for a
  /// new one.
  bool cover_sparsity(const Effects& effects);

  /// What is far from all others, as effects see it at `state`, takes longer steps from now on.
  void set_reach(const Effects& effects, const State& state);
  /// All vectors take the usual steps.
  void reset_reach();
  /// Lets go of pattern and factor, so that what comes does not depend on how this point was reached: a run that goes
  /// on from a saved increment has neither.
  void forget();
  /// Passes through what is left then.
  void keep(Archive& archive) { finder_.keep(archive); }

  /// Finds the state in which the gradient of the effects' potential vanishes at all free dofs, starting from `state`,
  /// to `slack` times the tolerance of the settings, or stops at the travel cap. `log` (may be empty) gets a line per
  /// iteration.
  NewtonOutcome solve(Effects& effects, const PrescribedMotion& prescribed, double slack, State& state,
                      const std::function<void(const std::string&)>& log);

  /// Gradient of the potential at `state`; afterwards `force()` holds it.
  /// With `renewed`, limits of friction are those of the forces at `state`; otherwise those that were used last.
  Residual evaluate(Effects& effects, const PrescribedMotion& prescribed, const State& state, bool renewed);
  /// Gradient at the last evaluated state; at prescribed dofs it is the reaction, the force that holds them.
  [[nodiscard]] const std::vector<double>& force() const { return system_.force(); }

  /// Whether a residual is equilibrium, to `slack` times the tolerance, or to what round-off lets one tell.
  [[nodiscard]] bool is_equilibrium(const Residual& r, double slack) const {
    return excess(r, slack) <= 1 && r.worst_part <= slack;
  }

  /// Whether the equilibrium `state` is seen to be unstable. False says nothing.
  [[nodiscard]] bool seen_unstable(Effects& effects, const PrescribedMotion& prescribed, const State& state);

  [[nodiscard]] double n_matrix_entries() const { return static_cast<double>(system_.pattern().n_values()); }
  [[nodiscard]] double n_factor_entries() const { return finder_.linear().n_factor_entries(); }
  [[nodiscard]] double n_factor_flops() const { return finder_.linear().n_factor_flops(); }

 private:
  using Log = std::function<void(const std::string&)>;
  /// One solution under way.
  struct Solution {
    Effects& effects;
    const PrescribedMotion& prescribed;
    double slack;
    double remaining = 1;  // part of the prescribed motion still to be made
    int n_iterations = 0;
    std::unique_ptr<StepControl> control;
  };
  NewtonOutcome::Status iterate(Solution& at, State& state, NewtonOutcome& outcome, const Log& log);
  [[nodiscard]] bool make_step(Solution& at, const Residual& r, State& state, const Log& log);
  [[nodiscard]] StepProblem problem(const Solution& at, const State& state, double tolerance) const;
  /// Fibers by themselves.
  struct Restless {
    std::vector<NewtonSettings::Part> fibers{};
    Region region{};
    PrescribedMotion held{};
  };
  [[nodiscard]] std::optional<Restless> restless_fibers(const PrescribedMotion& prescribed) const;
  [[nodiscard]] bool settle_restless_fibers(Solution& at, double travel_left, State& state, const Log& log);
  [[nodiscard]] Residual residual(const PrescribedMotion& prescribed) const;
  /// Forces and moments that fibers, or those of a range of vectors, get and lack.
  [[nodiscard]] Residual between(const PrescribedMotion& prescribed, Index vector_begin, Index vector_end) const;
  /// A residual over what it may be.
  [[nodiscard]] double excess(const Residual& r, double slack) const;
  void follow(Effects& effects, const State& state, Effect::Follow what);
  [[nodiscard]] double line_search(Solution& at, const State& state, double alpha, double longest,
                                   double slope_at_zero);
  void try_step(const State& state, double alpha);
  [[nodiscard]] double slope(const PrescribedMotion& prescribed) const;

  const Layout& layout_;
  NewtonSettings settings_;
  int n_threads_;
  Region region_;
  Timers& timers_;
  TangentSystem system_;
  StepFinder finder_;
  bool renews_limits_ = false;   // of friction, with each iteration
  std::vector<double> unit_;     // of each vector: what counts as far
  State trial_;                  // where a step leads to
  std::vector<Vec3> last_step_;  // the step, as it was made
};

}  // namespace trame::micro
