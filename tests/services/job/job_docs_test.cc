// The tables of docs/jobs.md have every field of a job but those of methods, whose table
// is made (method_docs_test.cc), each with the range and the default of its rule.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "proto/job.pb.h"
#include "services/job/methods/method_table.h"
#include "services/platform/fields/field_rules.h"
#include "services/platform/fields/field_text.h"
#include "tests/services/platform/fields/rule_text.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;
using JobField = pb::FieldDescriptor;

struct Row {
  std::vector<std::string> names;  ///< "..count_x", "count_y"
  std::string range, by_default;
};

std::vector<Row> RowsOfPage() {
  static const std::regex kRow(
      R"(^\| (`[^|]+`) \| ?([^|]*?) ?\| ?([^|]*?) ?\|[^|]*(?:\|[^|]*)?\|$)");
  static const std::regex kName(R"(`([\w.\[\]]+)(?: \{[^`]*\})?`)");
  std::vector<Row> rows;
  std::ifstream page(INTAGLIO_SOURCE_DIR "/docs/jobs.md");
  bool in_table = false;
  for (std::string line; std::getline(page, line);) {
    if (!line.starts_with("|")) in_table = false;
    if (line == "| field | range | default | meaning |") in_table = true;
    std::smatch match;
    if (!in_table || !std::regex_search(line, match, kRow)) continue;
    const std::string cell = match[1];
    Row row{{}, match[2], match[3]};
    for (std::sregex_iterator at(cell.begin(), cell.end(), kName), end; at != end; ++at)
      row.names.push_back((*at)[1]);
    rows.push_back(row);
  }
  return rows;
}

/// Names of the fields on the way to one. As many dots in front stand for as many names
/// of the row before; further names of a row lie beside its first.
class Paths {
 public:
  std::vector<std::string> Next(std::string name, bool is_first) {
    const auto dots = std::min(name.find_first_not_of('.'), name.size());
    std::vector<std::string> path(
        last_.begin(),
        last_.begin() + static_cast<std::ptrdiff_t>(std::min(dots, last_.size())));
    if (!is_first && dots == 0) path.assign(last_.begin(), last_.end() - 1);
    name = name.substr(dots) + ".";
    for (std::size_t from = 0, to; (to = name.find('.', from)) != name.npos;
         from = to + 1)
      path.push_back(name.substr(from, name.find_first_of(".[", from) - from));
    return last_ = path;
  }

 private:
  std::vector<std::string> last_;
};

/// The last of the path, those on the way to it are documented by it, too; nullptr where
/// the path stands for a method.
const JobField* FieldAt(const std::vector<std::string>& path,
                        std::set<const JobField*>& missing) {
  if (path.back() == "METHOD") return nullptr;
  const pb::Descriptor* message = JobSpec::descriptor();
  const JobField* field = nullptr;
  for (const std::string& name : path) {
    field = message == nullptr ? nullptr : message->FindFieldByName(name);
    EXPECT_NE(field, nullptr) << fmt::format("{} is no field", fmt::join(path, "."));
    if (field == nullptr) return nullptr;
    missing.erase(field);
    message = field->message_type();
  }
  return field;
}

/// The cell of a default begins with that of the rule, and is no other number.
void ExpectDefault(const JobField& field, const std::string& cell) {
  static const std::regex kNumber(R"(^(?:-?\d[\d. ]*|true|false)$)");
  const std::string value = DefaultText(field);
  if (!value.empty() && (field.has_presence() || field.is_repeated())) {
    EXPECT_TRUE(cell == value || cell.starts_with(value + ";") ||
                cell.starts_with(value + ","))
        << field.full_name() << ": " << cell << ", its rule has " << value;
  } else if (std::regex_match(cell, kNumber) && cell != value) {
    const bool is_bool = field.cpp_type() == JobField::CPPTYPE_BOOL;
    EXPECT_TRUE(!field.has_presence() && cell == (is_bool ? "false" : "0"))
        << field.full_name() << ": " << cell << " is not of its rule";
  }
}

/// Every field of the message and of those in it, but of methods.
void AddFields(const pb::Descriptor& message, std::set<const JobField*>& fields) {
  for (const JobField* field : FieldsOf(message)) {
    const auto* below = field->message_type();
    const bool is_method = field->real_containing_oneof() != nullptr &&
                           below != nullptr && FindMethod(field->name()) != nullptr;
    if (is_method || !fields.insert(field).second) continue;
    if (below != nullptr && below != Vector3::descriptor()) AddFields(*below, fields);
  }
}

TEST(JobDocs, HaveEveryFieldWithTheRangeAndTheDefaultOfItsRule) {
  std::set<const JobField*> missing;
  AddFields(*JobSpec::descriptor(), missing);
  Paths paths;
  for (const Row& row : RowsOfPage()) {
    for (std::size_t i = 0; i < row.names.size(); ++i) {
      const auto path = paths.Next(row.names[i], i == 0);
      const JobField* field = FieldAt(path, missing);
      if (field == nullptr) continue;
      EXPECT_EQ(row.range, RuledCell(*field, row.range).substr(0, row.range.size()))
          << field->full_name();
      EXPECT_TRUE(row.range.find("..") != row.range.npos || RangeText(*field).empty())
          << field->full_name() << " has the range " << RangeText(*field);
      ExpectDefault(*field, row.by_default);
    }
  }
  std::vector<std::string> names;
  for (const JobField* field : missing) names.push_back(field->full_name());
  EXPECT_THAT(names, testing::IsEmpty());
}

}  // namespace
}  // namespace intaglio
