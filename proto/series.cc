#include "proto/series.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <google/protobuf/descriptor.h>

#include "proto/field_ranges.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;

/// Puts one row's fields into texts.
class Row {
 public:
  Row(const formats::CsvTable& table, const formats::CsvRow& row)
      : table_(table), row_(row) {}

  /// Every text of the message, at any depth.
  Status FillIn(pb::Message& message, const std::string& path) {
    const pb::Descriptor& type = *message.GetDescriptor();
    const pb::Reflection& reflection = *message.GetReflection();
    for (int i = 0; i < type.field_count(); ++i) {
      const pb::FieldDescriptor& field = *type.field(i);
      const std::string here = JoinPath(path, field.name());
      Status done;
      if (field.cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE) {
        done = FillInMessages(message, field, here);
      } else if (field.cpp_type() == pb::FieldDescriptor::CPPTYPE_STRING &&
                 !field.is_repeated() &&
                 (!field.has_presence() || reflection.HasField(message, &field))) {
        auto text = FilledIn(reflection.GetString(message, &field), here);
        if (!text) return tl::unexpected(text.error());
        reflection.SetString(&message, &field, std::move(*text));
      }
      if (!done) return done;
    }
    return {};
  }

  bool used() const { return used_; }

 private:
  Status FillInMessages(pb::Message& message, const pb::FieldDescriptor& field,
                        const std::string& path) {
    const pb::Reflection& reflection = *message.GetReflection();
    if (!field.is_repeated()) {
      if (!reflection.HasField(message, &field)) return {};
      return FillIn(*reflection.MutableMessage(&message, &field), path);
    }
    for (int k = 0; k < reflection.FieldSize(message, &field); ++k) {
      const auto done = FillIn(*reflection.MutableRepeatedMessage(&message, &field, k),
                               fmt::format("{}[{}]", path, k));
      if (!done) return done;
    }
    return {};
  }

  Result<std::string> FilledIn(const std::string& text, const std::string& path) {
    std::string filled;
    std::size_t at = 0;
    for (;;) {
      const auto open = text.find('{', at);
      const auto close = text.find('}', open == text.npos ? open : open + 1);
      if (close == text.npos) return filled + text.substr(at);
      const std::string name = text.substr(open + 1, close - open - 1);
      filled += text.substr(at, open - at);
      at = close + 1;
      const std::string* field = table_.Find(row_, name);
      if (field != nullptr) {
        filled += *field;
        used_ = true;
      } else if (name == "n") {
        filled += "{n}";
      } else {
        return Fail(ErrorCode::kNotFound,
                    fmt::format("{}: the table has no column '{}'; it has: {}", path,
                                name, fmt::join(table_.names, ", ")),
                    name);
      }
    }
  }

  const formats::CsvTable& table_;
  const formats::CsvRow& row_;
  bool used_ = false;
};

}  // namespace

Result<std::vector<JobSpec>> MakeSeries(const JobSpec& pattern,
                                        const formats::CsvTable& table) {
  if (table.rows.empty()) {
    return Fail(ErrorCode::kMissing, "the table has no rows: write a piece in each");
  }
  std::vector<JobSpec> jobs;
  for (const formats::CsvRow& row : table.rows) {
    JobSpec job = pattern;
    Row fields(table, row);
    if (auto done = fields.FillIn(job, ""); !done) return tl::unexpected(done.error());
    if (!fields.used()) {
      return Fail(ErrorCode::kMissing,
                  fmt::format("the job names no column of the table, all pieces would be "
                              "alike: write {{{}}} in a text, a name or a file",
                              fmt::join(table.names, "} or {")));
    }
    if (job.name() == pattern.name()) {
      job.set_name(fmt::format("{}{}{}", pattern.name(),
                               pattern.name().empty() ? "" : " ", jobs.size() + 1));
    }
    jobs.push_back(std::move(job));
  }
  return jobs;
}

}  // namespace intaglio
