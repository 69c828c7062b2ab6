#include "micro/core/quantity.h"

#include <fmt/format.h>
#include <udunits2.h>

#include <cassert>
#include <charconv>
#include <cmath>
#include <memory>
#include <string>

#include "micro/core/error.h"

namespace trame {

namespace {

using Unit = std::unique_ptr<ut_unit, decltype(&ut_free)>;
using Converter = std::unique_ptr<cv_converter, decltype(&cv_free)>;

ut_system* unit_system() {
  static const std::unique_ptr<ut_system, decltype(&ut_free_system)> system = [] {
    ut_set_error_message_handler(ut_ignore);  // the default writes to stderr
    return std::unique_ptr<ut_system, decltype(&ut_free_system)>(ut_read_xml(nullptr), ut_free_system);
  }();
  if (!system) throw InputError("the unit database of UDUNITS (udunits2.xml) cannot be read: is it installed?");
  return system.get();
}

Unit parse_unit(const std::string& text) { return {ut_parse(unit_system(), text.c_str(), UT_UTF8), ut_free}; }

/// Whether the definition in base units holds a radian, which UDUNITS takes for a plain 1.
bool is_angular(const ut_unit* unit) {
  char text[256];
  const int length = ut_format(unit, text, sizeof text, UT_ASCII | UT_DEFINITION);
  return length > 0 && std::string_view(text, std::min<std::size_t>(length, sizeof text)).find("rad") != std::string_view::npos;
}

/// How many `to` one `from` is, or 0 where they do not convert. UDUNITS itself would also convert reciprocals (s to Hz),
/// angles to numbers and shifted scales (m from 10).
double conversion_factor(const ut_unit* from, const ut_unit* to) {
  const Unit quotient(ut_divide(from, to), ut_free);
  if (!quotient || !ut_is_dimensionless(quotient.get()) || is_angular(from) != is_angular(to)) return 0;
  const Converter converter(ut_get_converter(from, to), cv_free);
  if (!converter || cv_convert_double(converter.get(), 0.0) != 0) return 0;
  return cv_convert_double(converter.get(), 1.0);
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blank = " \t";
  const auto first = text.find_first_not_of(blank);
  return first == text.npos ? std::string_view() : text.substr(first, text.find_last_not_of(blank) - first + 1);
}

}  // namespace

double parse_quantity(std::string_view text, std::string_view si_unit) {
  const std::string_view all = trimmed(text);
  double value = 0;
  const auto [rest, status] = std::from_chars(all.data(), all.data() + all.size(), value);
  if (status == std::errc::result_out_of_range || (status == std::errc() && !std::isfinite(value)))
    throw InputError("the number is not finite");
  if (status != std::errc()) throw InputError("does not start with a number");

  const std::string unit_text(trimmed(all.substr(rest - all.data())));
  if (unit_text.empty()) throw InputError("the unit is missing");
  const Unit expected = parse_unit(std::string(si_unit));
  assert(expected && "si_unit must be known to UDUNITS");
  // A second number would be taken for a factor.
  const bool starts_like_number = std::string_view("0123456789.+-").find(unit_text.front()) != std::string_view::npos;
  const Unit unit = starts_like_number ? Unit(nullptr, ut_free) : parse_unit(unit_text);
  if (!unit) throw InputError(fmt::format("\"{}\" is not a unit", unit_text));
  const double factor = conversion_factor(unit.get(), expected.get());
  if (!(factor > 0)) throw InputError(fmt::format("\"{}\" does not convert to {}", unit_text, si_unit));
  if (!std::isfinite(value * factor)) throw InputError("the number is not finite");
  return value * factor;
}

}  // namespace trame
