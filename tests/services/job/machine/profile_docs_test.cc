// docs/machines/profile.md has every field of a profile, with its range, and no other.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>

#include "proto/machine.pb.h"
#include "services/job/field_ranges.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;

/// Rows by message (the section) and field (the first column).
std::map<std::string, std::map<std::string, std::string>> RowsOfPage() {
  static const std::regex kSection(R"(^## (\w+)$)"), kRow(R"(^\| `(\w+)` \|(.*))");
  std::map<std::string, std::map<std::string, std::string>> rows;
  std::ifstream page(INTAGLIO_SOURCE_DIR "/docs/machines/profile.md");
  std::string line, section;
  while (std::getline(page, line)) {
    std::smatch match;
    if (line.starts_with("## ")) section.clear();
    if (std::regex_search(line, match, kSection)) section = match[1];
    if (section.empty() || !std::regex_search(line, match, kRow)) continue;
    EXPECT_TRUE(rows[section].emplace(match[1], match[2]).second)
        << section << "." << match[1] << " occurs twice";
  }
  return rows;
}

TEST(ProfileDocs, HaveEveryFieldOfTheSchemaAndNoOther) {
  std::set<std::string> documented, of_schema;
  for (const auto& [message, rows] : RowsOfPage()) {
    for (const auto& [field, text] : rows) documented.insert(message + "." + field);
  }
  const pb::FileDescriptor& schema = *MachineSpec::descriptor()->file();
  for (int m = 0; m < schema.message_type_count(); ++m) {
    const pb::Descriptor& message = *schema.message_type(m);
    for (int f = 0; f < message.field_count(); ++f) {
      of_schema.insert(message.name() + "." + message.field(f)->name());
    }
  }
  EXPECT_THAT(documented, testing::ContainerEq(of_schema));
}

TEST(ProfileDocs, HaveTheRangesOfTheCheck) {
  const auto rows = RowsOfPage();
  int compared = 0;
  for (const FieldRange& range : FieldRanges()) {
    const auto message = rows.find(std::string(range.message));
    if (message == rows.end()) continue;
    const auto row = message->second.find(std::string(range.field));
    ASSERT_NE(row, message->second.end()) << range.message << "." << range.field;
    const auto text = [](double value) {
      return value == static_cast<long long>(value)
                 ? fmt::format("{}", static_cast<long long>(value))
                 : fmt::format("{}", value);
    };
    EXPECT_THAT(row->second,
                testing::HasSubstr(" " + text(range.min) + ".." + text(range.max)))
        << range.message << "." << range.field;
    ++compared;
  }
  EXPECT_GT(compared, 40);
}

}  // namespace
}  // namespace intaglio
