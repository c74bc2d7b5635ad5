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

#include "services/job/convert/model_kind.h"
#include "services/job/methods/method_table.h"
#include "services/platform/fields/field_rules.h"
#include "services/platform/fields/field_text.h"
#include "tests/services/platform/fields/rule_text.h"

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

std::string NameIn(const Member& field) {
  std::string name = field.name();
  if (field.is_repeated()) name += "[]";
  if (field.message_type() == nullptr) return name;
  name += " {";
  for (int i = 0; i < field.message_type()->field_count(); ++i) {
    name += (i == 0 ? "" : " ") + field.message_type()->field(i)->name();
  }
  return name + "}";
}

std::string AllowedText(const Member& field) {
  return field.enum_type() == nullptr ? RangeText(field) : NamesIn(*field.enum_type());
}

std::string AbsentText(const Member& field) {
  const FieldRule& rule = RuleOf(field);
  if (rule.default_field() == "min_spacing_mm") return "min. spacing";
  if (!rule.default_field().empty())
    return fmt::format("{} times `{}`", rule.default_ratio(), rule.default_field());
  if (rule.has_default_value()) return DefaultText(field);
  if (field.enum_type() != nullptr && !field.has_optional_keyword()) return "the first";
  return field.cpp_type() == Member::CPPTYPE_BOOL ? "false" : "none";
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
    for (const Member* field : FieldsOf(method.message())) {
      const std::string range = AllowedText(*field);
      table += fmt::format("| `.{}` |{}| {} | `{}` | {} |\n", NameIn(*field),
                           range.empty() ? " " : " " + range + " ", AbsentText(*field),
                           RuleOf(*field).option(), RuleOf(*field).meaning());
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
