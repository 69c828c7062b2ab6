#pragma once
/// \file
/// All there is to say of yarns between two states, computed once: meshes, strains, sections, bands, zones, validity as
/// a continuum. Tables, reports and studies read it and compute none of it again.

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "meso/bands/band_survey.h"
#include "meso/bands/shear_zones.h"
#include "meso/continuum/continuum.h"
#include "meso/fabric/fabric_facts.h"
#include "meso/fiber_states.h"
#include "meso/sections/section_pairs.h"
#include "meso/strain/nodal_strain.h"
#include "meso/strain/strain_summary.h"

namespace trame::meso {

/// States A and B of a strain: increments.
struct StatePair {
  Index from = 0, to = 0;
};

/// The pairs that tell the story of a run: from the reference to where its last stage begins, and from there to the
/// end. One pair where there is but one stage.
[[nodiscard]] std::vector<StatePair> pairs_of_run(const FiberStates& states);

/// Everything that can be chosen, with what all programs use.
struct ComparisonSettings {
  std::vector<std::string> yarns = {};                  ///< names with * and ? as wildcards; empty: all yarns
  std::vector<MeshKind> meshes = {MeshKind::delaunay};  ///< whose strains are wanted; the first speaks for the yarn
  MeshLimits limits = {};                               ///< of meshes of both kinds
  Index n_stations = default_stations;                  ///< sections in the middles of pieces of equal length in A; > 0
  std::size_t most_places = 7;  ///< sections where a yarn passes others and half-way between, the middle ones
  double pixels_per_distance = default_pixels_per_distance;  ///< of the cuts that bands are looked for on; ≥ 1
  /// Yarns whose bands and directions are wanted, which take most of the time; nothing: all of them.
  std::optional<std::vector<Index>> bands_of = std::nullopt;
  ShearBandOptions bands = {};
  ShearZoneOptions zones = {};
  ContinuumOptions continuum = {};
  int n_threads = 0;  ///< 0: all cores
};

/// Fields of one yarn between two states on one of its meshes. Empty where there is no mesh.
struct YarnFields {
  StrainField strain;          ///< of the tetrahedra
  NodalStrain nodal;           ///< of the vertices
  std::vector<double> D2_min;  ///< D²_min / d² of the vertices, see `non_affine_residual`
  ShearZones zones;            ///< of γ_max
};

/// One yarn on one of its meshes.
struct YarnOnMesh {
  MeshKind kind = MeshKind::delaunay;
  const YarnMesh& mesh;
  YarnFields fields;
  YarnStrain summary;
  std::vector<SectionBands> bands = {};  ///< at stations and places; empty where not wanted
  Orientation orientation = {};          ///< NaN there

  [[nodiscard]] bool has_mesh() const { return mesh.status == MeshStatus::ok; }
};

struct YarnComparison {
  Index yarn = 0;
  std::vector<SectionPair> sections;  ///< the stations, then the places
  SectionMeans means;
  std::vector<YarnOnMesh> meshes;  ///< as in the settings
  YarnContinuum continuum;
  bool has_bands = false;  ///< they were wanted

  [[nodiscard]] const YarnOnMesh& on_mesh() const { return meshes.front(); }
};

/// Two states and what is between them. The `YarnComparer` that made it must outlive it.
struct Comparison {
  StatePair pair;
  micro::Increment a, b;
  std::vector<YarnComparison> yarns;
  std::optional<FabricFacts> fabric = std::nullopt;  ///< of B, all of its yarns; nothing where `fabric_facts` has none
};

/// Strains of all yarns from A to B on one kind of mesh.
struct MeshStrains {
  MeshKind kind = MeshKind::delaunay;
  std::vector<YarnFields> fields;
  std::vector<YarnStrain> summaries;
};

/// A state A with the deformation gradients in it of the kinds of mesh that are wanted.
struct StateA {
  Index index = 0;
  micro::Increment increment;
  std::array<std::vector<std::vector<Mat3>>, n_mesh_kinds> F;  ///< by kind of mesh and yarn; none of other kinds
};

/// The part of a comparison that every state of a series gets.
struct StateStrains {
  std::shared_ptr<const StateA> a;
  Index to = 0;
  micro::Increment b;
  std::vector<std::vector<double>> D2_min;  ///< of each yarn's nodes
  std::vector<MeshStrains> meshes;          ///< as in the settings
};

/// Indices of the yarns that match any of `patterns` (all where there are none), in the order of `yarns`. Throws
/// InputError for a pattern that matches none.
[[nodiscard]] std::vector<Index> choose_yarns(const std::vector<micro::Yarn>& yarns,
                                              const std::vector<std::string>& patterns);

/// Meshes yarns once, both ways, and compares any states of them. Yarns run in parallel; results do not depend on the
/// number of threads.
class YarnComparer {
 public:
  /// `states` must outlive the object. Throws InputError for settings out of range, yarns that there are not, and a
  /// reference state that cannot be meshed.
  explicit YarnComparer(const FiberStates& states, ComparisonSettings settings = {});
  ~YarnComparer();
  YarnComparer(const YarnComparer&) = delete;
  YarnComparer& operator=(const YarnComparer&) = delete;

  [[nodiscard]] const FiberStates& states() const { return states_; }
  [[nodiscard]] const ComparisonSettings& settings() const { return settings_; }
  [[nodiscard]] const std::vector<Index>& yarns() const { return yarns_; }
  /// Of these yarns; also those without volume.
  [[nodiscard]] const std::vector<YarnMesh>& meshes(MeshKind kind) const;
  /// Tetrahedra of all yarns.
  [[nodiscard]] Index n_tets(MeshKind kind) const;

  /// The states are read one by one; none is kept here. All throw InputError for increments that the states do not
  /// have.
  [[nodiscard]] std::shared_ptr<const StateA> state_a(Index from) const;
  [[nodiscard]] StateStrains strains(const std::shared_ptr<const StateA>& a, Index to) const;
  /// Everything, with the strains that are there already.
  [[nodiscard]] Comparison complete(StateStrains strains) const;
  [[nodiscard]] Comparison compare(const StatePair& pair) const;

 private:
  struct Meshed;
  [[nodiscard]] YarnFields fields(std::size_t y, MeshKind kind, const StateStrains& strains) const;
  [[nodiscard]] YarnComparison compare_yarn(std::size_t y, const micro::FiberConfiguration& reference,
                                            StateStrains& strains) const;
  void add_bands(YarnComparison& yarn, const micro::FiberConfiguration& a) const;
  [[nodiscard]] YarnContinuum continuum(std::size_t y, const YarnComparison& yarn, const StateStrains& strains) const;

  const FiberStates& states_;
  ComparisonSettings settings_;
  std::vector<Index> yarns_;
  std::array<std::unique_ptr<Meshed>, n_mesh_kinds> meshed_;
};

}  // namespace trame::meso
