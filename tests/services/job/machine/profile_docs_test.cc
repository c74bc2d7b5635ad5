// docs/machines/profile.md has every field of a profile and no other, each with the range
// and the default of its rule. INTAGLIO_WRITE_GOLDEN=1 writes these, and a row for each
// field that has none, from the comment beside it.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <google/protobuf/compiler/importer.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "proto/machine.pb.h"
#include "tests/services/platform/fields/rule_text.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;

const std::string kPage = INTAGLIO_SOURCE_DIR "/docs/machines/profile.md";

class Errors : public pb::compiler::MultiFileErrorCollector {
  void AddError(const std::string& file, int line, int,
                const std::string& message) override {
    ADD_FAILURE() << file << ":" << line + 1 << ": " << message;
  }
};

/// The schema with its comments, which compiled descriptors do not have.
class Schema {
 public:
  Schema() {
    tree_.MapPath("", INTAGLIO_SOURCE_DIR);
    tree_.MapPath("", "/usr/include");
    file_ = importer_.Import("proto/machine.proto");
  }
  /// nullptr when the profile has no such message.
  const pb::Descriptor* Message(const std::string& name) const {
    return file_->FindMessageTypeByName(name);
  }
  std::vector<const pb::Descriptor*> messages() const {
    std::vector<const pb::Descriptor*> all;
    for (int i = 0; i < file_->message_type_count(); ++i)
      all.push_back(file_->message_type(i));
    return all;
  }

 private:
  Errors errors_;
  pb::compiler::DiskSourceTree tree_;
  pb::compiler::Importer importer_{&tree_, &errors_};
  const pb::FileDescriptor* file_ = nullptr;
};

std::string CommentOf(const pb::FieldDescriptor& field) {
  pb::SourceLocation location;
  if (!field.GetSourceLocation(&location)) return "";
  const std::string& raw = location.leading_comments.empty() ? location.trailing_comments
                                                             : location.leading_comments;
  static const std::regex kSpace(R"(\s+)");
  return std::regex_replace(raw, kSpace, " ");
}

std::string NewRow(const pb::FieldDescriptor& field) {
  return fmt::format("| `{}` | {} |{}| |", field.name(), RuledCell(field, ""),
                     CommentOf(field));
}

/// The page with the rows that follow from the schema. A table ends with its last row.
class Page {
 public:
  explicit Page(const Schema& schema) : schema_(schema) {
    std::ifstream stream(kPage);
    std::string line;
    while (std::getline(stream, line)) Add(line);
    EndTable();
  }

  const std::string& text() const { return text_; }
  /// Fields of messages that have no table.
  std::set<std::string> Missing() const {
    std::set<std::string> missing;
    for (const pb::Descriptor* message : schema_.messages()) {
      if (!written_.contains(message->name())) missing.insert(message->name());
    }
    return missing;
  }

 private:
  void Add(const std::string& line) {
    static const std::regex kSection(R"(^## (\w+)$)");
    static const std::regex kRow(R"(^\| `(\w+)` \| ?(.*?) ?\|(.*)$)");
    std::smatch match;
    if (in_table_ && !line.starts_with("|")) EndTable();
    if (line.starts_with("## ")) message_ = nullptr;
    if (std::regex_search(line, match, kSection)) message_ = schema_.Message(match[1]);
    if (message_ == nullptr || !std::regex_search(line, match, kRow)) {
      text_ += line + "\n";
      return;
    }
    in_table_ = true;
    const pb::FieldDescriptor* field = message_->FindFieldByName(match[1]);
    EXPECT_NE(field, nullptr) << message_->name() << "." << match[1] << " is no field";
    EXPECT_TRUE(written_[message_->name()].insert(match[1]).second)
        << message_->name() << "." << match[1] << " occurs twice";
    if (field == nullptr) return;
    const std::string cell = RuledCell(*field, match[2]);
    text_ += fmt::format("| `{}` |{}|{}\n", match[1].str(),
                         cell.empty() ? " " : " " + cell + " ", match[3].str());
  }

  void EndTable() {
    if (!in_table_) return;
    in_table_ = false;
    for (int i = 0; i < message_->field_count(); ++i) {
      const pb::FieldDescriptor& field = *message_->field(i);
      if (written_[message_->name()].insert(field.name()).second)
        text_ += NewRow(field) + "\n";
    }
  }

  const Schema& schema_;
  const pb::Descriptor* message_ = nullptr;
  bool in_table_ = false;
  std::map<std::string, std::set<std::string>> written_;
  std::string text_;
};

TEST(ProfileDocs, AgreeWithTheRules) {
  const Schema schema;
  const Page page(schema);
  EXPECT_THAT(page.Missing(), testing::IsEmpty());
  if (std::getenv("INTAGLIO_WRITE_GOLDEN") != nullptr)
    std::ofstream(kPage) << page.text();
  std::istringstream made(page.text());
  std::ifstream written(kPage);
  std::string made_line, written_line;
  while (std::getline(made, made_line)) {
    std::getline(written, written_line);
    ASSERT_EQ(written_line, made_line) << "INTAGLIO_WRITE_GOLDEN=1 writes the page anew";
  }
}

TEST(RuledCell, HasTheRangeAndTheDefaultOfTheRule) {
  const auto& lag = *MachineSpec::descriptor()->FindFieldByName("stage_lag_s");
  EXPECT_EQ(RuledCell(lag, "0..1, default 0.5"), "0..0.1, default 0.0002");
  EXPECT_EQ(RuledCell(lag, ""), "0..0.1, default 0.0002");
  const auto& gain = *ServoDrive::descriptor()->FindFieldByName("position_gain_per_s");
  EXPECT_EQ(RuledCell(gain, "K, 1..2000; of the loop"), "K, 1..200000; of the loop");
  const auto& air = *MachineSpec::descriptor()->FindFieldByName("compressed_air");
  EXPECT_EQ(RuledCell(air, "default false"), "default false");
  EXPECT_EQ(RuledCell(air, "default true"), "");
}

}  // namespace
}  // namespace intaglio
