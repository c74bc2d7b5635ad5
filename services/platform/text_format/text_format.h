#pragma once

// Protobuf's text format, read with an error that names the place and the field that was
// meant.

#include <google/protobuf/message.h>

#include <cstddef>
#include <string>
#include <string_view>

#include "engrave/core/result.h"

namespace intaglio {

/// kTooLarge: "NAME: is larger than N bytes; give WHAT".
Status CheckTextSize(std::string_view text, const std::string& name,
                     std::size_t max_bytes, const char* what);

/// kUnreadable: "NAME: is in UTF-16; save it as UTF-8", of a text with the byte order
/// mark of UTF-16, which some editors and shells of Windows write.
Status CheckTextCode(std::string_view text, const std::string& name);

/// A byte order mark of UTF-8 is skipped. kUnreadable: as CheckTextCode(), or
/// "NAME:line:column: what is wrong. Did you mean glass?"; an unknown field is an error.
/// `max_depth`: how deep messages may nest.
Status ParseTextFormat(std::string_view text, const std::string& name, int max_depth,
                       google::protobuf::Message& message);

}  // namespace intaglio
