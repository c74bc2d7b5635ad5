#pragma once

// Finds the place of an error in a JSON text that protobuf's parser refused. The parser
// reports either an excerpt with a caret (wrong syntax) or the path of a field (wrong
// value, unknown field).

#include <string>
#include <string_view>

namespace intaglio {

/// "line:column: what went wrong", both counted from 1; without position " what ..." when
/// the place is not known.
std::string LocateJsonError(std::string_view text, const std::string& parser_message);

}  // namespace intaglio
