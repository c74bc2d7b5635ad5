#include "services/job/methods/method_table.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cstdint>

#include "engrave/core/check.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;

std::vector<Method> MakeTable() {
  std::vector<Method> table = MeshMethods();
  for (auto part : {DrawingMethods(), PictureMethods()}) {
    table.insert(table.end(), part.begin(), part.end());
  }
  return table;
}

bool IsThere(const pb::Message& message, const pb::FieldDescriptor& field) {
  const pb::Reflection& reflection = *message.GetReflection();
  return field.is_repeated() ? reflection.FieldSize(message, &field) > 0
                             : reflection.HasField(message, &field);
}

double ValueOf(const FieldDefault& by_default, double min_spacing_mm,
               const pb::Message& message) {
  switch (by_default.of) {
    case FieldDefault::Of::kMinSpacing:
      return by_default.factor * min_spacing_mm;
    case FieldDefault::Of::kField: {
      const auto* field =
          message.GetDescriptor()->FindFieldByName(std::string(by_default.field));
      return by_default.factor * message.GetReflection()->GetDouble(message, field);
    }
    default:
      return by_default.factor;
  }
}

void Set(pb::Message& message, const pb::FieldDescriptor& field, double value) {
  const pb::Reflection& reflection = *message.GetReflection();
  if (field.cpp_type() == pb::FieldDescriptor::CPPTYPE_BOOL) {
    reflection.SetBool(&message, &field, value != 0);
  } else if (field.cpp_type() == pb::FieldDescriptor::CPPTYPE_UINT32) {
    reflection.SetUInt32(&message, &field, static_cast<std::uint32_t>(value));
  } else if (field.message_type() == Vector3::descriptor()) {
    auto& vector = dynamic_cast<Vector3&>(*reflection.MutableMessage(&message, &field));
    vector.set_x(value), vector.set_y(value), vector.set_z(value);
  } else if (field.is_repeated()) {
    reflection.AddDouble(&message, &field, value);
  } else {
    reflection.SetDouble(&message, &field, value);
  }
}

const pb::FieldDescriptor& FieldIn(const pb::Message& holder, const Method& method) {
  const auto* field = holder.GetDescriptor()->FindFieldByName(method.name());
  Require(field != nullptr, "{} cannot have the method {}", holder.GetTypeName(),
          method.name());
  return *field;
}

}  // namespace

const pb::FieldDescriptor& Method::field() const {
  const auto* found = Model::descriptor()->FindFieldByNumber(number);
  Require(found != nullptr, "Model.method has no member of number {}", number);
  return *found;
}

const pb::Descriptor& Method::message() const { return *field().message_type(); }

const std::string& Method::name() const { return field().name(); }

bool Method::Suits(ModelKind kind) const {
  return std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
}

std::span<const Method> Methods() {
  static const std::vector<Method> kTable = MakeTable();
  return kTable;
}

const Method* FindMethod(std::string_view name) {
  for (const Method& method : Methods()) {
    if (method.name() == name) return &method;
  }
  return nullptr;
}

const Method* DefaultMethodOf(ModelKind kind) {
  for (const Method& method : Methods()) {
    const auto& of = method.default_of;
    if (std::find(of.begin(), of.end(), kind) != of.end()) return &method;
  }
  return nullptr;
}

const Method* MethodOf(const pb::Message& holder) {
  const auto* choice = holder.GetDescriptor()->FindOneofByName("method");
  Require(choice != nullptr, "{} holds no method", holder.GetTypeName());
  const auto* field = holder.GetReflection()->GetOneofFieldDescriptor(holder, choice);
  return field == nullptr ? nullptr : FindMethod(field->name());
}

const pb::FieldDescriptor* FieldInDiscretization(const Method& method) {
  const auto* field = Discretization::descriptor()->FindFieldByName(method.name());
  return field != nullptr && field->real_containing_oneof() != nullptr ? field : nullptr;
}

const pb::Message& MessageOf(const Method& method, const pb::Message& holder) {
  return holder.GetReflection()->GetMessage(holder, &FieldIn(holder, method));
}

pb::Message& MutableMessageOf(const Method& method, pb::Message& holder) {
  return *holder.GetReflection()->MutableMessage(&holder, &FieldIn(holder, method));
}

void FillDefaults(const Method& method, double min_spacing_mm, pb::Message& message) {
  for (const MethodField& row : method.fields) {
    const auto& field = *method.message().FindFieldByName(std::string(row.name));
    if (row.by_default.of == FieldDefault::Of::kNothing || IsThere(message, field)) {
      continue;
    }
    const double value = ValueOf(row.by_default, min_spacing_mm, message);
    // A job without a minimum spacing is refused for that, not for what follows of it.
    if (value == 0 && row.by_default.factor != 0) continue;
    Set(message, field, value);
  }
}

}  // namespace intaglio
