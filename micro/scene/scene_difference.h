#pragma once
/// \file
/// Where two scenes differ, in their users' words.

#include <string>

namespace trame::micro {

/// The first key that two texts of scenes do not share, with what stands there, such as
/// "contact.friction_coefficient is 0.3 there and 0.2 here"; tables of an array have their numbers, from 1. Titles and
/// stages do not count. Empty where nothing else differs, or one of them cannot be read.
[[nodiscard]] std::string scene_difference(const std::string& there, const std::string& here);

}  // namespace trame::micro
