#pragma once

#include <string>
#include <string_view>

namespace intaglio::materials_db {

/// HTML as plain text: tags dropped, <br> and <p> a new line, the usual entities decoded,
/// runs of white space made one space, none at a line's ends.
std::string TextFromHtml(std::string_view html);

/// Any text as HTML that TextFromHtml gives back unchanged.
std::string HtmlFromText(std::string_view text);

}  // namespace intaglio::materials_db
