#pragma once
/// \file
/// The text of a scene of one rod, to which tests add what they are about.

#include <string>

namespace trame::test {

/// A material and a type of rods with a radius of 0.1 mm.
inline std::string rod_type() {
  return R"([material.m]
model = "isotropic"
young_modulus = "1 GPa"
poisson_ratio = 0.3
[fiber_type.f]
material = "m"
diameter = "0.2 mm"
model = "rod"
)";
}

/// One of them, straight on the x axis from 0 to 4 mm.
inline std::string rod_scene(const std::string& rest) {
  return rod_type() + R"([[fiber]]
name = "beam"
fiber_type = "f"
points = [["0 mm", "0 mm", "0 mm"], ["4 mm", "0 mm", "0 mm"]]
elements = 4
)" + rest;
}

}  // namespace trame::test
