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

/// kUnreadable: "NAME:line:column: what is wrong. Did you mean glass?"; an unknown field
/// is an error. `max_depth`: how deep messages may nest.
Status ParseTextFormat(std::string_view text, const std::string& name, int max_depth,
                       google::protobuf::Message& message);

}  // namespace intaglio
