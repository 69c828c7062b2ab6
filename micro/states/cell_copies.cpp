#include "micro/states/cell_copies.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "micro/core/error.h"
#include "micro/scene/weave.h"

namespace trame::micro {

namespace {

constexpr Index most_copies = 100;      // along a period
constexpr double closing_error = 1e-6;  // of the period: what may be missing where a fiber comes back

/// Bodies may have any name; only fibers that come back by its position make one a period.
bool comes_back_by(const Vec3& period, YarnFamily family, const FiberMesh& mesh, const std::vector<Vec3>& r) {
  const auto yarn = std::find_if(mesh.yarns.begin(), mesh.yarns.end(),
                                 [&](const Yarn& y) { return y.family == family && y.n_fibers > 0; });
  if (yarn == mesh.yarns.end()) return false;
  const Index first = mesh.first_node[yarn->first_fiber], last = mesh.first_node[yarn->first_fiber + 1] - 1;
  return (r[last] - r[first] - period).norm() <= closing_error * period.norm();
}

/// The number that all of `text` is, from 1 on; 0 where it is none.
Index count_of(std::string_view text) {
  Index count = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  return error == std::errc() && end == text.data() + text.size() && count > 0 ? count : 0;
}

}  // namespace

Periods periods_of(const SnapshotHeader& header, const Increment& increment) {
  Periods periods;
  const std::size_t n_bodies = std::min(header.body_names.size(), increment.bodies.position.size());
  for (std::size_t b = 0; b < n_bodies; ++b)
    for (const bool along_warp : {true, false}) {
      const Vec3& position = increment.bodies.position[b];
      if (header.body_names[b] == period_name(along_warp) &&
          comes_back_by(position, along_warp ? YarnFamily::warp : YarnFamily::weft, header.mesh, increment.fibers.r))
        periods[along_warp ? 0 : 1] = position;
    }
  return periods;
}

std::array<bool, 2> is_periodic(const Periods& periods) { return {periods[0].has_value(), periods[1].has_value()}; }

Copies parse_copies(const std::string& text) {
  const std::size_t by = text.find('x');
  Copies copies = {0, 0};
  if (by != text.npos)
    copies = {count_of(std::string_view(text).substr(0, by)), count_of(std::string_view(text).substr(by + 1))};
  if (std::min(copies[0], copies[1]) < 1 || std::max(copies[0], copies[1]) > most_copies)
    throw InputError(
        fmt::format("--copies {}: must be two numbers of 1 … {} with x between them, copies along the warp and along "
                    "the weft, such as 2x2",
                    text, most_copies));
  return copies;
}

void check_copies(const Copies& copies, const std::array<bool, 2>& is_periodic) {
  const auto refuse = [&](const char* why) {
    throw InputError(fmt::format("--copies {}x{}: {}", copies[0], copies[1], why));
  };
  if (copies != one_cell && !is_periodic[0] && !is_periodic[1])
    refuse("is for periodic cells, [weave] periodic = true; of other fibers there can only be 1x1");
  if (copies[0] > 1 && !is_periodic[0]) refuse("the weave is periodic along its weft alone, so it must begin with 1x");
  if (copies[1] > 1 && !is_periodic[1]) refuse("the weave is periodic along its warp alone, so it must end with x1");
}

Copies copies_to_show(const std::array<bool, 2>& is_periodic) {
  if (is_periodic[0] && is_periodic[1]) return {2, 2};
  return {is_periodic[0] ? 3 : 1, is_periodic[1] ? 3 : 1};
}

std::array<Index, 2> copy_range(Index n) { return {-((n - 1) / 2), n / 2}; }

std::vector<CopyNumber> copy_numbers(const Copies& copies) {
  const auto [first_i, last_i] = copy_range(copies[0]);
  const auto [first_j, last_j] = copy_range(copies[1]);
  std::vector<CopyNumber> numbers;
  for (Index j = first_j; j <= last_j; ++j)
    for (Index i = first_i; i <= last_i; ++i) numbers.push_back({i, j});
  return numbers;
}

Vec3 displacement_of(const CopyNumber& copy, const Periods& periods) {
  Vec3 displacement = Vec3::Zero();
  for (int p = 0; p < 2; ++p)
    if (periods[p]) displacement += copy[p] * *periods[p];
  return displacement;
}

}  // namespace trame::micro
