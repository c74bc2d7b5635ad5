#pragma once

// The rules of fields that people write (proto/field_rules.proto), read from the
// descriptors of their messages, and the check of a message against them.

#include <google/protobuf/message.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "proto/field_rules.pb.h"

namespace intaglio {

/// Both ends are allowed.
struct NumberRange {
  double min = 0;
  double max = 0;
};

/// An empty rule when the field has none.
const FieldRule& RuleOf(const google::protobuf::FieldDescriptor& field);

/// Nothing when the field has no range.
std::optional<NumberRange> FindRange(const google::protobuf::FieldDescriptor& field);

/// In the order of the schema.
std::vector<const google::protobuf::FieldDescriptor*> FieldsOf(
    const google::protobuf::Descriptor& message);

/// The field of a message by its number, as in
/// `FieldOf<Course>(Course::kSpeedMmSFieldNumber)`; throws when there is none.
const google::protobuf::FieldDescriptor& FieldOf(
    const google::protobuf::Descriptor& message, int number);

/// The member of a oneof that is set; nullptr: none. Throws when there is no such oneof.
const google::protobuf::FieldDescriptor* ChosenField(
    const google::protobuf::Message& message, const std::string& oneof);

/// The member of a oneof by its name; nullptr: none.
const google::protobuf::FieldDescriptor* FindChoice(
    const google::protobuf::Descriptor& message, const std::string& name);

template <typename Message>
const google::protobuf::FieldDescriptor& FieldOf(int number) {
  return FieldOf(*Message::descriptor(), number);
}

/// The range of a field that has one; throws when it has none.
NumberRange RangeOf(const google::protobuf::FieldDescriptor& field);

template <typename Message>
NumberRange RangeOf(int number) {
  return RangeOf(FieldOf<Message>(number));
}

/// A number outside the range of its field.
struct NumberFault {
  std::string field;  ///< its path, "models[0].copies.step_mm.x"
  Error error;        ///< kInvalidValue, "PATH: VALUE is outside MIN..MAX"
};

enum class AbsentMessages {
  kSkipped,  ///< a message that is absent has no faults
  kChecked,  ///< its numbers count as 0
};

/// One for each number of `message`, at any depth, that is outside its range. Paths start
/// with `path`. Numbers with presence are skipped when absent; the others are always
/// checked, so that a forgotten one shows as 0.
std::vector<NumberFault> NumbersOutOfRange(
    const google::protobuf::Message& message, const std::string& path,
    AbsentMessages absent = AbsentMessages::kSkipped);

/// "a.b", or "b" when a is empty.
std::string JoinPath(std::string_view path, std::string_view field);

}  // namespace intaglio
