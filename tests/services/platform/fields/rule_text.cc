#include "tests/services/platform/fields/rule_text.h"

#include <fmt/format.h>

#include <regex>

#include "services/platform/fields/field_text.h"

namespace intaglio {
namespace {

using Field = google::protobuf::FieldDescriptor;

const std::regex kRange(R"((-?\d[\d.]*(?:e-?\d+)?)\.\.(-?\d[\d.]*\d|-?\d))");
const std::regex kDefault(R"(default:? (-?\d[\d.]*\d|-?\d|true|false)(?![\d.]| of))");

/// What an absent field is without a rule: a document may write it or not.
bool IsImpliedByAbsence(const Field& field, const std::string& value) {
  if (field.has_presence() && field.cpp_type() != Field::CPPTYPE_BOOL) return false;
  return value == (field.cpp_type() == Field::CPPTYPE_BOOL ? "false" : "0");
}

}  // namespace

std::string RuledCell(const Field& field, const std::string& cell) {
  std::string ruled = cell;
  const std::string range = RangeText(field);
  if (std::smatch written; std::regex_search(ruled, written, kRange)) {
    ruled.replace(static_cast<std::size_t>(written.position()), written.str().size(),
                  range);
  } else if (!range.empty()) {
    ruled = ruled.empty() ? range : range + ", " + ruled;
  }
  const std::string value = DefaultText(field);
  std::smatch written;
  if (std::regex_search(ruled, written, kDefault)) {
    if (value.empty() && IsImpliedByAbsence(field, written[1])) return ruled;
    ruled.replace(static_cast<std::size_t>(written.position()), written.str().size(),
                  value.empty() ? "" : "default " + value);
  } else if (!value.empty() && field.has_presence()) {
    ruled += (ruled.empty() ? "default " : ", default ") + value;
  }
  return ruled;
}

}  // namespace intaglio
