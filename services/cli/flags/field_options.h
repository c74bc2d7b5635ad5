#pragma once

// Options of the command line that follow from the rules beside fields.

#include <google/protobuf/descriptor.h>

#include <string>
#include <string_view>

#include "services/platform/command_line/program.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio::cli {

/// "mm" by the end of a field's name; empty when it has no unit.
std::string UnitText(std::string_view field_name);

/// What --help says of a field: its meaning, its unit and its fixed default.
std::string FieldHelp(const google::protobuf::FieldDescriptor& field);

/// Adds the option of a field that has one, which takes what its range permits. Value: as
/// of AddOption; of a whole number it takes whole ones alone.
template <typename Value>
command_line::Option AddFieldOption(command_line::Command command,
                                    const google::protobuf::FieldDescriptor& field,
                                    Value& value) {
  const auto option = command.AddOption(RuleOf(field).option(), value, FieldHelp(field));
  const auto range = FindRange(field);
  if (!range) return option;
  if (field.cpp_type() == google::protobuf::FieldDescriptor::CPPTYPE_UINT32) {
    return option.Within(static_cast<int>(range->min), static_cast<int>(range->max));
  }
  return option.Within(range->min, range->max);
}

}  // namespace intaglio::cli
