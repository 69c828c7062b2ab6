#pragma once
/// \file
/// Saved states: one HDF5 file with the mesh, the scene and every saved increment, all in SI units.
/// Layout: micro/states/README.md.

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "micro/core/ledger.h"
#include "micro/fiber/fiber_mesh.h"

namespace trame::micro {

/// Contact elements of one increment, structure of arrays.
struct ContactRecord {
  std::vector<Index> fiber_a, fiber_b;
  std::vector<double> s_a, s_b;      ///< arc lengths of the particles, m
  std::vector<Vec3> position;        ///< midpoint, m
  std::vector<Vec3> normal;          ///< unit, from a to b: the direction of the normal force on b
  std::vector<double> gap;           ///< m, negative in penetration
  std::vector<double> normal_force;  ///< N, ≥ 0
  std::vector<Vec3> friction_force;  ///< N, on b
  std::vector<Vec3> slip;            ///< slip since the start of the increment, m
  std::vector<double> penalty;       ///< with which it goes on, N/m
  std::vector<double> length;        ///< of fiber that the element stands for, m
  // None of these in older files.
  std::vector<double> preload;  ///< penetration that the force of the multiplier is worth, with which it goes on, m
  std::vector<Index> point;     ///< 1: a point, 0: a sample of a line
  std::vector<Index> stuck;     ///< 1: it is not contact that holds these fibers in each other
  std::vector<Index> image_warp, image_weft;  ///< periods by which fiber b is displaced, where the weave is periodic
};

struct BodyRecord {
  std::vector<Vec3> position;  ///< m
  std::vector<Mat3> rotation;
  std::vector<Vec3> force;   ///< external force on the body (reaction or drive), N
  std::vector<Vec3> moment;  ///< N m
  // Sums over the increments since the run began, without what happens between stages. None of these in older files.
  std::vector<Vec3> motion;  ///< m
  std::vector<Vec3> turn;    ///< rotation vectors of the increments, rad
};

/// Of the sides of a woven patch, warp and weft; all 0 without a weave, and in older files.
struct SideRecord {
  /// Relative change of the distance of the side bodies since they began to hold the yarns' ends.
  std::array<double, 2> strain{};
  std::array<double, 2> force{};  ///< mean of the pulling forces on both sides, N
};

/// Energies since the start of the run, J. The external work is all that came in, by the sources of the ledger in
/// `work`; release is what fibers lost that a new stage found out of balance. Older files have neither.
struct EnergyRecord {
  double external_work = 0, stored = 0, friction = 0, damping = 0, imbalance = 0, release = 0;
  std::array<double, source_names.size()> work{};

  void keep(Archive& archive) {
    archive(external_work, stored, friction, damping, imbalance, release);
    for (double& w : work) archive(w);
  }
};

/// What the solver did for one increment.
struct SolverRecord {
  Index n_newton_iterations = 0, n_factorizations = 0, n_geometry_updates = 0, n_cuts = 0;
  double residual = 0;  ///< relative, at acceptance
  double max_penetration_over_radius = 0;
  double force_imbalance = 0, moment_imbalance = 0;  ///< relative
  double proximal = 0;  ///< η in natural units (largest axial modulus × mean radius of the types), 0: no damping
  EnergyRecord energy;
  double seconds = 0;
  /// 1: the equilibrium is known to be unstable, a disturbance would leave it; 0: not known to be. Looked at where the
  /// solver met an indefinite tangent in its last iterations, and at the end of each stage.
  Index unstable = 0;

  void keep(Archive& archive) {
    archive(n_newton_iterations, n_factorizations, n_geometry_updates, n_cuts, residual, max_penetration_over_radius,
            force_imbalance, moment_imbalance, proximal, energy, seconds, unstable);
  }
};

struct Increment {
  std::string stage;
  double stage_time = 0;  ///< 0…1 within its stage
  FiberConfiguration fibers;
  ContactRecord contacts;
  BodyRecord bodies;
  SideRecord sides;
  SolverRecord solver;
};

/// What does not change between increments.
struct SnapshotHeader {
  std::string version;  ///< of the program
  std::string scene_name;
  std::string scene_text;  ///< TOML
  FiberMesh mesh;
  std::vector<std::string> body_names;
};

/// Appends increments to a state file, and with each of them what a run needs to go on from there. Each increment is on
/// the disk before the file's `n_increments` counts it, and what is counted is never written to again, so that a crash
/// at any moment leaves every counted increment intact.
class SnapshotWriter {
 public:
  /// Creates the file. Throws InputError where it exists already or cannot be created, WriteError where there is no
  /// room for it; then it is not there.
  SnapshotWriter(const std::filesystem::path& file, const SnapshotHeader& header);
  ~SnapshotWriter();
  SnapshotWriter(const SnapshotWriter&) = delete;
  SnapshotWriter& operator=(const SnapshotWriter&) = delete;

  /// `continuation`: bytes that `SnapshotReader::continuation` gives back for the last increment; those of the last two
  /// are kept. Throws WriteError where the file cannot grow (a full disk, a limit) or is no longer there, and leaves it
  /// with what it counts; std::invalid_argument for arrays of wrong length.
  void append(const Increment& increment, const std::string& continuation = {});
  /// Gives the file, whole as it is, another name, in the place of one that has it. Throws WriteError.
  void rename(const std::filesystem::path& file);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Reads a state file, also while or after a run that was interrupted.
class SnapshotReader {
 public:
  /// Throws InputError for a file that is missing, truncated, foreign or of another layout version.
  explicit SnapshotReader(const std::filesystem::path& file);
  ~SnapshotReader();
  SnapshotReader(const SnapshotReader&) = delete;
  SnapshotReader& operator=(const SnapshotReader&) = delete;

  [[nodiscard]] const SnapshotHeader& header() const;
  [[nodiscard]] Index n_increments() const;
  /// Reads increment i, 0 ≤ i < n_increments(); increment 0 is the reference state. Throws InputError.
  [[nodiscard]] Increment read(Index i) const;
  /// What the last increment was appended with; nothing where there is none, or not whole.
  [[nodiscard]] std::optional<std::string> continuation() const;
  /// Only the node positions and section vectors of increment i.
  [[nodiscard]] FiberConfiguration read_fibers(Index i) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trame::micro
