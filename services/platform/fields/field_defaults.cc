#include "services/platform/fields/field_defaults.h"

#include <cstdint>
#include <optional>

#include "engrave/core/check.h"
#include "proto/job.pb.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;

bool IsThere(const pb::Message& message, const pb::FieldDescriptor& field) {
  const pb::Reflection& reflection = *message.GetReflection();
  return field.is_repeated() ? reflection.FieldSize(message, &field) > 0
                             : reflection.HasField(message, &field);
}

void Set(pb::Message& message, const pb::FieldDescriptor& field, double value) {
  const pb::Reflection& reflection = *message.GetReflection();
  if (field.cpp_type() == pb::FieldDescriptor::CPPTYPE_BOOL) {
    reflection.SetBool(&message, &field, value != 0);
  } else if (field.cpp_type() == pb::FieldDescriptor::CPPTYPE_UINT32) {
    const auto whole = static_cast<std::uint32_t>(value);
    field.is_repeated() ? reflection.AddUInt32(&message, &field, whole)
                        : reflection.SetUInt32(&message, &field, whole);
  } else if (field.message_type() == Vector3::descriptor()) {
    auto& vector = dynamic_cast<Vector3&>(
        field.is_repeated() ? *reflection.AddMessage(&message, &field)
                            : *reflection.MutableMessage(&message, &field));
    vector.set_x(value), vector.set_y(value), vector.set_z(value);
  } else if (field.is_repeated()) {
    reflection.AddDouble(&message, &field, value);
  } else {
    reflection.SetDouble(&message, &field, value);
  }
}

/// The multiple of another number; nothing when that is 0: a job without a minimum
/// spacing is refused for that, not for what follows from it.
std::optional<double> Multiple(const FieldRule& rule, const pb::Message& message,
                               NamedNumber known) {
  const double ratio = rule.has_default_ratio() ? rule.default_ratio() : 1;
  double base = known.value;
  if (rule.default_field() != known.name) {
    const auto* field = message.GetDescriptor()->FindFieldByName(rule.default_field());
    Require(field != nullptr, "{} has no field {}", message.GetTypeName(),
            rule.default_field());
    base = message.GetReflection()->GetDouble(message, field);
  }
  if (base == 0) return std::nullopt;
  return ratio * base;
}

}  // namespace

void FillDefaults(pb::Message& message, NamedNumber known) {
  const pb::Descriptor& type = *message.GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    const pb::FieldDescriptor& field = *type.field(i);
    const FieldRule& rule = RuleOf(field);
    const bool can_be_absent = field.is_repeated() || field.has_presence();
    if (!can_be_absent || IsThere(message, field)) continue;
    if (rule.has_default_value()) {
      Set(message, field, rule.default_value());
    } else if (!rule.default_field().empty()) {
      if (const auto value = Multiple(rule, message, known)) Set(message, field, *value);
    }
  }
}

void FillDefaults(pb::Message& message, std::initializer_list<int> numbers) {
  for (const int number : numbers) {
    const pb::FieldDescriptor& field = FieldOf(*message.GetDescriptor(), number);
    if (!IsThere(message, field)) Set(message, field, DefaultOf(field));
  }
}

double DefaultOf(const pb::FieldDescriptor& field) {
  Require(RuleOf(field).has_default_value(), "{} has no default", field.full_name());
  return RuleOf(field).default_value();
}

}  // namespace intaglio
