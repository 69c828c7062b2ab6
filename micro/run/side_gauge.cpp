#include "micro/run/side_gauge.h"

#include <algorithm>
#include <string>

namespace trame::micro {

SideGauge::SideGauge(const Assembly& assembly) : present_(!assembly.crossings.empty()) {
  const auto& names = assembly.body_names;
  for (const std::string family : {"warp", "weft"}) {
    if (const Index period = assembly.period_bodies[sides_.size()]; period >= 0) {
      sides_.push_back({period, period, period, {}, {}});
      continue;
    }
    const auto find = [&](const std::string& name) {
      return static_cast<Index>(std::find(names.begin(), names.end(), name) - names.begin());
    };
    sides_.push_back({-1, find("side/" + family + "/start"), find("side/" + family + "/end"), {}, {}});
    for (std::size_t b = 0; b < names.size(); ++b)
      if (names[b].starts_with(family + "/"))
        (names[b].ends_with("/start") ? sides_.back().start_yarns : sides_.back().end_yarns)
            .push_back(static_cast<Index>(b));
  }
}

void SideGauge::begin_stage(const StageModel& model, const std::array<double, 2>& last) {
  if (!present_) return;
  using Kind = DofDrive::Kind;
  bool driven = false, loose = false;
  for (int d = 0; d < 2; ++d) {
    const auto kind = [&](Index body) { return model.drives[6 * body + d].kind; };
    if (const Index period = sides_[d].period; period >= 0) {
      if (kind(period) != Kind::held) (model.proximal ? loose : driven) = true;
      continue;
    }
    for (const Index b : {sides_[d].start, sides_[d].end}) driven = driven || kind(b) != Kind::held;
    for (const auto* yarns : {&sides_[d].start_yarns, &sides_[d].end_yarns})
      for (const Index b : *yarns) loose = loose || (kind(b) != Kind::held && kind(b) != Kind::follow);
  }
  if (!driven && loose) strained_ = false;
  for (int d = 0; d < 2; ++d) reference_[d] = distance(model, model.start, d) / (strained_ ? 1 + last[d] : 1);
  strained_ = strained_ || driven;
}

SideGauge::Reading SideGauge::read(const StageModel& model, const State& state) const {
  Reading reading;
  for (int d = 0; d < 2 && present_; ++d) {
    const auto force_along = [&](Index body, const Vec3& force) { return model.bodies.force_in_dofs(body, force)[d]; };
    reading.strain[d] = distance(model, state, d) / reference_[d] - 1;
    if (sides_[d].period >= 0) {
      reading.force[d] = force_along(sides_[d].period, model.pull(state, sides_[d].period).first);
      continue;
    }
    double pull = 0;
    for (const Index b : sides_[d].end_yarns) pull += force_along(b, model.ties->pull(state, b).first);
    for (const Index b : sides_[d].start_yarns) pull -= force_along(b, model.ties->pull(state, b).first);
    reading.force[d] = 0.5 * pull;
  }
  return reading;
}

double SideGauge::distance(const StageModel& model, const State& state, int d) const {
  const auto place = [&](Index body) { return model.bodies.in_dofs(body, model.bodies.pose(state, body).position)[d]; };
  if (sides_[d].period >= 0) return place(sides_[d].period);
  return place(sides_[d].end) - place(sides_[d].start);
}

}  // namespace trame::micro
