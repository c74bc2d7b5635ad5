#include "services/platform/fields/field_rules.h"

#include <fmt/format.h>

#include <utility>

#include "engrave/core/check.h"
#include "proto/job.pb.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;

/// Of a message that `number` is a member of; the index is that in a repeated field.
double ReadNumber(const pb::Message& message, const pb::FieldDescriptor& field,
                  int index) {
  const pb::Reflection& reflection = *message.GetReflection();
  const bool repeated = field.is_repeated();
  switch (field.cpp_type()) {
    case pb::FieldDescriptor::CPPTYPE_UINT32:
      return repeated ? reflection.GetRepeatedUInt32(message, &field, index)
                      : reflection.GetUInt32(message, &field);
    case pb::FieldDescriptor::CPPTYPE_INT32:
      return repeated ? reflection.GetRepeatedInt32(message, &field, index)
                      : reflection.GetInt32(message, &field);
    default:
      return repeated ? reflection.GetRepeatedDouble(message, &field, index)
                      : reflection.GetDouble(message, &field);
  }
}

class Checker {
 public:
  explicit Checker(AbsentMessages absent) : absent_(absent) {}

  void CheckMessage(const pb::Message& message, const std::string& path) {
    const pb::Descriptor& type = *message.GetDescriptor();
    const pb::Reflection& reflection = *message.GetReflection();
    for (int i = 0; i < type.field_count(); ++i) {
      const pb::FieldDescriptor& field = *type.field(i);
      const std::string at = JoinPath(path, field.name());
      if (field.is_repeated()) {
        for (int k = 0; k < reflection.FieldSize(message, &field); ++k)
          CheckElement(message, field, k, fmt::format("{}[{}]", at, k));
      } else if (IsChecked(message, field)) {
        CheckElement(message, field, 0, at);
      }
    }
  }

  std::vector<NumberFault> TakeFaults() { return std::move(faults_); }

 private:
  bool IsChecked(const pb::Message& message, const pb::FieldDescriptor& field) const {
    if (!field.has_presence() || message.GetReflection()->HasField(message, &field))
      return true;
    return field.message_type() != nullptr && absent_ == AbsentMessages::kChecked;
  }

  void CheckElement(const pb::Message& message, const pb::FieldDescriptor& field,
                    int index, const std::string& path) {
    const auto range = FindRange(field);
    if (field.message_type() == nullptr) {
      if (range) CheckNumber(ReadNumber(message, field, index), *range, path);
      return;
    }
    const pb::Reflection& reflection = *message.GetReflection();
    const pb::Message& child = field.is_repeated()
                                   ? reflection.GetRepeatedMessage(message, &field, index)
                                   : reflection.GetMessage(message, &field);
    const auto* vector = dynamic_cast<const Vector3*>(&child);
    if (vector == nullptr || !range) return CheckMessage(child, path);
    CheckNumber(vector->x(), *range, path + ".x");
    CheckNumber(vector->y(), *range, path + ".y");
    CheckNumber(vector->z(), *range, path + ".z");
  }

  void CheckNumber(double value, NumberRange range, const std::string& path) {
    if (value >= range.min && value <= range.max) return;  // false for NaN
    faults_.push_back(
        {path,
         {ErrorCode::kInvalidValue,
          fmt::format("{}: {} is outside {}..{}", path, value, range.min, range.max),
          fmt::format("{}", value)}});
  }

  AbsentMessages absent_;
  std::vector<NumberFault> faults_;
};

}  // namespace

const FieldRule& RuleOf(const pb::FieldDescriptor& field) {
  return field.options().GetExtension(rules);
}

std::optional<NumberRange> FindRange(const pb::FieldDescriptor& field) {
  const FieldRule& rule = RuleOf(field);
  if (!rule.has_min() || !rule.has_max()) return std::nullopt;
  return NumberRange{rule.min(), rule.max()};
}

std::vector<const pb::FieldDescriptor*> FieldsOf(const pb::Descriptor& message) {
  std::vector<const pb::FieldDescriptor*> fields;
  for (int i = 0; i < message.field_count(); ++i) fields.push_back(message.field(i));
  return fields;
}

const pb::FieldDescriptor& FieldOf(const pb::Descriptor& message, int number) {
  const pb::FieldDescriptor* field = message.FindFieldByNumber(number);
  Require(field != nullptr, "{} has no field {}", message.name(), number);
  return *field;
}

const pb::FieldDescriptor* ChosenField(const pb::Message& message,
                                       const std::string& oneof) {
  const pb::OneofDescriptor* choices = message.GetDescriptor()->FindOneofByName(oneof);
  Require(choices != nullptr, "{} has no choice {}", message.GetTypeName(), oneof);
  return message.GetReflection()->GetOneofFieldDescriptor(message, choices);
}

const pb::FieldDescriptor* FindChoice(const pb::Descriptor& message,
                                      const std::string& name) {
  const pb::FieldDescriptor* field = message.FindFieldByName(name);
  return field != nullptr && field->real_containing_oneof() != nullptr ? field : nullptr;
}

NumberRange RangeOf(const pb::FieldDescriptor& field) {
  const auto range = FindRange(field);
  Require(range.has_value(), "{} has no range", field.full_name());
  return *range;
}

std::string JoinPath(std::string_view path, std::string_view field) {
  return path.empty() ? std::string(field) : fmt::format("{}.{}", path, field);
}

std::vector<NumberFault> NumbersOutOfRange(const pb::Message& message,
                                           const std::string& path,
                                           AbsentMessages absent) {
  Checker checker(absent);
  checker.CheckMessage(message, path);
  return checker.TakeFaults();
}

}  // namespace intaglio
