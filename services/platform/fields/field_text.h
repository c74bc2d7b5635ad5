#pragma once

// The rule of a field as texts write it: --help, documents, schemas.

#include <google/protobuf/descriptor.h>

#include <string>

namespace intaglio {

/// "0.01..100"; empty when the field has no range.
std::string RangeText(const google::protobuf::FieldDescriptor& field);

/// "0.5", "true", "0 0 0" of a Vector3; empty when its rule has no fixed default.
std::string DefaultText(const google::protobuf::FieldDescriptor& field);

}  // namespace intaglio
