#pragma once
/// \file
/// Text from outside: what may stand in a name, and how any bytes are shown on a terminal.

#include <fmt/format.h>
#include <utf8.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>

namespace trame {

/// `text` without blanks and tabs at its ends.
[[nodiscard]] constexpr std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blank = " \t";
  const auto first = text.find_first_not_of(blank);
  return first == text.npos ? std::string_view() : text.substr(first, text.find_last_not_of(blank) - first + 1);
}

/// Names stand in state files, tables and pictures, so they are bounded; so are texts of one line.
inline constexpr std::size_t max_name_bytes = 128, max_text_bytes = 1000;

/// Characters that steer a terminal, a script or a table instead of being read: control characters (C0, DEL, C1), line
/// and paragraph separators, those that turn the direction of writing, and those that nobody sees (but for the joiners
/// that some scripts are written with).
[[nodiscard]] constexpr bool is_control(char32_t c) {
  return c < 0x20 || (c >= 0x7f && c < 0xa0) || c == 0x2028 || c == 0x2029 || (c >= 0x202a && c <= 0x202e) ||
         (c >= 0x2066 && c <= 0x2069) || c == 0x200b || (c >= 0x2060 && c <= 0x2064) || c == 0xfeff ||
         (c >= 0xe0000 && c <= 0xe007f);
}

/// Whether `text` is UTF-8 without control characters, so that it can stand in every file and on every screen.
[[nodiscard]] inline bool is_plain(std::string_view text) {
  if (!utf8::is_valid(text.begin(), text.end())) return false;
  for (auto at = text.begin(); at != text.end();)
    if (is_control(utf8::unchecked::next(at))) return false;
  return true;
}

/// `text` for a terminal or a log: control characters and bytes that are not UTF-8 become \n, \t, \x1b, \u2028 …
[[nodiscard]] inline std::string printable(std::string_view text) {
  std::string shown;
  for (auto at = text.begin(); at != text.end();) {
    const auto start = at;
    char32_t c = 0;
    try {
      c = utf8::next(at, text.end());
    } catch (const utf8::exception&) {
      at = std::next(start);
      shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(*start));
      continue;
    }
    if (c == U'\n')
      shown += "\\n";
    else if (c == U'\t')
      shown += "\\t";
    else if (is_control(c))
      shown += c < 0x100 ? fmt::format("\\x{:02x}", unsigned(c)) : fmt::format("\\u{:04x}", unsigned(c));
    else
      shown.append(start, at);
  }
  return shown;
}

/// `text` as the plain text nearest to it, for a name that is not ours to refuse, such as that of a file: what cannot
/// stand becomes U+FFFD, the replacement character.
[[nodiscard]] inline std::string made_plain(std::string_view text) {
  std::string valid, plain;
  utf8::replace_invalid(text.begin(), text.end(), std::back_inserter(valid));
  for (auto at = valid.begin(); at != valid.end();) {
    const char32_t c = utf8::unchecked::next(at);
    utf8::append(is_control(c) ? char32_t(0xfffd) : c, std::back_inserter(plain));
  }
  return plain;
}

/// Enough of a UTF-8 text to know it by.
[[nodiscard]] inline std::string shortened(std::string text) {
  std::size_t longest = 80;
  if (text.size() <= longest) return text;
  while (longest > 0 && (text[longest] & 0xC0) == 0x80) --longest;  // not in the middle of a character
  return text.substr(0, longest) + " ...";
}

/// `text` as a name: plain, and cut where it is too long, at the end of a character.
[[nodiscard]] inline std::string made_name(std::string_view text) {
  std::string name = made_plain(text);
  std::size_t size = std::min(name.size(), max_name_bytes);
  while (size < name.size() && (name[size] & 0xC0) == 0x80) --size;
  name.resize(size);
  return name;
}

}  // namespace trame
