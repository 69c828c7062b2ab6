#pragma once
/// \file
/// The text of a scene that is tried with drives of all kinds.

#include <fmt/format.h>

#include <string>

namespace trame::test {

/// A rod "fiber" of 1 mm along x, R = 10 µm, E = 1 GPa, its ends tied to the bodies "left" and "right"; no contact, and
/// no stage yet.
inline std::string tied_rod(int n_elements) {
  return fmt::format(R"([material.m]
model = "isotropic"
young_modulus = "1 GPa"
poisson_ratio = 0
[fiber_type.f]
material = "m"
diameter = "20 um"
model = "rod"
[[fiber]]
name = "fiber"
fiber_type = "f"
points = [["0 um", "0 um", "0 um"], ["1 mm", "0 um", "0 um"]]
elements = {}
[[body]]
name = "left"
[[body.tie]]
fibers = "fiber"
end = "start"
[[body]]
name = "right"
position = ["1 mm", "0 um", "0 um"]
[[body.tie]]
fibers = "fiber"
end = "end"
[effects]
contact = "none"
)",
                     n_elements);
}

}  // namespace trame::test
