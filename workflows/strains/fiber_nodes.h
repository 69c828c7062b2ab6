#pragma once
/// \file
/// States of fibers that no run of this program wrote: nodes of fibers from another code or from tomography.
/// Layouts: micro/states/README.md, "Fiber nodes from elsewhere".

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "meso/fiber_states.h"

namespace trame::workflows {

/// Opens what a command line names: the state file of a run, one HDF5 file with fiber nodes, or for each state one VTK
/// PolyData file (.vtp) or one table (.csv, .txt). Throws InputError that names the file, and the dataset or array in
/// it.
[[nodiscard]] std::unique_ptr<meso::FiberStates> open_states(const std::vector<std::filesystem::path>& files);

/// Which states are asked for.
using StateChoice = std::function<std::vector<Index>(const meso::FiberStates&)>;

/// Opens `files` in a child process and reads state 0 and those that `which` names, see `probe`; what is wrong with
/// them is for the reading itself to tell. Throws InputError where that would bring down the program.
void probe_states(const std::vector<std::filesystem::path>& files, const StateChoice& which);

/// No file may claim more nodes or fibers in one state: a guard against damaged sizes.
inline constexpr std::size_t max_file_nodes = 20'000'000;

/// Fibers in the order of a file.
struct FiberList {
  std::vector<Index> start;        ///< n_fibers + 1; fiber f owns nodes start[f] … start[f+1] − 1, at least 2
  std::vector<Index> yarn;         ///< n_fibers, index into yarns
  std::vector<double> radius;      ///< n_fibers, m; NaN where unknown
  std::vector<micro::Yarn> yarns;  ///< name and family; which fibers are theirs follows from `yarn`

  [[nodiscard]] std::size_t n_fibers() const { return yarn.size(); }
};

/// Throws InputError that begins with `where` unless `start` begins with 0 and gives each fiber at least 2 nodes.
void check_start(const std::string& where, const std::vector<Index>& start);
/// Throws InputError that begins with `where` unless all positions are finite.
void check_finite(const std::string& where, const std::vector<Vec3>& values);
/// Fails for positions, m, whose squares and products double precision would not hold.
void check_positions(const std::string& where, const std::vector<Vec3>& positions);

/// Fails unless `name` can be that of a yarn: plain text of bounded length.
void check_yarn_name(const std::string& where, const std::string& name);

/// Labels of the fibers of a file, text or integers, and the yarns that they make: "7" is the yarn "yarn/7", any other
/// text the yarn of that name. Yarns are in the order of their labels, numbers first.
void make_yarns(const std::vector<std::string>& label_of_fiber, FiberList& list);

/// Whether people call an array of labels of yarns `name`: yarn, Yarn_ID, tow, bundle …
[[nodiscard]] bool names_yarns(const std::string& name);
/// The same of fibers: fiber, Fibre ID, filament …
[[nodiscard]] bool names_fibers(const std::string& name);

/// How many metres a unit of length is. Throws InputError that begins with `where`.
[[nodiscard]] double metres(const std::string& where, const std::string& unit);

/// A remark on positions in metres that are none of a fabric, where no unit is given; empty for all others.
[[nodiscard]] std::string remark_on_size(const std::vector<Vec3>& positions, const std::string& how_to_give_a_unit);

/// Brings nodes from the order of a file into that of a fiber mesh, where the fibers of a yarn are consecutive and run
/// the same way.
class NodeOrder {
 public:
  /// Arc lengths are sums of distances between nodes at `reference` (file order, m). `where`: what a message begins
  /// with. Fibers that run against most others of their yarn there are turned. Throws InputError where two neighbours
  /// on a fiber coincide. The mesh's axial stiffness is unknown (NaN), and its fibers may have even numbers of nodes.
  NodeOrder(const std::string& where, const FiberList& list, const std::vector<Vec3>& reference);

  [[nodiscard]] const micro::FiberMesh& mesh() const { return mesh_; }
  /// Tells of fibers that were turned; empty where none was.
  [[nodiscard]] std::string remark() const;
  /// The configuration at `positions`, m, with dr/ds `tangents` (both in file order). Without tangents: derivatives of
  /// the parabola through three neighbouring nodes over the reference arc length (through two on a fiber of two).
  /// Sections are unit, normal to the tangent, horizontal and vertical.
  [[nodiscard]] micro::FiberConfiguration configuration(const std::vector<Vec3>& positions,
                                                        const std::vector<Vec3>& tangents = {}) const;

 private:
  micro::FiberMesh mesh_;
  std::vector<Index> source_;  ///< node of the file at each node of the mesh
  std::vector<char> turned_;   ///< n_fibers
};

/// Fiber nodes in one HDF5 file. Throws InputError.
[[nodiscard]] std::unique_ptr<meso::FiberStates> open_hdf5_nodes(const std::filesystem::path& file);
/// Whether an HDF5 file without the mark of a state file can be opened; what is in it is not looked at.
[[nodiscard]] bool may_hold_hdf5_nodes(const std::filesystem::path& file);

/// Fiber nodes as polylines, one file per state. Throws InputError.
[[nodiscard]] std::unique_ptr<meso::FiberStates> open_vtp_nodes(const std::vector<std::filesystem::path>& files);

/// Fiber nodes as tables, one file per state. Throws InputError.
[[nodiscard]] std::unique_ptr<meso::FiberStates> open_table_nodes(const std::vector<std::filesystem::path>& files);

}  // namespace trame::workflows
