#pragma once
/// \file
/// The tables of a scene and their keys, in one place: what `parse_scene` reads is what `scene_schema` describes.
/// Names that a table may refer to are arguments; the schema passes none.

#include "micro/scene/keys.h"
#include "micro/scene/pattern.h"
#include "micro/scene/scene.h"

namespace trame::micro {

using Names = std::vector<std::string>;

enum class MaterialModel : std::uint8_t { isotropic, transversely_isotropic };
struct MaterialInput {
  MaterialModel model = MaterialModel::isotropic;
};
struct IsotropicInput {
  double young_modulus = 0, poisson_ratio = 0, density = 0;
};
struct FiberTypeInput {
  FiberType type;
  std::optional<double> diameter, linear_density;
};
enum class Lay : std::uint8_t { hexagonal, random };
enum class TwistDirection : std::uint8_t { s, z };
/// What [yarn.NAME] says, or a yarn system of one kind for itself.
struct YarnKindInput {
  std::optional<Index> type, n_fibers;
  std::optional<double> linear_density;
  Index n_layers = 0;
  double lattice_spacing = YarnKind{}.lattice_spacing;
  double twist = 0;
  std::optional<TwistDirection> twist_direction;
  Lay lay = Lay::hexagonal;
  std::optional<double> volume_fraction;
  Index seed = YarnKind{}.seed;
};
struct YarnSystemInput : YarnKindInput {
  std::optional<std::string> order;
  Index n_yarns = 0;
  std::optional<Index> n_elements;
  std::optional<double> yarn_spacing, sett, margin;
};
/// What [weave] says about the pattern; which keys belong together is checked where it is read.
struct WeaveInput {
  std::optional<std::string> pattern;
  std::optional<WeavePattern> matrix, picture;
  std::optional<std::string> pattern_file;
  std::optional<WarpLevels> levels;
  Index weft_layers = 1;
  std::vector<Index> repeat = {2, 2};
  Index harnesses = 5, step = 2;
  Index first_warp = 1, first_weft = 1;
  std::array<bool, 2> periodic{};  ///< warp, weft
  double angle = Weave{}.angle;
};
/// What [[body.surface]] says; which keys belong to which shape is checked where it is read.
struct SurfaceInput {
  SurfaceSpec surface;
  std::optional<Vec3> center, normal, axis, size;
  std::optional<double> radius, length;
  std::optional<std::string> file;  ///< of a mesh, or its triangles
  std::optional<double> unit;
  std::vector<std::vector<Vec3>> triangles;
};
/// A drive of several dofs of several bodies. The unit of a displacement or force depends on the dof.
struct DriveInput {
  Names bodies;
  std::vector<BodyDof> dofs;
  std::optional<Vec3> along, about;
  std::optional<SceneValue> displacement, force, amplitude;
  std::optional<double> strain, force_per_width;
  std::optional<std::string> follow;
};

/// A load on fibers, by one of two keys.
struct LoadInput {
  std::optional<std::string> name;
  Names fibers = {"*"};
  std::optional<Vec3> force_per_length, gravity;
  std::optional<SceneValue> amplitude;
};

[[nodiscard]] std::vector<Key<Scene>> scene_keys();
[[nodiscard]] std::vector<Key<MaterialInput>> material_keys();
[[nodiscard]] std::vector<Key<IsotropicInput>> isotropic_keys();
[[nodiscard]] std::vector<Key<Material>> transversely_isotropic_keys();
[[nodiscard]] std::vector<Key<FiberTypeInput>> fiber_type_keys(const NameTable& materials);
[[nodiscard]] std::vector<Key<FiberSpec>> fiber_keys(const NameTable& fiber_types);
[[nodiscard]] std::vector<Key<BundleSpec>> bundle_keys(const NameTable& fiber_types);
[[nodiscard]] std::vector<Key<WeaveInput>> weave_keys();
[[nodiscard]] std::vector<Key<YarnKindInput>> yarn_kind_keys(const NameTable& fiber_types);
[[nodiscard]] std::vector<Key<YarnSystemInput>> yarn_system_keys(const NameTable& fiber_types);
[[nodiscard]] std::vector<Key<BodySpec>> body_keys();
[[nodiscard]] std::vector<Key<Tie>> tie_keys(const NameTable& fibers_and_yarns);
[[nodiscard]] std::vector<Key<SurfaceInput>> surface_keys();
[[nodiscard]] std::vector<Key<Stage>> stage_keys();
[[nodiscard]] std::vector<Key<DriveInput>> drive_keys(const NameTable& bodies);
[[nodiscard]] std::vector<Key<LoadInput>> load_keys(const NameTable& fibers_and_yarns);
[[nodiscard]] std::vector<Key<Scene>> effect_keys();
[[nodiscard]] std::vector<Key<ContactSettings>> contact_keys();
[[nodiscard]] std::vector<Key<SolverSettings>> solver_keys();

/// The value of a drive is in these measures for translations and for rotations.
[[nodiscard]] inline bool is_rotation(BodyDof dof) { return dof >= BodyDof::rx; }
[[nodiscard]] inline const Measure& displacement_measure(BodyDof dof) { return is_rotation(dof) ? angle : length; }
[[nodiscard]] inline const Measure& force_measure(BodyDof dof) { return is_rotation(dof) ? moment : force; }

/// The density of a material, kg/m³. Fails at `value`, which asks for it, where the material states none.
[[nodiscard]] double known_density(const SceneValue& value, const Material& material);

}  // namespace trame::micro
