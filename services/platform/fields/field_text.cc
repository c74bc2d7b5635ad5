#include "services/platform/fields/field_text.h"

#include <fmt/format.h>

#include <array>
#include <charconv>

#include "proto/job.pb.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio {

using Field = google::protobuf::FieldDescriptor;

namespace {

/// Without an exponent: "0.000001".
std::string Plain(double value) {
  std::array<char, 400> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::fixed);
  return {text.data(), end.ptr};
}

}  // namespace

std::string RangeText(const Field& field) {
  const auto range = FindRange(field);
  return range ? Plain(range->min) + ".." + Plain(range->max) : "";
}

std::string DefaultText(const Field& field) {
  const FieldRule& rule = RuleOf(field);
  if (!rule.has_default_value()) return "";
  if (field.cpp_type() == Field::CPPTYPE_BOOL)
    return rule.default_value() != 0 ? "true" : "false";
  if (field.message_type() == Vector3::descriptor())
    return fmt::format("{0} {0} {0}", Plain(rule.default_value()));
  return Plain(rule.default_value());
}

}  // namespace intaglio
