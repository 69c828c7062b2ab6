#include <fmt/format.h>

#include "micro/scene/named_test.h"
#include "micro/scene/scene.h"
#include "micro/scene/tables.h"

namespace trame::micro {

namespace {

template <class T>
void describe(std::string& text, const std::string& title, const std::vector<Key<T>>& keys) {
  text += title + "\n";
  for (const Key<T>& key : keys)
    text += fmt::format("  {:<25} {}\n{:28}{} ({})\n", key.name, key.meaning, "", key.allowed,
                        key.required ? "required" : key.fallback);
  text += "\n";
}

}  // namespace

std::string scene_schema() {
  std::string text =
      "A scene is a TOML file. Lengths, forces and the like are texts with a unit of UDUNITS.\n"
      "[NAME] is a table, [[NAME]] one of a list of tables. A weave names its yarns warp/1 ... and weft/1 ..., and "
      "has\n"
      "the bodies warp/1/start, warp/1/end ..., side/warp/start, side/warp/end, side/weft/start and side/weft/end.\n"
      "Warp yarns run along x, weft yarns along y; the patch is centred on the origin. Body dofs that no drive names "
      "are held.\n\n";
  describe(text, "top of the file", scene_keys());
  describe(text, "[material.NAME]", material_keys());
  describe(text, "[material.NAME] with model = \"isotropic\"", isotropic_keys());
  describe(text, "[material.NAME] with model = \"transversely_isotropic\"", transversely_isotropic_keys());
  describe(text, "[fiber_type.NAME]", fiber_type_keys({}));
  describe(text, "[[fiber]]", fiber_keys({}));
  describe(text, "[[bundle]]", bundle_keys({}));
  describe(text, "[weave]", weave_keys());
  describe(text, "[weave.warp] and [weave.weft]", yarn_system_keys({}));
  describe(text, "[yarn.NAME]", yarn_kind_keys({}));
  describe(text, "[[body]]", body_keys());
  describe(text, "[[body.tie]]", tie_keys({}));
  describe(text, "[[body.surface]]", surface_keys());
  describe(text, "[[stage]]", stage_keys());
  describe(text, "[[stage.drive]]", drive_keys({}));
  describe(text, "[[stage.load]]", load_keys({}));
  describe(text, "[test]", named_test_keys({}));
  describe(text, "[effects]", effect_keys());
  describe(text, "[contact]", contact_keys());
  describe(text, "[solver]", solver_keys());
  return text;
}

}  // namespace trame::micro
