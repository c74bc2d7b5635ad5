#include "services/job/methods/method_table.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>

#include "engrave/core/check.h"
#include "services/platform/fields/field_rules.h"

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
  const auto* field = ChosenField(holder, "method");
  return field == nullptr ? nullptr : FindMethod(field->name());
}

const pb::FieldDescriptor* FieldInDiscretization(const Method& method) {
  return FindChoice(*Discretization::descriptor(), method.name());
}

const pb::Message& MessageOf(const Method& method, const pb::Message& holder) {
  return holder.GetReflection()->GetMessage(holder, &FieldIn(holder, method));
}

pb::Message& MutableMessageOf(const Method& method, pb::Message& holder) {
  return *holder.GetReflection()->MutableMessage(&holder, &FieldIn(holder, method));
}

}  // namespace intaglio
