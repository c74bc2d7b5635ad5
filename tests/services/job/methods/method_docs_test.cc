// docs/jobs.md has the table of methods as the rows make it. INTAGLIO_WRITE_GOLDEN=1
// writes it anew.

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#include "services/job/methods/method_table.h"
#include "services/job/model_kind.h"

namespace intaglio {
namespace {

using Member = google::protobuf::FieldDescriptor;

const std::string kDocument = INTAGLIO_SOURCE_DIR "/docs/jobs.md";
constexpr std::string_view kBegin =
    "<!-- Made from services/job/methods: INTAGLIO_WRITE_GOLDEN=1 job_test -->\n";
constexpr std::string_view kEnd = "<!-- End of what is made -->\n";

/// "`AXIS_Z`, `_X`, `_Y`": what all names begin with is written once.
std::string NamesIn(const google::protobuf::EnumDescriptor& type) {
  const std::string& first = type.value(0)->name();
  std::size_t common = first.size();
  for (int i = 1; i < type.value_count(); ++i) {
    const std::string& name = type.value(i)->name();
    std::size_t same = 0;
    while (same < common && same < name.size() && name[same] == first[same]) ++same;
    common = same;
  }
  common = first.rfind('_', common);
  std::string text = fmt::format("`{}`", first);
  for (int i = 1; i < type.value_count(); ++i) {
    text += fmt::format(", `{}`", type.value(i)->name().substr(common));
  }
  return text;
}

std::string NameIn(const MethodField& row, const Member& field) {
  std::string name(row.name);
  if (field.is_repeated()) name += "[]";
  if (field.message_type() == nullptr) return name;
  name += " {";
  for (int i = 0; i < field.message_type()->field_count(); ++i) {
    name += (i == 0 ? "" : " ") + field.message_type()->field(i)->name();
  }
  return name + "}";
}

std::string RangeOf(const MethodField& row, const Member& field) {
  if (row.range) return fmt::format("{}..{}", row.range->min, row.range->max);
  return field.enum_type() == nullptr ? "" : NamesIn(*field.enum_type());
}

std::string DefaultOf(const MethodField& row, const Member& field) {
  const FieldDefault& by_default = row.by_default;
  const bool is_bool = field.cpp_type() == Member::CPPTYPE_BOOL;
  switch (by_default.of) {
    case FieldDefault::Of::kMinSpacing:
      return "min. spacing";
    case FieldDefault::Of::kField:
      return fmt::format("{} times `{}`", by_default.factor, by_default.field);
    case FieldDefault::Of::kNumber:
      if (is_bool) return by_default.factor != 0 ? "true" : "false";
      return field.message_type() == nullptr
                 ? fmt::format("{}", by_default.factor)
                 : fmt::format("{0} {0} {0}", by_default.factor);
    case FieldDefault::Of::kNothing:
      break;
  }
  if (field.enum_type() != nullptr && !field.has_optional_keyword()) return "the first";
  return is_bool ? "false" : "none";
}

std::string KindsOf(const Method& method) {
  std::string text;
  for (const ModelKind kind : method.kinds) {
    text += (text.empty() ? "of " : " or ") + std::string(NameOf(kind));
  }
  return text + (method.default_of.empty() ? "" : ", its default");
}

std::string Table() {
  std::string table =
      "| field | range | default | option | meaning |\n|---|---|---|---|---|\n";
  for (const Method& method : Methods()) {
    table += fmt::format("| `{0}` | {1} | | `--method {0}` | {2} |\n", method.name(),
                         KindsOf(method), method.meaning);
    for (const MethodField& row : method.fields) {
      const Member& field = *method.message().FindFieldByName(std::string(row.name));
      const std::string range = RangeOf(row, field);
      table += fmt::format("| `.{}` |{}| {} | `{}` | {} |\n", NameIn(row, field),
                           range.empty() ? " " : " " + range + " ", DefaultOf(row, field),
                           row.option, row.meaning);
    }
  }
  return table;
}

/// Where two texts differ first: both lines; empty when they are the same.
std::string FirstDifference(const std::string& written, const std::string& made) {
  std::istringstream written_lines(written), made_lines(made);
  for (;;) {
    std::string one, other;
    const bool more = static_cast<bool>(std::getline(written_lines, one));
    if (static_cast<bool>(std::getline(made_lines, other)) != more || one != other) {
      return fmt::format("written: {}\nmade:    {}", one, other);
    }
    if (!more) return "";
  }
}

TEST(MethodDocs, AreWhatTheTableMakes) {
  std::ifstream in(kDocument);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const auto begin = text.find(kBegin), end = text.find(kEnd);
  ASSERT_TRUE(begin != text.npos && end != text.npos && begin < end)
      << "docs/jobs.md: the two comments around the table of methods are missing";
  const auto from = begin + kBegin.size();
  if (std::getenv("INTAGLIO_WRITE_GOLDEN") != nullptr) {
    text.replace(from, end - from, Table());
    std::ofstream(kDocument) << text;
    return;
  }
  EXPECT_EQ(FirstDifference(text.substr(from, end - from), Table()), "")
      << "INTAGLIO_WRITE_GOLDEN=1 writes docs/jobs.md anew";
}

}  // namespace
}  // namespace intaglio
