#include "micro/simulate.h"

#include <fmt/format.h>
#include <omp.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "micro/contact/fiber_ends.h"
#include "micro/core/archive.h"
#include "micro/core/error.h"
#include "micro/core/wildcard.h"
#include "micro/core/whole_file.h"
#include "micro/model.h"
#include "micro/record.h"
#include "micro/restart.h"

namespace trame::micro {

namespace {

using Status = SimulationSummary::Status;

/// Distances between and forces on the side bodies of a weave.
class SideGauge {
 public:
  explicit SideGauge(const Assembly& assembly) {
    const auto& names = assembly.body_names;
    for (const std::string family : {"warp", "weft"}) {
      const auto find = [&](const std::string& name) {
        return static_cast<Index>(std::find(names.begin(), names.end(), name) - names.begin());
      };
      sides_.push_back({find("side/" + family + "/start"), find("side/" + family + "/end"), {}, {}});
      for (std::size_t b = 0; b < names.size(); ++b)
        if (names[b].starts_with(family + "/"))
          (names[b].ends_with("/start") ? sides_.back().start_yarns : sides_.back().end_yarns)
              .push_back(static_cast<Index>(b));
    }
    present_ = !assembly.crossings.empty();
  }

  /// Strains count from the start of the first stage that drives the sides after one that does not.
  void begin_stage(const StageModel& model) {
    bool driven = false;
    for (int d = 0; d < 2 && present_; ++d)
      for (const Index b : {sides_[d].start, sides_[d].end})
        driven = driven || model.drives[6 * b + d].kind != DofDrive::Kind::held;
    if (present_ && !(driven && driven_))
      for (int d = 0; d < 2; ++d) reference_[d] = distance(model, model.start, d);
    driven_ = driven;
  }

  void keep(Archive& archive) { archive(reference_[0], reference_[1], driven_); }

  [[nodiscard]] CurvePoint read(const StageModel& model, const State& state, const Scales& scales) const {
    CurvePoint point;
    for (int d = 0; d < 2 && present_; ++d) {
      point.side_strain[d] = distance(model, state, d) / reference_[d] - 1;
      double pull = 0;
      for (const Index b : sides_[d].end_yarns) pull += model.ties->pull(state, b).first[d];
      for (const Index b : sides_[d].start_yarns) pull -= model.ties->pull(state, b).first[d];
      point.side_force[d] = 0.5 * pull * scales.force();
    }
    return point;
  }

 private:
  struct Sides {
    Index start, end;
    std::vector<Index> start_yarns, end_yarns;
  };
  [[nodiscard]] double distance(const StageModel& model, const State& state, int d) const {
    return model.bodies.pose(state, sides_[d].end).position[d] - model.bodies.pose(state, sides_[d].start).position[d];
  }
  std::vector<Sides> sides_;
  std::array<double, 2> reference_{};
  bool present_ = false, driven_ = false;
};

/// A body without ties that leads others stands at the middle of its followers when a stage begins.
void place_leaders(const Assembly& assembly, const Stage& stage, std::vector<Pose>& poses) {
  for (Index leader = 0; leader < static_cast<Index>(poses.size()); ++leader) {
    if (std::any_of(assembly.ties.begin(), assembly.ties.end(), [&](const EndTie& t) { return t.body == leader; }))
      continue;
    Vec3 sum = Vec3::Zero();
    int n = 0;
    for (const Drive& d : stage.drives)
      for (std::size_t b = 0; b < poses.size() && d.mode == DriveMode::follow; ++b)
        if (d.leader == assembly.body_names[leader] && matches(d.bodies, assembly.body_names[b])) {
          sum += poses[b].position;
          ++n;
        }
    if (n > 0) poses[leader].position = sum / n;
  }
}

void add_history(std::vector<ContactHistory>& history, const std::vector<ContactHistory>& more) {
  history.insert(history.end(), more.begin(), more.end());
  std::sort(history.begin(), history.end(), [](const ContactHistory& a, const ContactHistory& b) {
    return std::tie(a.fiber_a, a.fiber_b, a.s_a) < std::tie(b.fiber_a, b.fiber_b, b.s_a);
  });
}

void count_crossings(const StageModel& model, const State& state, const Assembly& assembly,
                     SimulationSummary& summary) {
  summary.n_crossings = static_cast<Index>(assembly.crossings.size());
  summary.n_crossings_ok = 0;
  for (const YarnCrossing& c : ordered_crossings(assembly))
    summary.n_crossings_ok += smallest_separation(model.field, state, c).value_or(-1) > 0;
  summary.crossing_order_ok = summary.n_crossings_ok == summary.n_crossings;
}

/// Fiber ends that lie inside other fibers, but for those that a body holds together with them.
std::vector<BuriedEnd> free_buried_ends(const StageModel& model, const State& state, const Assembly& assembly) {
  const auto tied = [&](Index fiber, std::optional<FiberEnd> end, Index body) {
    return std::any_of(assembly.ties.begin(), assembly.ties.end(),
                       [&](const EndTie& t) { return t.fiber == fiber && t.body == body && (!end || t.end == *end); });
  };
  return find_buried_ends(model.field, state, [&](Index fiber, FiberEnd end, Index other) {
    return std::any_of(assembly.ties.begin(), assembly.ties.end(),
                       [&](const EndTie& t) { return t.fiber == other && tied(fiber, end, t.body); });
  });
}

/// The first few of them by name.
std::string names_of(const std::vector<BuriedEnd>& ends, const FiberField& field) {
  constexpr std::size_t n_named = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(ends.size(), n_named); ++i)
    text +=
        fmt::format("{}the {} of fiber {} in {}", i > 0 ? ", " : "", ends[i].end == FiberEnd::start ? "start" : "end",
                    ends[i].fiber, field.describe(ends[i].inside, ends[i].s));
  return text + (ends.size() > n_named ? fmt::format(", and {} more", ends.size() - n_named) : "");
}

/// What counts as far for each unknown vector: a radius for positions; where there is contact, a turn of a rod's tangent
/// that moves the middle of an element by a radius; 1 for all others.
std::vector<double> units_of_motion(const StageModel& model, double smallest_radius) {
  std::vector<double> units(model.layout.n_vectors(), 1.0);
  for (Index j = 0; j < model.layout.n_nodes(); ++j) units[model.layout.first_vector(j)] = smallest_radius;
  if (!model.contact) return units;
  const FiberMesh& mesh = model.field.mesh();
  for (Index f = 0; f < mesh.n_fibers(); ++f) {
    if (model.field.model(f) != FiberModel::rod) continue;
    // Cubic Hermite functions of unit slopes at both ends reach a quarter of the element's length.
    const double turn = std::min(1.0, 4 * smallest_radius / model.field.element_length(f));
    for (Index n = model.field.element_node(f, 0); n <= model.field.last_node(f); ++n)
      units[model.layout.first_vector(n) + 1] = turn;
  }
  return units;
}

State halfway(const State& from, const State& to) {
  State middle = from;
  for (std::size_t v = 0; v < from.q.size(); ++v) middle.q[v] = 0.5 * (from.q[v] + to.q[v]);
  for (std::size_t i = 0; i < from.rotations.size(); ++i)
    middle.rotations[i] =
        Eigen::Quaterniond(from.rotations[i]).slerp(0.5, Eigen::Quaterniond(to.rotations[i])).toRotationMatrix();
  return middle;
}

/// Tolerances of increments that end on the way, held back by a proximal term, over those of equilibria.
constexpr double slack_on_the_way = 1e3;

/// A stage in progress: what passes from increment to increment beside what effects and solver keep.
struct StageProgress {
  StagePosition position;
  State state;
  std::vector<double> body_forces;  // at `state`

  void keep(Archive& archive) { archive(position, state, body_forces); }
};

/// A run in progress: what passes from increment to increment and from stage to stage.
class Run {
 public:
  /// Writes nothing before `follow_load_path`.
  Run(const Scene& scene, const SimulateOptions& options)
      : options_(options), scales_(natural_scales(scene)), scene_(nondimensional(scene, scales_)),
        assembly_(assemble_scene(scene_)), gauge_(assembly_) {
    summary_.size = model_size(scene);
    summary_.n_threads = options.n_threads > 0 ? options.n_threads : omp_get_max_threads();
    omp_set_num_threads(summary_.n_threads);
    header_ = {TRAME_VERSION, scene.name, scene.text, dimensional(assembly_.mesh, scales_), assembly_.body_names};
    if (options.resume) resumption_ = find_resumption(options.states, scene, options.changes);
    if (resumption_) {
      take_up(*resumption_);
    } else if (options.start_from.empty()) {
      carried_ = start_of(assembly_);
    } else {
      restart_ = restart_after(options.after, SnapshotReader(options.start_from), scene_, assembly_, scales_);
      carried_ = restart_->carried;
      first_stage_ = restart_->next_stage;
    }
  }
  ~Run() {
    // States that no increment was added to.
    std::error_code ignored;
    if (writer_ && !states_are_in_place_) std::filesystem::remove(part_of(options_.states), ignored);
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  [[nodiscard]] StartPoint start() const {
    if (!resumption_) return {first_stage_, 0, 0};
    const Milestone& at = resumption_->at;
    const bool is_over = at.within && at.stage_time >= 1;
    return {at.stage + (is_over ? 1 : 0), is_over || !at.within ? 0 : at.stage_time, at.n_increments};
  }

  /// Builds the stage that is gone on with, and reads all that is kept of it.
  void check_resumption() {
    if (!resumption_ || !resumption_->at.within) return;
    StageModel model(scene_, assembly_, scene_.stages[resumption_->at.stage], carried_);
    NewtonSolver newton(model.layout, {}, 1, summary_.timers);
    (void)stage_progress(model, newton);
  }

  SimulationSummary follow_load_path() {
    begin_states();
    const std::size_t first = resumption_ ? resumption_->at.stage : first_stage_;
    for (std::size_t i = first; i < scene_.stages.size() && summary_.status == Status::done; ++i) {
      run_as_far_as_it_goes(i);
      if (stop_requested() && i + 1 < scene_.stages.size() && summary_.status == Status::done)
        summary_.status = Status::interrupted;
    }
    if (summary_.n_unstable_increments > 0)
      warn(fmt::format(
          "{} of {} increments ended in an equilibrium that is known to be unstable, the first one {}: a small "
          "disturbance, say a slight bow, would lead elsewhere",
          summary_.n_unstable_increments, summary_.n_increments, first_unstable_));
    return std::move(summary_);
  }

 private:
  void save_start() {
    Increment start;
    start.stage = "start";
    start.fibers = dimensional(carried_.configuration, scales_);
    for (const Pose& p : carried_.poses) {
      start.bodies.position.push_back(p.position * scales_.length);
      start.bodies.rotation.push_back(p.rotation);
      start.bodies.force.emplace_back(Vec3::Zero());
      start.bodies.moment.emplace_back(Vec3::Zero());
    }
    append(start);
  }

  /// Strains between the flat start and any later state shall be had from this run's states alone.
  void save_start(const Restart& restart) {
    writer_->append(restart.reference);
    books_ = natural(restart.state.solver.energy, scales_);
    remember();
    append(restart.state);
  }

  /// The states of this run, under another name until the first one is in them that was not saved before.
  void begin_states() {
    if (!options_.resume && std::filesystem::exists(options_.states))
      throw InputError(options_.states.string() + ": exists already; remove it or choose another name");
    std::error_code ignored;
    std::filesystem::remove(part_of(options_.states), ignored);
    writer_ = std::make_unique<SnapshotWriter>(part_of(options_.states), header_);
    if (resumption_) {
      const SnapshotReader before(options_.states);
      for (Index i = 0; i < resumption_->n_states; ++i) writer_->append(before.read(i));
    } else if (restart_) {
      save_start(*restart_);
    } else {
      remember();
      save_start();
    }
  }

  void append(const Increment& increment) {
    writer_->append(increment, continuation_);
    if (!states_are_in_place_) writer_->rename(options_.states);
    states_are_in_place_ = true;
  }

  /// What is saved with the next state, to go on from there: before the first stage that there is to run.
  void remember() {
    Archive archive;
    Milestone at{program_of_milestones(), options_.changes, first_stage_, false, 0, 0, 0};
    archive(at);
    keep(archive);
    continuation_ = archive.bytes();
  }
  /// The same within a stage.
  void remember(const StageModel& model, NewtonSolver& newton, StageProgress& progress, std::size_t stage) {
    Archive archive;
    const bool saves = progress.position.time >= 1 || since_saved_ >= scene_.stages[stage].save_every;
    Milestone at{program_of_milestones(), options_.changes, stage, true, progress.position.time, saves ? 0 : since_saved_,
                 summary_.n_increments};
    archive(at);
    keep(archive);
    keep(archive, model, newton, progress);
    continuation_ = archive.bytes();
  }

  /// Passes through what the run carries beside the stage under way.
  void keep(Archive& archive) {
    std::uint64_t first_stage = first_stage_;
    archive(first_stage, books_, books_before_, gauge_, carried_, summary_, first_unstable_, last_point_, last_solver_);
    first_stage_ = first_stage;
  }
  /// Passes through the stage under way.
  static void keep(Archive& archive, const StageModel& model, NewtonSolver& newton, StageProgress& progress) {
    archive(progress, newton);
    for (const auto& effect : model.effects) effect->keep(archive);
  }

  void take_up(Resumption& resumption) {
    const Milestone& at = resumption.at;
    try {
      keep(resumption.kept);
      const FiberConfiguration& fibers = carried_.configuration;
      const auto n_nodes = static_cast<std::size_t>(assembly_.mesh.n_nodes());
      const std::size_t n_bodies = assembly_.body_names.size(), n_stages = scene_.stages.size();
      const bool fits = fibers.r.size() == n_nodes && fibers.g1.size() == n_nodes && fibers.g2.size() == n_nodes &&
                        fibers.tangent.size() == n_nodes && carried_.poses.size() == n_bodies &&
                        carried_.body_forces.size() == 6 * n_bodies;
      resumption.kept.require(fits, "fibers and bodies of another scene");
      resumption.kept.require(first_stage_ <= at.stage && at.stage < n_stages + (at.within ? 0 : 1) &&
                                  at.stage_time >= 0 && at.stage_time <= 1 && at.since_saved >= 0 &&
                                  (at.within || resumption.kept.at_end()),
                              "a place on the load path that there is not");
    } catch (const ArchiveError& error) {
      fail_to_resume(error);
    }
    since_saved_ = at.since_saved;
  }
  /// The stage that is gone on with, and with it what effects and solver keep.
  StageProgress stage_progress(const StageModel& model, NewtonSolver& newton) {
    StageProgress progress;
    Archive archive = resumption_->kept;
    try {
      keep(archive, model, newton, progress);
      const auto fits = [&](const State& state) {
        return state.q.size() == model.start.q.size() && state.rotations.size() == model.start.rotations.size() &&
               std::all_of(state.q.begin(), state.q.end(), [](const Vec3& v) { return v.allFinite(); });
      };
      archive.require(archive.at_end() && fits(progress.state) && fits(progress.position.before) &&
                          progress.body_forces.size() == model.drives.size() &&
                          progress.position.time == resumption_->at.stage_time && progress.position.size > 0 &&
                          progress.position.last_size > 0 && progress.position.n_accepted > 0,
                      "a stage of another scene");
    } catch (const ArchiveError& error) {
      fail_to_resume(error);
    }
    return progress;
  }
  [[noreturn]] void fail_to_resume(const ArchiveError& error) const {
    throw InputError(fmt::format("--resume: {} is damaged: {}", options_.states.string(), error.what()));
  }

  void warn(const std::string& text) {
    if (options_.log) options_.log("warning: " + text);
    summary_.warnings.push_back(text);
  }

  /// Ends have no contact: those that went into other fibers are counted and named.
  void look_for_buried_ends(const StageModel& model, const State& state, const Stage& stage) {
    if (!model.contact) return;
    const std::vector<BuriedEnd> ends = free_buried_ends(model, state, assembly_);
    summary_.n_buried_ends = static_cast<Index>(ends.size());
    if (!ends.empty())
      warn(fmt::format("stage {}: {} inside other fibers, where ends have no contact: {}", stage.name,
                       ends.size() == 1 ? "1 fiber end lies" : fmt::format("{} fiber ends lie", ends.size()),
                       names_of(ends, model.field)));
  }

  /// What the machine lacks ends a run, but not what it has saved.
  void run_as_far_as_it_goes(std::size_t stage) {
    const auto end = [&](Status status, const std::string& why) {
      summary_.status = status;
      summary_.message = why + how_to_go_on();
    };
    try {
      run(scene_.stages[stage], stage);
    } catch (const WriteError& error) {
      end(Status::cannot_write, error.what());
    } catch (const std::bad_alloc&) {
      end(Status::gave_up, "there is not enough memory to go on");
    }
  }

  [[nodiscard]] std::string how_to_go_on() const {
    return summary_.n_increments > 0 ? ". Once there is room, --resume goes on from the last state that is saved" : "";
  }

  void run(const Stage& stage, std::size_t index) {
    const bool resumes = resumption_ && resumption_->at.within;
    if (!resumes) place_leaders(assembly_, stage, carried_.poses);
    StageModel model(scene_, assembly_, stage, carried_);
    if (resumes) forget_contacts();
    if (!resumes) gauge_.begin_stage(model);
    if (options_.log) options_.log(fmt::format("stage {}: {} dofs", stage.name, model.layout.n_dofs()));

    const double smallest_radius = *std::min_element(assembly_.mesh.radius.begin(), assembly_.mesh.radius.end());
    NewtonSettings newton_settings;
    newton_settings.force_tolerance = std::min(scene_.solver.force_tolerance, scene_.solver.geometry_tolerance);
    newton_settings.max_iterations = scene_.solver.max_newton_iterations;
    newton_settings.step_cap = scene_.solver.step_cap;
    newton_settings.precision = scene_.solver.factor_precision;
    if (model.contact) newton_settings.travel_cap = scene_.contact.search_margin;
    newton_settings.damps_soft_modes = model.proximal == nullptr;
    newton_settings.units = units_of_motion(model, smallest_radius);
    newton_settings.stop = [this] { return stop_requested(); };
    LoadPathSettings path;
    path.n_increments = stage.n_increments;
    path.max_geometry_updates = scene_.solver.max_geometry_updates;
    // Limits that follow forces that follow limits may go to and fro a little below that.
    path.friction_tolerance = std::max(100 * newton_settings.force_tolerance, 1e-6);
    path.min_increment = scene_.solver.min_increment;
    path.may_take_whole_steps = !model.contact;
    path.prediction_cap = newton_settings.step_cap * smallest_radius;
    NewtonSolver newton(model.layout, newton_settings, summary_.n_threads, summary_.timers);
    if (!resumes) begin_books(model);
    StageProgress at =
        resumes ? stage_progress(model, newton) : StageProgress{{}, model.start, body_forces(model, model.start)};
    if (resumes) go_on_in_stage(model, at);
    State& state = at.state;
    State before = state;
    StageDriver driver;
    driver.log = options_.log;
    driver.stop = [this] { return stop_requested(); };
    // Fibers that are still being damped are on their way, not in equilibrium.
    driver.slack = [&](double to) { return model.proximal && (to < 1 || stage.proximal_end > 0) ? slack_on_the_way : 1.0; };
    driver.motion = [&](const State& s, double from, double to) { return model.motion(s, from, to); };
    driver.accepted = [&](const State& accepted, const IncrementReport& report) {
      const std::vector<double> forces_now = body_forces(model, accepted);
      books_before_[Source::bodies] += external_work(model, before, accepted, at.body_forces, forces_now);
      if (at.position.n_accepted == 1) {
        books_before_[Sink::release] += released(stage, accepted, report.stage_time);
        forget_contacts();
      }
      books_ = books_before_;
      books_ += energy_books(model, accepted);
      at.body_forces = forces_now;
      before = accepted;
      return record(model, accepted, report, stage, index, [&] { remember(model, newton, at, index); });
    };
    const StageOutcome outcome = run_stage(newton, model.effects, path, driver, summary_.timers, at.position, state);

    model.field.write_configuration(state, carried_.configuration);
    for (Index b = 0; b < model.bodies.n_bodies(); ++b) carried_.poses[b] = model.bodies.pose(state, b);
    carried_.body_forces = body_forces(model, state);
    if (model.contact) {
      carried_.contact_history = model.contact->history();
      carried_.contact_tractions = model.contact->tractions();
    }
    if (model.crossing_order) add_history(carried_.contact_history, model.crossing_order->history());
    carried_.just_separated = stage.separate_yarns;
    count_crossings(model, state, assembly_, summary_);
    look_for_buried_ends(model, state, stage);
    if (outcome.status != StageOutcome::Status::done && since_saved_ > 0) {
      // The effects stand at the failed attempt: bring their contact elements back to the last good state.
      begin_at(model.effects, state, outcome.stage_time);
      save(model, state, last_point_, last_solver_);
    }
    if (outcome.status == StageOutcome::Status::interrupted) summary_.status = Status::interrupted;
    if (outcome.status == StageOutcome::Status::gave_up) {
      summary_.status = Status::gave_up;
      summary_.message = fmt::format("stage {} at stage time {:.4f}: {}{}; the smallest allowed increment failed",
                                     stage.name, outcome.stage_time, outcome.reason,
                                     outcome.worst_dof ? ", near " + model.describe_dof(*outcome.worst_dof) : "");
      if (outcome.worst_dof)
        summary_.message +=
            ". Try more increments in this stage, a larger proximal term, a larger solver.max_newton_iterations or "
            "a softer contact.penalty";
    }
  }

  /// What was begun with the stage that is gone on with is there again; the rest of the run goes on as any.
  void go_on_in_stage(const StageModel& model, const StageProgress& at) {
    continuation_ = resumption_->kept.bytes();  // should the run end before the next increment
    // Of a stage that is over its elements are asked for, as the last step has left them.
    if (at.position.time >= 1) begin_at(model.effects, at.state, at.position.time);
    resumption_.reset();
  }

  /// They are the model's, once its stage is under way.
  void forget_contacts() {
    carried_.contact_history.clear();
    carried_.contact_tractions.clear();
  }

  /// Books the stored energy that comes and goes with the effects and fiber models of a stage, before anything moves.
  void begin_books(const StageModel& model) {
    begin_at(model.effects, model.start, 0);
    books_before_ = books_;
    books_before_.stored = 0;
    books_before_[Source::stages] += energy_books(model, model.start).stored - books_.stored;
  }

  /// Energy that fibers lose on the way to `first`, the first increment of a stage, which finds them out of balance:
  /// the work of what nothing holds on the way, by Simpson's rule, on a model of the stage as it begins. (What that
  /// lacks at the end, preloads that were raised on the way, has risen linearly.) Forces on bodies are part of what the
  /// bodies' work is counted with, but for followers.
  [[nodiscard]] double released(const Stage& stage, const State& first, double stage_time) const {
    const StageModel model(scene_, assembly_, stage, carried_);
    const State& start = model.start;
    std::vector<double> motion(model.layout.n_dofs(), 0.0);
    for (std::size_t d = 0; d < motion.size(); ++d)
      if (d >= model.drives.size() || model.drives[d].kind == DofDrive::Kind::follow)
        motion[d] = first.q[d / 3][static_cast<Index>(d % 3)] - start.q[d / 3][static_cast<Index>(d % 3)];
    const auto force_along = [&](const State& state, double at) {
      begin_at(model.effects, start, at);
      const std::vector<double> force = gradient(model, state);
      return std::inner_product(motion.begin(), motion.end(), force.begin(), 0.0);
    };
    const double at_start = force_along(start, 0), at_end = force_along(first, stage_time);
    return -(at_start + 4 * force_along(halfway(start, first), 0.5 * stage_time) - 2 * at_end) / 6;
  }

  /// Saves an accepted increment and tells the watcher; returns whether to go on. `remember`: see there.
  bool record(const StageModel& model, const State& state, const IncrementReport& report, const Stage& stage,
              std::size_t stage_index, const std::function<void()>& remember) {
    SolverRecord solver;
    solver.n_newton_iterations = report.n_newton_iterations;
    solver.n_factorizations = report.n_factorizations;
    solver.n_geometry_updates = report.n_geometry_updates;
    solver.n_cuts = report.n_cuts;
    solver.residual = solver.force_imbalance = report.residual;
    solver.moment_imbalance = moment_imbalance(model, state);
    solver.max_penetration_over_radius = model.contact ? model.contact->max_penetration_over_radius() : 0;
    solver.proximal = model.proximal ? model.proximal->eta() : 0;
    solver.seconds = report.seconds;
    solver.unstable = report.unstable ? 1 : 0;
    if (report.unstable && ++summary_.n_unstable_increments == 1)
      first_unstable_ = fmt::format("in stage {} at stage time {:.4f}", stage.name, report.stage_time);
    solver.energy = dimensional(books_, scales_);

    const auto n_contacts = static_cast<Index>((model.contact ? model.contact->elements().size() : 0) +
                                               (model.crossing_order ? model.crossing_order->elements().size() : 0));
    summary_.n_contact_elements_max = std::max(summary_.n_contact_elements_max, n_contacts);
    ++summary_.n_increments;
    summary_.n_cut_increments += report.n_cuts;
    summary_.n_newton_iterations += report.n_newton_iterations;
    summary_.n_factorizations += report.n_factorizations;
    summary_.max_penetration_over_radius = solver.max_penetration_over_radius;
    summary_.force_imbalance = solver.force_imbalance;
    summary_.moment_imbalance = solver.moment_imbalance;
    summary_.energy = solver.energy;
    CurvePoint point = gauge_.read(model, state, scales_);
    point.stage = stage.name;
    point.stage_time = report.stage_time;
    point.energy = solver.energy;
    summary_.curve.push_back(point);

    last_point_ = point;
    last_solver_ = solver;
    ++since_saved_;
    remember();
    const bool stop = stop_requested();
    if (stop || report.stage_time >= 1 || since_saved_ >= stage.save_every) save(model, state, point, solver);
    if (options_.on_increment) options_.on_increment(progress(report, stage, stage_index, solver, n_contacts));
    return !stop;
  }

  [[nodiscard]] bool stop_requested() const { return options_.stop && *options_.stop; }

  void save(const StageModel& model, const State& state, const CurvePoint& point, const SolverRecord& solver) {
    const auto guard = summary_.timers.measure(Phase::io);
    FiberConfiguration configuration = carried_.configuration;  // sections of rods go on from the stage's start
    model.field.write_configuration(state, configuration);
    append({point.stage, point.stage_time, dimensional(configuration, scales_),
            record_contacts(model, state, scales_), record_bodies(model, state, scales_), solver});
    since_saved_ = 0;
  }

  Progress progress(const IncrementReport& report, const Stage& stage, std::size_t stage_index,
                    const SolverRecord& solver, Index n_contacts) const {
    double done = 0, all = 0;
    for (std::size_t i = first_stage_; i < scene_.stages.size(); ++i) {
      const double share = scene_.stages[i].n_increments;
      all += share;
      done += i < stage_index ? share : i == stage_index ? share * report.stage_time : 0;
    }
    return {stage.name,
            static_cast<Index>(stage_index),
            static_cast<Index>(scene_.stages.size()),
            report.stage_time,
            done / all,
            summary_.n_increments,
            &solver,
            n_contacts};
  }

  const SimulateOptions& options_;
  Scales scales_;
  Scene scene_;  // in natural units
  Assembly assembly_;
  SideGauge gauge_;
  Carried carried_;
  std::size_t first_stage_ = 0;
  std::optional<Restart> restart_;
  std::optional<Resumption> resumption_;  // until the run goes on
  SimulationSummary summary_;
  SnapshotHeader header_;
  std::unique_ptr<SnapshotWriter> writer_;
  bool states_are_in_place_ = false;
  std::string continuation_;  // of the last accepted increment
  // Energies since the start of the run, natural units; and without what the effects of the current stage know.
  Ledger books_, books_before_;
  // The last accepted increment, and how many increments ago one was saved.
  CurvePoint last_point_;
  SolverRecord last_solver_;
  Index since_saved_ = 0;
  std::string first_unstable_;  // where and when
};

}  // namespace

ModelSize model_size(const Scene& scene) {
  const Assembly assembly = assemble_scene(scene);
  ModelSize size;
  size.n_fibers = assembly.mesh.n_fibers();
  size.n_nodes = assembly.mesh.n_nodes();
  size.n_bodies = static_cast<Index>(assembly.body_names.size());
  for (const Stage& stage : scene.stages) {
    Layout layout;
    const RigidBodies bodies(size.n_bodies, layout);
    const FiberField field(assembly.mesh, models_in_stage(scene, assembly, stage), layout);
    size.n_dofs_per_stage.push_back(layout.n_dofs());
    size.n_dofs = std::max<std::int64_t>(size.n_dofs, layout.n_dofs());
  }
  return size;
}

StartPoint check_start(const Scene& scene, const SimulateOptions& options) {
  Run run(scene, options);
  run.check_resumption();
  return run.start();
}

SimulationSummary simulate(const Scene& scene, const SimulateOptions& options) {
  if (scene.fibers.empty() && scene.bundles.empty() && !scene.weave)
    throw InputError(
        fmt::format("{}: there is no fiber; a scene must have at least one fiber, bundle or weave", scene.name));
  return Run(scene, options).follow_load_path();
}

}  // namespace trame::micro
