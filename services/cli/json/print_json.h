#pragma once

#include <google/protobuf/message.h>

namespace intaglio::cli {

/// The message for programs, on the standard output; the exit code of a command that does
/// nothing else: 0, or 2 for a text that is not UTF-8.
int PrintJson(const google::protobuf::Message& message);

}  // namespace intaglio::cli
