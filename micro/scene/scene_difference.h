#pragma once
/// \file
/// Where two scenes differ, in their users' words.

#include <string>
#include <string_view>
#include <vector>

namespace trame::micro {

/// The first key within some tables at the top of a scene, such as "contact", that two texts do not share, with what
/// stands there: "contact.friction_coefficient is 0.3 there and 0.2 here"; tables of an array have their numbers, from
/// 1. Empty where these tables are the same, or a text cannot be read.
[[nodiscard]] std::string scene_difference(const std::string& there, const std::string& here,
                                           const std::vector<std::string_view>& tables);

}  // namespace trame::micro
