#pragma once

// The page of a preview: one HTML file without scripts and without anything to load, the
// pictures inside, for a browser, a console or an e-mail.

#include <string>
#include <string_view>

#include "services/client/preview/preview.h"

namespace intaglio::client {

/// The same preview gives the same bytes.
std::string PageOf(const Preview& preview);

/// Text as it is written into HTML: & < > " and ' replaced.
std::string HtmlOf(std::string_view text);

}  // namespace intaglio::client
