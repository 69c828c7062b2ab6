/// \file
/// strain_post: strains of yarns between two states of their fibers, for ParaView, as tables and as a report.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <numeric>
#include <regex>
#include <utility>
#include <vector>

#include "meso/strain_series.h"
#include "micro/core/error.h"
#include "micro/core/text.h"
#include "workflows/program/folder_lock.h"
#include "workflows/program/run_main.h"
#include "workflows/program/saved_state.h"
#include "workflows/report/html_report.h"
#include "workflows/strains/fiber_nodes.h"
#include "workflows/strains/finding_tables.h"
#include "workflows/strains/state_list.h"
#include "workflows/strains/strain_tables.h"

namespace {

namespace fs = std::filesystem;
using trame::Index;
using trame::InputError;
using trame::meso::Comparison;
using trame::meso::FiberStates;
using trame::meso::MeshKind;
using trame::meso::YarnComparer;
using trame::micro::Copies;
using namespace trame::workflows;

struct Arguments {
  std::vector<fs::path> states;
  std::string from = "0", to = "last", mesh = "delaunay", copies = "1x1";
  trame::meso::ComparisonSettings settings;
  fs::path out;
  bool list = false, every = false, overwrite = false, no_report = false;
};

void define(CLI::App& app, Arguments& arguments) {
  app.set_version_flag("--version", TRAME_VERSION);
  app.footer(
      "Writes yarns.pvd (ParaView), strains.csv, bands.csv, orientation.csv and zones.csv (shear bands on sections,\n"
      "directions in which strains hang together, bands in 3D), with --mesh both in a folder for each mesh;\n"
      "sections.csv, continuum.csv (may the yarns be taken as continua?) and\n"
      "report.html. With --every, yarns.pvd and strains.csv hold all states, the others compare A with B. Strains are\n"
      "Green-Lagrange, from state A to state B, in the yarn frame of A: axial along the fibers, vertical along z made\n"
      "normal to it, horizontal across. Meshes belong to the first state. Layouts of files: micro/states/README.md.\n" +
      std::string(exit_codes_text));
  app.add_option(
         "states", arguments.states,
         "State file of a run (HDF5); or fiber nodes from elsewhere: one HDF5 file, or per state one .vtp, .csv or "
         ".txt file")
      ->required();
  const std::string meaning = ": number of an increment, name of a stage (its end), or \"last\"";
  app.add_option("--from", arguments.from, "State A" + meaning)->capture_default_str();
  app.add_option("--to", arguments.to, "State B" + meaning)->capture_default_str();
  app.add_flag("--every", arguments.every, "All increments from A to B as a time series, not B alone");
  app.add_option("--yarns", arguments.settings.yarns, "Names of yarns, with * and ? as wildcards; default: all");
  app.add_option("--mesh", arguments.mesh, "How yarns are meshed")
      ->check(CLI::IsMember({"delaunay", "swept", "both"}))
      ->type_name("delaunay|swept|both")
      ->capture_default_str();
  app.add_option("--copies", arguments.copies,
                 "Copies of a periodic cell in yarns.pvd, along warp and weft, such as 2x2")
      ->capture_default_str();
  app.add_option("--out", arguments.out, "Folder for the results; default: strains, beside the state file");
  app.add_option("--threads", arguments.settings.n_threads, "Number of threads; 0: all cores")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_flag("--no-report", arguments.no_report, "Without report.html, whose pictures take some seconds");
  app.add_flag("--overwrite", arguments.overwrite, "Write into a folder that is not empty");
  app.add_flag("--list", arguments.list, "List the states, their loads and the yarns, and end");
}

/// Throws where results may not go to `out`; leaves it as it is.
void check_out(const fs::path& out, bool overwrite) {
  if (!fs::exists(out)) return;
  if (!fs::is_directory(out)) throw InputError(fmt::format("--out {}: not a folder", out.string()));
  const fs::directory_iterator entries(out);
  const bool is_empty = std::all_of(begin(entries), end(entries),
                                    [](const auto& entry) { return entry.path().filename() == FolderLock::file_name; });
  if (!is_empty && !overwrite)
    throw InputError(
        fmt::format("--out {}: the folder is not empty; choose another one, or --overwrite", out.string()));
}

FolderLock make_folder(const fs::path& out) {
  std::error_code error;
  fs::create_directories(out, error);
  if (error) throw InputError(fmt::format("--out {}: cannot be created: {}", out.string(), error.message()));
  return {"--out", out};
}

void remove_earlier_results(const fs::path& out) {
  if (!fs::exists(out)) return;
  const std::regex ours(
      R"((yarns(\.pvd|_[0-9]+\.vtu)|(strains|sections|bands|orientation|zones|continuum)\.csv|report\.html)(\.part)?)");
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(out))
    if (std::regex_match(entry.path().filename().string(), ours)) files.push_back(entry.path());
  for (const fs::path& file : files) fs::remove(file);
}

/// States B: the last one, or all from A to it.
std::vector<Index> states_to_compare(Index a, Index b, bool every) {
  if (!every) return {b};
  if (a > b) throw InputError(fmt::format("--every: state A ({}) is after state B ({})", a, b));
  std::vector<Index> all(b - a + 1);
  std::iota(all.begin(), all.end(), a);
  return all;
}

/// The states that will be read.
std::vector<Index> states_to_read(const FiberStates& states, const Arguments& arguments) {
  if (arguments.list) return states_to_compare(0, states.n_increments() - 1, true);
  const Index a = find_state(states, "--from", arguments.from), b = find_state(states, "--to", arguments.to);
  std::vector<Index> all = states_to_compare(a, b, arguments.every);
  all.push_back(a);
  return all;
}

std::vector<MeshKind> mesh_kinds(const std::string& mesh) {
  if (mesh == "both") return {MeshKind::delaunay, MeshKind::swept};
  return {mesh == "swept" ? MeshKind::swept : MeshKind::delaunay};
}

/// Where the results of each mesh go.
std::vector<fs::path> mesh_folders(const Arguments& arguments) {
  if (arguments.mesh == "both") return {arguments.out / "delaunay", arguments.out / "swept"};
  return {arguments.out};
}

/// Strains of all states for ParaView and strains.csv, and everything of the last one.
Comparison compare_states(const YarnComparer& comparer, const Arguments& arguments, const Copies& copies, Index a,
                          const std::vector<Index>& to) {
  const std::vector<fs::path> folders = mesh_folders(arguments);
  std::vector<StrainsCsv> tables;  // no file before the first state is compared
  const auto append = [&](const trame::meso::StateStrains& strains) {
    if (tables.empty())
      for (const fs::path& folder : folders)
        tables.emplace_back(folder / "strains.csv", comparer.states().header().mesh.yarns);
    for (std::size_t m = 0; m < tables.size(); ++m) tables[m].append(strains.meshes[m].summaries);
  };
  std::vector<Comparison> comparisons = follow(
      comparer,
      {.from = a, .to = to, .compare = {to.back()}, .vtk_folders = folders, .copies = copies, .on_state = append});
  return std::move(comparisons.back());
}

void write_tables(const Arguments& arguments, const std::vector<trame::micro::Yarn>& yarns,
                  const Comparison& comparison) {
  write_sections_csv(arguments.out / "sections.csv", yarns, comparison);
  write_continuum_csv(arguments.out / "continuum.csv", yarns, comparison);
  const std::vector<fs::path> folders = mesh_folders(arguments);
  for (std::size_t m = 0; m < folders.size(); ++m) {
    write_bands_csv(folders[m] / "bands.csv", yarns, comparison, m);
    write_orientation_csv(folders[m] / "orientation.csv", yarns, comparison, m);
    write_zones_csv(folders[m] / "zones.csv", yarns, comparison, m);
  }
}

void print_all(const std::vector<trame::micro::Yarn>& yarns, const YarnComparer& comparer,
               const Comparison& comparison) {
  fmt::print("Strains from increment {} to {}:\n", comparison.pair.from, comparison.pair.to);
  print_strains(yarns, comparison);
  for (std::size_t m = 0; m < comparer.settings().meshes.size(); ++m) {
    fmt::print("\nSections, bands and zones of the {} mesh:\n", text(comparer.settings().meshes[m]));
    print_findings(yarns, comparison, m);
  }
  print_validity(yarns, comparison);
}

/// With what a run wrote beside its states. What the report lacks.
std::string report(const FiberStates& states, const Arguments& arguments, const Comparison& comparison) {
  const fs::path folder = fs::absolute(arguments.states[0]).parent_path();
  const auto beside = [&](const char* name) {
    const bool is_run = !states.header().version.empty();
    return is_run && fs::exists(folder / name) ? folder / name : fs::path();
  };
  return write_report({.states = states,
                       .comparisons = {&comparison},
                       .file = arguments.out / "report.html",
                       .yarns = arguments.settings.yarns,
                       .summary = beside("summary.json"),
                       .curves = beside("curves.csv")});
}

void run(Arguments& arguments) {
  probe_states(arguments.states, [&](const FiberStates& states) { return states_to_read(states, arguments); });
  const auto opened = open_states(arguments.states);
  const FiberStates& states = *opened;
  for (const std::string& remark : states.remarks())
    std::fputs(fmt::format("strain_post: {}: {}.\n", states.name(), trame::printable(remark)).c_str(), stderr);
  if (arguments.list) return print_states(states);
  if (states.header().mesh.yarns.empty()) throw InputError(states.name() + ": holds no yarn");
  const Index a = find_state(states, "--from", arguments.from), b = find_state(states, "--to", arguments.to);
  const std::vector<Index> to = states_to_compare(a, b, arguments.every);
  arguments.settings.meshes = mesh_kinds(arguments.mesh);
  if (arguments.out.empty()) arguments.out = fs::absolute(arguments.states[0]).parent_path() / "strains";
  // What is wrong with the choice or the reference state is said before anything is removed.
  (void)trame::meso::choose_yarns(states.header().mesh.yarns, arguments.settings.yarns);
  const Copies copies = trame::micro::parse_copies(arguments.copies);
  trame::micro::check_copies(copies, trame::micro::is_periodic(periods_of(states.header(), states.read(a))));
  check_out(arguments.out, arguments.overwrite);
  const YarnComparer comparer(states, arguments.settings);
  const FolderLock lock = make_folder(arguments.out);
  for (const fs::path& folder : {arguments.out, arguments.out / "delaunay", arguments.out / "swept"})
    remove_earlier_results(folder);
  const Comparison comparison = compare_states(comparer, arguments, copies, a, to);
  const std::vector<trame::micro::Yarn>& yarns = states.header().mesh.yarns;
  write_tables(arguments, yarns, comparison);
  const std::string lacks = arguments.no_report ? "" : report(states, arguments, comparison);
  // Only when all is written: there may be no one to read it.
  print_all(yarns, comparer, comparison);
  if (!lacks.empty()) fmt::print("report.html: {}\n", lacks);
  fmt::print("\nResults in {}; ParaView: open yarns.pvd, Apply, colour by E_axial\n", arguments.out.string());
}

}  // namespace

int main(int argc, char** argv) {
  return run_main("strain_post", argv, [&]() -> int {
    CLI::App app("Strains of the yarns of a fabric between two states of its fibers.");
    Arguments arguments;
    define(app, arguments);
    if (parse_arguments(app, argc, argv)) run(arguments);
    return exit_done;
  });
}
