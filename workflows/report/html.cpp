#include "workflows/report/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <kainjow/mustache.hpp>
#include <stdexcept>
#include <utility>

#include "page_templates.h"

namespace trame::workflows {

namespace {

namespace mustache = kainjow::mustache;

mustache::data data_of(const Fields& fields) {
  mustache::data data;
  for (const auto& [name, value] : fields)
    if (const bool* shown = std::get_if<bool>(&value))
      data.set(name, *shown ? mustache::data::type::bool_true : mustache::data::type::bool_false);
    else if (const std::string* text = std::get_if<std::string>(&value))
      data.set(name, *text);
    else {
      mustache::data list(mustache::data::type::list);
      for (const Fields& one : std::get<std::vector<Fields>>(value)) list.push_back(data_of(one));
      data.set(name, list);
    }
  return data;
}

std::string cells(const std::vector<std::string>& row, bool all_headings) {
  std::string text = "<tr>";
  for (std::size_t i = 0; i < row.size(); ++i) {
    const char* tag = all_headings || i == 0 ? "th" : "td";
    text += fmt::format("<{0}>{1}</{0}>", tag, row[i]);
  }
  return text + "</tr>\n";
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) switch (c) {
      case '&': result += "&amp;"; break;
      case '<': result += "&lt;"; break;
      case '>': result += "&gt;"; break;
      case '"': result += "&quot;"; break;
      case '\'': result += "&#39;"; break;
      default: result += c;
    }
  return result;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string result;
  result.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < n ? static_cast<unsigned char>(bytes[i + k]) : std::uint32_t(0));
    for (std::size_t k = 0; k < 4; ++k) result += k <= n ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return result;
}

std::string inline_image(std::string_view bytes, std::string_view mime_type, std::string_view alternative) {
  return fmt::format("<img alt=\"{}\" src=\"data:{};base64,{}\">", escaped(alternative), mime_type, base64(bytes));
}

std::string figure(const std::string& content, const std::string& caption, const char* kind) {
  return fmt::format("<figure class=\"{}\">\n{}\n<figcaption>{}</figcaption>\n</figure>\n", kind, content, caption);
}

std::string note(const std::string& content) { return "<p class=\"note\">" + content + "</p>\n"; }

std::string table(const HtmlTable& table) {
  std::string text = fmt::format("<table class=\"{}\">\n", table.kind);
  if (!table.header.empty()) text += "<thead>" + cells(table.header, true) + "</thead>\n";
  text += "<tbody>\n";
  for (const auto& row : table.rows) text += cells(row, false);
  return text + "</tbody>\n</table>\n";
}

std::string filled(std::string_view name, const Fields& fields) {
  mustache::mustache page{std::string(page_files.at(fmt::format("{}.mustache", name)))};
  page.set_custom_escape(escaped);
  std::string text = page.render(data_of(fields));
  if (!page.error_message().empty()) throw std::logic_error(fmt::format("template {}: {}", name, page.error_message()));
  return text;
}

std::string_view style() { return page_files.at("style.css"); }

}  // namespace trame::workflows
