#pragma once
/// \file
/// A scene: what is simulated, as checked structs in SI units. `read_scene` turns TOML into one.

#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "micro/contact/contact_law.h"
#include "micro/core/amplitude.h"
#include "micro/core/types.h"
#include "micro/fiber/fiber_model.h"
#include "micro/rigid/body_dof.h"
#include "micro/rigid/surface.h"
#include "micro/scene/test_curve.h"

namespace trame::micro {

struct FiberType {
  std::string name;
  Index material = 0;  ///< index into Scene::materials
  double radius = 0;   ///< R, m
  FiberModel model = FiberModel::enriched;

  bool operator==(const FiberType&) const = default;
};

/// A single fiber along points (cubic spline through them, a parabola for three, straight for two), free of stress in
/// that shape as an enriched beam; rods are straight at rest.
struct FiberSpec {
  std::string name;
  Index type = 0;            ///< index into Scene::fiber_types
  std::vector<Vec3> points;  ///< at least two, m
  Index n_elements = 0;
  std::optional<Vec3> section_axis;  ///< direction of g₁ at the start (made normal to the fiber); default: z

  bool operator==(const FiberSpec&) const = default;
};

/// A bundle: fibers packed on a hexagonal lattice around a line through points, turned `twist` times over its length.
struct BundleSpec {
  std::string name;
  Index type = 0;
  std::vector<Vec3> points;  ///< at least two, m
  Index n_elements = 0;      ///< per fiber
  Index n_fibers = 0;
  Index n_layers = 0;             ///< fibers stacked in z of the section; 0: as round as it gets
  double lattice_spacing = 1.05;  ///< centre distance in fiber diameters, ≥ 1
  double twist = 0;               ///< turns over the whole length; geometry is free of stress

  bool operator==(const BundleSpec&) const = default;
};

/// What a yarn is made of: parallel fibers, or with twist helices about its axis, free of stress.
struct YarnKind {
  std::string name = {};  ///< of [yarn.NAME]; empty for one that a system spells out
  Index type = 0;         ///< index into Scene::fiber_types
  Index n_fibers = 0;
  Index n_layers = 0;             ///< fibers stacked through the height; 0: as round as it gets
  double lattice_spacing = 1.05;  ///< centre distance of fibers in the flat yarn, in fiber diameters, ≥ 1
  double twist = 0;               ///< turns per length, positive for Z, negative for S, 1/m
  double volume_fraction = 0;     ///< of fibers laid at random in the yarn's outline; 0: laid on a hexagonal lattice
  Index seed = 1;                 ///< of the random lay

  bool operator==(const YarnKind&) const = default;
};

/// The warp or the weft yarns of a weave.
struct YarnSystem {
  std::vector<YarnKind> kinds;
  std::vector<Index> order = {0};  ///< of the kinds, yarn by yarn, repeated
  Index n_yarns = 0;
  Index n_elements = 0;     ///< per fiber
  double yarn_spacing = 0;  ///< distance between neighbouring yarns, across them (1/sett), m
  double margin = 0;        ///< yarn length beyond the outermost crossing yarn's axis, m
  bool periodic = false;    ///< yarns come back to where they start; margins are half a pitch of the crossing yarns
  Index n_layers = 1;       ///< of yarns above each other, upward yarn by yarn: n_layers of them share a column

  [[nodiscard]] Index n_columns() const { return n_yarns / n_layers; }
  [[nodiscard]] const YarnKind& kind_of(Index yarn) const {
    return kinds[order[static_cast<std::size_t>(yarn) % order.size()]];
  }
  [[nodiscard]] std::int64_t n_fibers() const {  ///< of all yarns
    std::int64_t n = 0;
    for (Index yarn = 0; yarn < n_yarns; ++yarn) n += kind_of(yarn).n_fibers;
    return n;
  }

  bool operator==(const YarnSystem&) const = default;
};

/// Warp yarns run along x, weft yarns at an angle to them, along y where nothing else is said, z is the thickness
/// direction; the patch is centred on the origin. Where a system is periodic, the patch is a cell that goes on along
/// its yarns with the next one (micro/periodic/README.md). `warp_above[i][j]` is true where warp yarn j passes above
/// weft yarn i.
struct Weave {
  std::vector<std::vector<bool>> warp_above;  ///< weft n_yarns × warp n_yarns
  YarnSystem warp, weft;
  double angle = std::numbers::pi / 2;  ///< from the warp to the weft, rad

  /// To the digit at a right angle.
  [[nodiscard]] Vec3 weft_direction() const {
    const double lean = std::numbers::pi / 2 - angle;
    return {std::sin(lean), std::cos(lean), 0};
  }
  [[nodiscard]] bool is_skew() const { return angle != Weave{}.angle; }
  /// Distance of neighbouring yarns of a system along the yarns that they cross.
  [[nodiscard]] double pitch(const YarnSystem& yarns) const { return yarns.yarn_spacing / weft_direction().y(); }
  /// Length of the yarns of a system that crosses another one.
  [[nodiscard]] double yarn_length(const YarnSystem& yarns, const YarnSystem& crossing) const {
    return (crossing.n_columns() - 1) * pitch(crossing) + 2 * yarns.margin;
  }
  [[nodiscard]] bool is_periodic() const { return warp.periodic || weft.periodic; }
  bool operator==(const Weave&) const = default;
};

/// How fiber ends follow a body: position and section of each; or, so that fibers may rearrange, section and position
/// along its own reference tangent of each and across it only the mean position of all; or, so that they may slide
/// past each other, section and position across its tangent of each and along it only the mean.
enum class TieKind : std::uint8_t { clamped, average, sliding };

struct Tie {
  std::string fibers;  ///< name of a fiber, bundle or yarn, with * and ? as wildcards
  FiberEnd end = FiberEnd::start;
  TieKind kind = TieKind::clamped;

  bool operator==(const Tie&) const = default;
};

/// A rigid surface that a body carries, which fibers touch from outside, or from inside.
struct SurfaceSpec {
  Surface surface;                             ///< from the position of the body, m
  std::optional<double> friction_coefficient;  ///< µ; default: that between fibers
  std::string from_stage;                      ///< the first stage with it; empty: from the start on
  bool touches = false;  ///< as that stage begins, the body is moved along the plane's normal until it touches a fiber

  bool operator==(const SurfaceSpec&) const = default;
};

/// A rigid body. A weave makes its own: "warp/1/start" … for yarn ends, "side/warp/start" … for patch sides; and
/// "cell/warp", "cell/weft" for periods, of which the positions are the period vectors.
struct BodySpec {
  std::string name;
  Vec3 position = Vec3::Zero();  ///< m
  std::vector<Tie> ties;
  std::vector<SurfaceSpec> surfaces = {};

  bool operator==(const BodySpec&) const = default;
};

/// What drives a dof of some bodies through a stage: a ramp, or a table of shares of it.
enum class DriveMode : std::uint8_t {
  displacement,  ///< value reached at the stage's end, counted from its start (m, or rad for rotations)
  force,         ///< force or moment reached at the end, from the reaction found at the start (N, N m)
  strain,        ///< displacement = value × the body's coordinate along the dof at the stage's start; of a period,
                 ///< along its yarns
  follow         ///< moves with the rigid motion of `leader` since the stage's start
};

struct Drive {
  std::string bodies;  ///< name with * and ? as wildcards
  BodyDof dof = BodyDof::x;
  DriveMode mode = DriveMode::displacement;
  double value = 0;
  std::string leader;        ///< for follow
  Amplitude amplitude = {};  ///< not for follow

  bool operator==(const Drive&) const = default;
};

/// What a load on fibers is given by.
enum class LoadKind : std::uint8_t {
  force_per_length,  ///< of the start configuration, N/m
  gravity            ///< an acceleration, m/s²: the force per length is density × section × this
};

/// Forces per length on fibers, which do not go with them. Through a stage they go from what a load of the same name
/// was before, or from nothing, to the value: a ramp, or by a table of shares of that way. What is on at a stage's end
/// stays on until a later stage has a load of the same name.
struct FiberLoad {
  std::string name;
  std::vector<std::string> fibers;  ///< names of fibers, bundles or yarns, with * and ? as wildcards
  LoadKind kind = LoadKind::force_per_length;
  Vec3 value = Vec3::Zero();
  Amplitude amplitude = {};

  bool operator==(const FiberLoad&) const = default;
};

/// A stretch of the load path. Body dofs that no drive names are held where they are.
struct Stage {
  std::string name;
  Index n_increments = 10;  ///< wanted; steps are cut where they fail
  std::vector<Drive> drives;
  std::vector<FiberLoad> loads;  ///< of different names
  bool separate_yarns = false;   ///< crossing order imposed with vertical normals (weaves only)
  bool friction = true;
  double proximal_start = 0;  ///< η at the start, in units of E A / L of a fiber, per node
  double proximal_end = 0;    ///< η at the end; falls geometrically; a zero end is zero on the last increment
  std::string sliding_ends;   ///< of bodies with this name, * and ? as wildcards: their ties are sliding
  std::optional<FiberModel> fiber_model;  ///< model of every fiber in this stage, instead of its type's
  Index save_every = 1;                   ///< increments between saved states; the last one is always saved

  bool operator==(const Stage&) const = default;
};

enum class ContactScope : std::uint8_t { all, between_yarns, none };

/// What a scene says of contact; the rest is as `ContactLaw` has it.
struct ContactSettings {
  ContactScope scope = ContactScope::all;
  bool self_contact = ProximitySearch{}.self_contact;
  bool friction = ContactLaw{}.friction;
  double friction_coefficient = ContactLaw{}.friction_coefficient;
  double reversible_slip = ContactLaw{}.reversible_slip;
  double spacing = ProximitySearch{}.spacing;
  double search_margin = ProximitySearch{}.search_margin;
  double target_penetration = ContactLaw{}.target_penetration;
  bool adapt_penalty = ContactLaw{}.adapt_penalty;
  double regularisation = ContactLaw{}.regularisation;
  double penalty = ContactLaw{}.penalty;

  bool operator==(const ContactSettings&) const = default;
};

struct SolverSettings {
  double force_tolerance = 1e-6;  ///< residual norm over that of the forces that fibers get from outside
  Index max_newton_iterations = 40;
  Index max_geometry_updates = 12;  ///< times that contacts found anew may undo an equilibrium, in an increment
  double geometry_tolerance = 1;    ///< of scenes for earlier versions, which had two: the smaller one counts
  double step_cap = 0.5;            ///< largest change of an unknown per Newton iteration: R (the thinnest), 1 or rad
  FactorPrecision factor_precision = FactorPrecision::automatic;
  Preconditioner preconditioner = Preconditioner::automatic;
  double min_increment = 1e-4;  ///< smallest fraction of a stage before the solver gives up

  bool operator==(const SolverSettings&) const = default;
};

struct Scene {
  std::string name;  ///< file name without ending
  std::string title;
  std::string text;  ///< the TOML as read, stored with the results
  std::vector<Material> materials;
  std::vector<FiberType> fiber_types;
  std::vector<FiberSpec> fibers;
  std::vector<BundleSpec> bundles;
  std::optional<Weave> weave;
  std::vector<BodySpec> bodies;
  std::vector<Stage> stages;
  std::optional<TestCurve> test_curve;      ///< of [test]
  bool stages_are_chosen = false;           ///< by the program, because the scene is a weave that names none
  bool twist_stretch = true;                ///< E_ss terms quadratic in ξ, of enriched beams
  std::vector<std::string> stated_effects;  ///< keys that [effects] has; the others hold for want of a word
  ContactSettings contact;
  SolverSettings solver;
};

/// Reads and checks a scene. Throws InputError that names file, key, value and what is allowed.
[[nodiscard]] Scene read_scene(const std::filesystem::path& file);

/// The same for TOML text; `origin` stands for the file name in messages. Files that the scene names are looked for in
/// `folder`; without one, none are read. The scene's text has what was read of them in place of their names.
[[nodiscard]] Scene parse_scene(const std::string& toml, const std::string& origin,
                                const std::filesystem::path& folder = {});

/// The fiber types that fibers of the scene are of, ascending.
[[nodiscard]] std::vector<Index> fiber_types_in_use(const Scene& scene);

/// Every key of a scene with unit, default, range and meaning, as text for a terminal.
[[nodiscard]] std::string scene_schema();

}  // namespace trame::micro
