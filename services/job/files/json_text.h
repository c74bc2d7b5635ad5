#pragma once

#include <google/protobuf/message.h>

#include <string>

#include "engrave/core/result.h"

namespace intaglio {

enum class JsonLayout { kLines, kOneLine };

/// A message for programs: field names as in the .proto, fields without a value too.
/// kInvalidValue for text that is not UTF-8.
Result<std::string> JsonTextOf(const google::protobuf::Message& message,
                               JsonLayout layout = JsonLayout::kLines);

}  // namespace intaglio
