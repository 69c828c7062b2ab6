#pragma once
/// \file
/// Pieces of a web page that needs nothing but itself: style and pictures are inside, and there are no scripts.

#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace trame::workflows {

/// The text with &, <, > and quotes written as HTML wants them.
[[nodiscard]] std::string escaped(std::string_view text);

/// RFC 4648, with padding.
[[nodiscard]] std::string base64(std::string_view bytes);

/// A picture of that MIME type, image/png or image/svg+xml, inside the page.
[[nodiscard]] std::string inline_image(std::string_view bytes, std::string_view mime_type,
                                       std::string_view alternative);

/// In all that follows, content is HTML and captions are too; `kind` is a CSS class.
[[nodiscard]] std::string figure(const std::string& content, const std::string& caption, const char* kind = "");
/// Something that the report cannot show, and why.
[[nodiscard]] std::string note(const std::string& content);
/// First cells of rows are their headings. Rows may be shorter than the header.
struct HtmlTable {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
  std::string kind = "numbers";  ///< CSS class: numbers (aligned right), text, or pictures
};
[[nodiscard]] std::string table(const HtmlTable& table);

/// What fills a field of a template: text, whether a part is there, or a part for each of a list.
struct Fields;
using Field = std::variant<std::string, bool, std::vector<Fields>>;
struct Fields : std::vector<std::pair<std::string, Field>> {
  using vector::vector;
};

/// page/NAME.mustache with its fields filled in: {{text}} is escaped, {{{HTML}}} is not.
[[nodiscard]] std::string filled(std::string_view name, const Fields& fields = {});

/// The style sheet of the page.
[[nodiscard]] std::string_view style();

}  // namespace trame::workflows
