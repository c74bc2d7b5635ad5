#pragma once

// Fills in what a message leaves out, by the rules of its fields (FieldRule.default_value
// and default_field). Values that are given stay as they are, right or wrong.

#include <google/protobuf/message.h>

#include <initializer_list>
#include <string_view>

#include "services/platform/fields/field_rules.h"

namespace intaglio {

/// A number that default_field may name beside the fields of the message itself.
struct NamedNumber {
  std::string_view name;
  double value = 0;
};

/// Fills in every field of the message itself that is absent and has a default, in the
/// order of the schema; of an absent number in `known` that is 0, nothing follows.
void FillDefaults(google::protobuf::Message& message, NamedNumber known = {});

/// Fills in these fields alone, by their numbers; each has a default_value.
void FillDefaults(google::protobuf::Message& message, std::initializer_list<int> numbers);

/// The default_value of a field that has one; throws when it has none.
double DefaultOf(const google::protobuf::FieldDescriptor& field);

template <typename Message>
double DefaultOf(int number) {
  return DefaultOf(FieldOf<Message>(number));
}

}  // namespace intaglio
