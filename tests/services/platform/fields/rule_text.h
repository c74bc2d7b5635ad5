#pragma once

// What a table of the documents holds of a field, by its rule.

#include <google/protobuf/descriptor.h>

#include <string>

namespace intaglio {

/// The cell of a table with the range and the default of its rule, and its other
/// words: a cell is right when this changes nothing. "0..1, default 0.5; of a mill".
std::string RuledCell(const google::protobuf::FieldDescriptor& field,
                      const std::string& cell);

}  // namespace intaglio
