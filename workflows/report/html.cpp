#include "workflows/report/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

namespace trame::workflows {

namespace {

constexpr std::string_view style = R"(
:root { --ink: #1d2733; --soft: #5b6775; --line: #d5dbe2; }
body { font: 15px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; color: var(--ink); background: #fff;
       max-width: 1080px; margin: 2rem auto; padding: 0 1.5rem; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .3rem; }
h2 { font-size: 1.3rem; margin: 2.6rem 0 .6rem; padding-bottom: .2rem; border-bottom: 2px solid var(--line); }
h3 { font-size: 1.05rem; margin: 1.6rem 0 .4rem; }
p { max-width: 52rem; margin: .5rem 0; }
.subtitle { color: var(--soft); margin-bottom: 1rem; }
nav { font-size: .9rem; } nav li { margin: 0; } a { color: #2f6ca8; }
.note { background: #fdf6e3; border-left: 4px solid #d9a520; padding: .4rem .8rem; }
figure { margin: 1rem 0 1.6rem; break-inside: avoid; }
figcaption { color: var(--soft); font-size: .87rem; max-width: 58rem; margin-top: .4rem; }
img { max-width: 100%; height: auto; }
svg { display: block; }
sub { line-height: 0; }
table.text th, table.text td:nth-child(-n + 3) { white-space: nowrap; }
svg text { font-family: inherit; }
.pictures-row { display: grid; grid-template-columns: repeat(4, 1fr); gap: 1rem; align-items: end; }
.pictures-row > figure { margin: 0; }
.pictures-row svg { max-width: 100%; height: auto; }
.pictures-grid { display: grid; grid-template-columns: 1fr 1fr; gap: 1rem; align-items: end; }
.pictures-grid > figure { margin: 0; } .pictures-grid > .wide { grid-column: 1 / -1; }
.wide img { max-height: 34rem; }
table { border-collapse: collapse; margin: .8rem 0; font-size: .87rem; font-variant-numeric: tabular-nums; }
th, td { padding: .22rem .6rem; border-bottom: 1px solid var(--line); text-align: left; vertical-align: top; }
thead th { color: var(--soft); font-weight: 600; vertical-align: bottom; border-bottom: 2px solid var(--line); }
table.numbers td { text-align: right; white-space: nowrap; }
table.numbers thead th:not(:first-child) { text-align: right; }
table.pictures th, table.pictures td { border: 0; padding: .15rem .3rem; vertical-align: middle; text-align: center; }
table.pictures td svg { margin: 0 auto; }
table.pictures tbody th { text-align: left; color: var(--soft); font-weight: 600; white-space: nowrap; }
tr { break-inside: avoid; }
.strip { display: flex; flex-wrap: wrap; gap: .8rem .6rem; align-items: flex-end; }
.strip > div { text-align: center; font-size: .76rem; line-height: 1.3; color: var(--soft); }
.badge { border-radius: .6em; padding: .05em .6em; color: #fff; white-space: nowrap; print-color-adjust: exact;
         -webkit-print-color-adjust: exact; }
.good { background: #2e7d4f; } .fair { background: #b07a10; } .bad { background: #b23a32; }
.none { background: #7b8591; }
details pre { font-size: .8rem; line-height: 1.35; background: #f5f7f9; padding: .8rem; overflow-x: auto; }
summary { cursor: pointer; color: #2f6ca8; }
@media print { body { margin: 0; max-width: none; font-size: 11px; } h2, h3, h4 { break-after: avoid; } }
)";

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

std::string paragraph(const std::string& content) { return "<p>" + content + "</p>\n"; }

std::string note(const std::string& content) { return "<p class=\"note\">" + content + "</p>\n"; }

std::string section(const std::string& id, const std::string& title, const std::string& content) {
  return fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n{}</section>\n", id, title, content);
}

std::string table(const HtmlTable& table) {
  std::string text = fmt::format("<table class=\"{}\">\n", table.kind);
  if (!table.header.empty()) text += "<thead>" + cells(table.header, true) + "</thead>\n";
  text += "<tbody>\n";
  for (const auto& row : table.rows) text += cells(row, false);
  return text + "</tbody>\n</table>\n";
}

std::string page(const std::string& title, const std::string& content) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width\">\n<title>{}</title>\n<style>{}</style>\n</head>\n"
      "<body>\n{}</body>\n</html>\n",
      escaped(title), style, content);
}

}  // namespace trame::workflows
