#include "micro/run/continuation.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <string_view>
#include <utility>
#include <vector>

#include "micro/core/error.h"
#include "micro/scene/scene_difference.h"

namespace trame::micro {

namespace {

/// What a run goes on with must have been written by the same program.
std::string program() {
  constexpr int format = 7;  // of what is kept; to be raised where that changes
  return fmt::format("Trame {}, format {}", TRAME_VERSION, format);
}

/// Passes through the stage under way.
void keep_stage(Archive& archive, StageState& at, StageModel& model, NewtonSolver& newton) {
  archive(at, newton);
  for (const auto& effect : model.effects) effect->keep(archive);
}

[[noreturn]] void fail_as_damaged(const Resumption& resumption, const ArchiveError& error) {
  throw InputError(fmt::format("--resume: {} is damaged: {}", resumption.states.string(), error.what()));
}

/// The tables of two scenes, as they stand at their top, in which these differ, but for names, titles and stages.
std::vector<std::string_view> differing_tables(const Scene& a, const Scene& b) {
  std::vector<std::string_view> tables;
  const auto compare = [&](bool same, std::initializer_list<std::string_view> of) {
    if (!same) tables.insert(tables.end(), of);
  };
  compare(a.materials == b.materials, {"material"});
  compare(a.fiber_types == b.fiber_types, {"fiber_type"});
  compare(a.fibers == b.fibers, {"fiber"});
  compare(a.bundles == b.bundles, {"bundle"});
  compare(a.weave == b.weave, {"weave", "yarn"});
  compare(a.bodies == b.bodies, {"body"});
  compare(a.twist_stretch == b.twist_stretch && a.contact.scope == b.contact.scope &&
              a.contact.self_contact == b.contact.self_contact && a.contact.friction == b.contact.friction,
          {"effects"});
  compare(a.contact == b.contact, {"contact"});
  compare(a.solver == b.solver, {"solver"});
  return tables;
}

/// Fails unless the scene that was run is the one at hand, but for stages that have not begun.
void require_same_scene(const SnapshotHeader& header, const Scene& scene, const Milestone& at) {
  const auto fail = [](const std::string& what) {
    throw InputError(
        fmt::format("--resume: the run is of another scene: {}; only stages that it has not begun may differ", what));
  };
  if (header.scene_text == scene.text) return;
  // As they were read, without the changes of a command line.
  const Scene theirs = parse_scene(header.scene_text, header.scene_name), ours = parse_scene(scene.text, scene.name);
  if (const auto tables = differing_tables(theirs, ours); !tables.empty()) {
    const std::string key = scene_difference(header.scene_text, scene.text, tables);
    fail(key.empty() ? fmt::format("not the same {}", fmt::join(tables, ", ")) : key);
  }
  for (std::size_t i = 0; i < at.stage + (at.within ? 1 : 0); ++i) {
    if (i >= theirs.stages.size()) throw ArchiveError("a stage that the scene has not");
    if (i >= ours.stages.size() || !(ours.stages[i] == theirs.stages[i]))
      fail(fmt::format("stage {} differs", theirs.stages[i].name));
  }
}

}  // namespace

std::string continuation(RunState& run, const std::string& changes) {
  Archive archive;
  Milestone at{.program = program(), .changes = changes, .stage = run.first_stage};
  archive(at, run);
  return archive.bytes();
}

std::string continuation(RunState& run, StageState& at, StageModel& model, NewtonSolver& newton,
                         const std::string& changes, const Stage& stage, std::size_t index) {
  Archive archive;
  const bool saves = at.position.time >= 1 || run.since_saved >= stage.save_every;
  Milestone milestone{.program = program(),
                      .changes = changes,
                      .stage = index,
                      .within = true,
                      .stage_time = at.position.time,
                      .since_saved = saves ? 0 : run.since_saved,
                      .n_increments = run.summary.n_increments};
  archive(milestone, run);
  keep_stage(archive, at, model, newton);
  return archive.bytes();
}

std::optional<Resumption> find_resumption(const std::filesystem::path& states, const Scene& scene,
                                          const std::string& changes) {
  if (!std::filesystem::exists(states)) return std::nullopt;
  const SnapshotReader reader(states);
  const auto fail = [&](const std::string& why) {
    throw InputError(fmt::format("--resume: {} {}", states.string(), why));
  };
  std::optional<std::string> bytes = reader.continuation();
  if (!bytes)
    fail(
        "does not hold what is needed to go on from its last state: it is of an earlier version, or damaged; a run can "
        "begin where one of its stages ended: --start-from and --after, with another --out");
  Resumption found{states, {}, Archive(std::move(*bytes)), reader.n_increments()};
  Milestone& at = found.at;
  try {
    found.kept(at);
    if (at.program != program())
      fail(fmt::format("was left by another program: {}; this is {}", at.program, program()));
    if (at.changes != changes)
      fail(fmt::format("is of a run with {}, not {}", at.changes.empty() ? "the scene as it is" : at.changes,
                       changes.empty() ? "the scene as it is" : changes));
    require_same_scene(reader.header(), scene, at);
  } catch (const ArchiveError& error) {
    fail(fmt::format("is damaged: {}", error.what()));
  }
  // A state that was saved because the run ended there is none that it would have saved by itself.
  if (at.since_saved > 0) --found.n_states;
  return found;
}

void take_up(Resumption& resumption, const Scene& scene, const Assembly& assembly, RunState& run) {
  const Milestone& at = resumption.at;
  try {
    resumption.kept(run);
    const FiberConfiguration& fibers = run.stage_start.configuration;
    const auto n_nodes = static_cast<std::size_t>(assembly.mesh.n_nodes());
    const std::size_t n_bodies = assembly.body_names.size(), n_stages = scene.stages.size();
    const bool fits = fibers.r.size() == n_nodes && fibers.g1.size() == n_nodes && fibers.g2.size() == n_nodes &&
                      fibers.tangent.size() == n_nodes && run.stage_start.poses.size() == n_bodies &&
                      run.stage_start.body_forces.size() == 6 * n_bodies && run.motion.size() == 6 * n_bodies;
    const bool loads_fit = std::all_of(
        run.stage_start.loads.begin(), run.stage_start.loads.end(),
        [&](const auto& load) { return load.force.size() == static_cast<std::size_t>(assembly.mesh.n_fibers()); });
    resumption.kept.require(fits && loads_fit, "fibers and bodies of another scene");
    resumption.kept.require(run.first_stage <= at.stage && at.stage < n_stages + (at.within ? 0 : 1) &&
                                at.stage_time >= 0 && at.stage_time <= 1 && at.since_saved >= 0 &&
                                (at.within || resumption.kept.at_end()),
                            "a place on the load path that there is not");
  } catch (const ArchiveError& error) {
    fail_as_damaged(resumption, error);
  }
  run.since_saved = at.since_saved;
}

StageState take_up_stage(const Resumption& resumption, StageModel& model, NewtonSolver& newton) {
  StageState at;
  Archive archive = resumption.kept;
  try {
    keep_stage(archive, at, model, newton);
    const auto fits = [&](const State& state) {
      return state.q.size() == model.start.q.size() && state.rotations.size() == model.start.rotations.size() &&
             std::all_of(state.q.begin(), state.q.end(), [](const Vec3& v) { return v.allFinite(); });
    };
    archive.require(archive.at_end() && fits(at.state) && fits(at.position.before) &&
                        at.body_forces.size() == model.drives.size() && at.position.time == resumption.at.stage_time &&
                        at.position.size > 0 && at.position.last_size > 0 && at.position.n_accepted > 0,
                    "a stage of another scene");
  } catch (const ArchiveError& error) {
    fail_as_damaged(resumption, error);
  }
  return at;
}

}  // namespace trame::micro
