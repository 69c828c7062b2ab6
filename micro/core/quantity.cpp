#include "micro/core/quantity.h"

#include <fmt/format.h>
#include <udunits2.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <memory>
#include <string>
#include <utility>

#include "micro/core/error.h"
#include "micro/core/text.h"

namespace trame {

namespace {

using Unit = std::unique_ptr<ut_unit, decltype(&ut_free)>;
using Converter = std::unique_ptr<cv_converter, decltype(&cv_free)>;

using UnitSystem = std::unique_ptr<ut_system, decltype(&ut_free_system)>;

/// The units of UDUNITS, and "deg", which it only knows as degree, arc_degree or °.
UnitSystem load_units() {
  ut_set_error_message_handler(ut_ignore);  // the default writes to stderr
  UnitSystem system(ut_read_xml(nullptr), ut_free_system);
  if (!system)
    throw NoUnits(
        "the unit database of UDUNITS (udunits2.xml) cannot be read: is it installed, may a process open that many "
        "files (ulimit -n)?");
  const Unit degree(ut_get_unit_by_name(system.get(), "arc_degree"), ut_free);
  if (degree) ut_map_name_to_unit("deg", UT_ASCII, degree.get());
  return system;
}

ut_system* unit_system() {
  static const UnitSystem system = load_units();
  return system.get();
}

Unit parse_unit(const std::string& text) { return {ut_parse(unit_system(), text.c_str(), UT_UTF8), ut_free}; }

/// "per cm" and "/cm" as UDUNITS has them.
std::string with_numerator(const std::string& unit) {
  if (unit.starts_with("per ")) return "1/" + unit.substr(4);
  return unit.starts_with("/") ? "1" + unit : unit;
}

/// Whether the definition in base units holds a radian, which UDUNITS takes for a plain 1.
bool is_angular(const ut_unit* unit) {
  char text[256];
  const int length = ut_format(unit, text, sizeof text, UT_ASCII | UT_DEFINITION);
  return length > 0 &&
         std::string_view(text, std::min<std::size_t>(length, sizeof text)).find("rad") != std::string_view::npos;
}

/// Whether one unit is a multiple of the other. UDUNITS itself also converts reciprocals (s to Hz), angles to numbers
/// and scales with another zero (m from 10).
bool are_multiples(ut_unit* a, ut_unit* b) {
  const Unit quotient(ut_divide(a, b), ut_free);
  if (!quotient || !ut_is_dimensionless(quotient.get()) || is_angular(a) != is_angular(b)) return false;
  const Converter converter(ut_get_converter(a, b), cv_free);
  return converter && cv_convert_double(converter.get(), 0.0) == 0;
}

/// How many `to` one `from` is.
double conversion_factor(ut_unit* from, ut_unit* to) {
  const Converter converter(ut_get_converter(from, to), cv_free);
  return cv_convert_double(converter.get(), 1.0);
}

/// Whether a number stands where a unit should, which UDUNITS takes for a factor: "m 3", "3/m".
bool has_number(std::string_view unit) {
  constexpr std::string_view separators = " \t.*/", number_starts = "0123456789+-";
  for (std::size_t i = 0; i < unit.size(); ++i)
    if (number_starts.find(unit[i]) != unit.npos && (i == 0 || separators.find(unit[i - 1]) != unit.npos)) return true;
  return false;
}

/// The text with plain characters for those that word processors and web pages put instead: spaces that do not break or
/// are thin, the minus sign.
std::string with_plain_signs(std::string_view text) {
  constexpr std::pair<std::string_view, char> signs[] = {
      {"\u00a0", ' '}, {"\u2009", ' '}, {"\u202f", ' '}, {"\u2212", '-'}};
  std::string plain;
  while (!text.empty()) {
    const auto sign =
        std::find_if(std::begin(signs), std::end(signs), [&](const auto& s) { return text.starts_with(s.first); });
    const bool found = sign != std::end(signs);
    plain += found ? sign->second : text.front();
    text.remove_prefix(found ? sign->first.size() : 1);
  }
  return plain;
}

/// A number of the start of `text`, and what follows it.
std::pair<double, std::string_view> split_number(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0;
  const auto [rest, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status == std::errc::result_out_of_range && std::abs(std::strtod(std::string(text).c_str(), nullptr)) < 1)
    throw InputError("the number is nearer to 0 than a number can be; write 0");
  if (status == std::errc::result_out_of_range || (status == std::errc() && !std::isfinite(value)))
    throw InputError("the number is not finite");
  if (status != std::errc()) throw InputError("does not start with a number");
  const std::string_view unit(rest, static_cast<std::size_t>(text.data() + text.size() - rest));
  if (unit.size() > 1 && unit[0] == ',' && unit[1] >= '0' && unit[1] <= '9')
    throw InputError("a number has a point, not a comma");
  return {value, unit};
}

}  // namespace

double parse_quantity(std::string_view text, std::string_view si_unit) {
  constexpr std::size_t longest = 1000;  // UDUNITS goes as deep as its brackets do
  if (text.size() > longest) throw InputError(fmt::format("longer than {} bytes", longest));
  const std::string plain = with_plain_signs(text);
  const auto [value, after] = split_number(trimmed(plain));
  const std::string unit_text(trimmed(after));
  if (unit_text.empty()) throw InputError("the unit is missing");
  const Unit expected = parse_unit(std::string(si_unit));
  assert(expected && "si_unit must be known to UDUNITS");
  const Unit unit = has_number(unit_text) ? Unit(nullptr, ut_free) : parse_unit(with_numerator(unit_text));
  if (!unit) throw InputError(fmt::format("\"{}\" is not a unit", unit_text));
  if (!are_multiples(unit.get(), expected.get()))
    throw InputError(fmt::format("\"{}\" does not convert to {}", unit_text, si_unit));
  // A small unit divides, because 10^6 is a double and 10^-6 is not: "19 um" is the double nearest to 19e-6.
  const double factor = conversion_factor(unit.get(), expected.get());
  const double si = factor < 1 ? value / conversion_factor(expected.get(), unit.get()) : value * factor;
  if (!std::isfinite(si)) throw InputError("the number is not finite");
  return si;
}

}  // namespace trame
