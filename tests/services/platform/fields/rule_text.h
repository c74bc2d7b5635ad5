#pragma once

// The rule of a field as documents write it, and what a table of theirs holds of a field.

#include <google/protobuf/descriptor.h>

#include <string>

namespace intaglio {

/// "0.01..100"; empty when the field has no range.
std::string RangeText(const google::protobuf::FieldDescriptor& field);

/// "0.5", "true", "0 0 0" of a Vector3; empty when its rule has no fixed default.
std::string DefaultText(const google::protobuf::FieldDescriptor& field);

/// The cell of a table with the range and the default of its rule, and its other
/// words: a cell is right when this changes nothing. "0..1, default 0.5; of a mill".
std::string RuledCell(const google::protobuf::FieldDescriptor& field,
                      const std::string& cell);

}  // namespace intaglio
