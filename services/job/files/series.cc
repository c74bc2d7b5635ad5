#include "services/job/files/series.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <google/protobuf/descriptor.h>

#include <optional>
#include <sstream>

#include "engrave/io/nearest_name.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/placeholders.h"
#include "services/job/fields/field_path.h"
#include "services/job/files/job_file.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;

/// Puts one row's fields into texts.
class Row {
 public:
  Row(const io::CsvTable& table, const io::CsvRow& row, std::vector<Error>& errors)
      : table_(table), row_(row), errors_(errors) {}

  /// Every text of the message, at any depth.
  void FillIn(pb::Message& message, const std::string& path) {
    const pb::Descriptor& type = *message.GetDescriptor();
    const pb::Reflection& reflection = *message.GetReflection();
    for (int i = 0; i < type.field_count(); ++i) {
      const pb::FieldDescriptor& field = *type.field(i);
      const std::string here = JoinPath(path, field.name());
      if (field.cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE) {
        FillInMessages(message, field, here);
      } else if (field.cpp_type() == pb::FieldDescriptor::CPPTYPE_STRING &&
                 !field.is_repeated() &&
                 (!field.has_presence() || reflection.HasField(message, &field))) {
        reflection.SetString(&message, &field,
                             FilledIn(reflection.GetString(message, &field), here));
      }
    }
  }

  /// Columns that were named in a text.
  const std::set<std::string>& used() const { return used_; }

 private:
  void FillInMessages(pb::Message& message, const pb::FieldDescriptor& field,
                      const std::string& path) {
    const pb::Reflection& reflection = *message.GetReflection();
    if (!field.is_repeated()) {
      if (!reflection.HasField(message, &field)) return;
      return FillIn(*reflection.MutableMessage(&message, &field), path);
    }
    for (int k = 0; k < reflection.FieldSize(message, &field); ++k) {
      FillIn(*reflection.MutableRepeatedMessage(&message, &field, k),
             fmt::format("{}[{}]", path, k));
    }
  }

  std::string FilledIn(const std::string& text, const std::string& path) {
    const bool is_engraved = path.ends_with(".text.text") || path.ends_with(".code.text");
    return FillPlaceholders(
        text, [&](const std::string& name) -> std::optional<std::string> {
          const std::string* field = table_.Find(row_, name);
          if (field != nullptr) {
            used_.insert(name);
            if (path == "name") return WithoutBraces(*field);
            return is_engraved ? WithDoubledBraces(*field) : *field;
          }
          if (name == "n") return std::nullopt;
          const auto meant = io::NearestName(name, table_.names);
          errors_.push_back(
              {ErrorCode::kNotFound,
               fmt::format("{}: the table has no column '{}'{}; it has: {}", path, name,
                           meant ? fmt::format(", did you mean {}?", *meant) : "",
                           fmt::join(table_.names, ", ")),
               name});
          return std::nullopt;
        });
  }

  const io::CsvTable& table_;
  const io::CsvRow& row_;
  std::vector<Error>& errors_;
  std::set<std::string> used_;
};

/// Sets the columns that are fields by their path, and checks that no column overwrites
/// another.
void SetColumns(const io::CsvTable& table, const io::CsvRow& row,
                const std::set<std::string>& passed_over, JobSpec& job,
                std::vector<Error>& errors) {
  std::vector<std::string> set;
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    const std::string& name = table.names[i];
    if (passed_over.contains(name) || name.starts_with('#')) continue;
    if (!BeginsWithField(*JobSpec::descriptor(), name)) {
      errors.push_back(
          {ErrorCode::kMissing,
           fmt::format(
               "column '{0}': is not a field of a job, and no text or file name of the "
               "job file contains {{{0}}}: correct it, or name it '#{0}' to ignore it",
               name),
           name});
    } else if (!row.fields[i].empty()) {
      const auto done = SetField(job, name, row.fields[i]);
      if (done) set.push_back(name);
      if (!done) errors.push_back(done.error());
    }
  }
  for (const std::string& name : set) {
    if (IsSet(job, name)) continue;
    errors.push_back(
        {ErrorCode::kInvalidValue,
         fmt::format("{}: excludes another column of this row; empty one of the two",
                     name),
         name});
  }
}

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

}  // namespace

Result<JobSpec> FillRow(const JobSpec& pattern, const io::CsvTable& table,
                        const io::CsvRow& row, const std::filesystem::path& folder,
                        const std::set<std::string>& passed_over) {
  std::vector<Error> errors;
  JobSpec job = pattern;
  Row fields(table, row, errors);
  fields.FillIn(job, "");
  std::set<std::string> others = passed_over;
  others.insert(fields.used().begin(), fields.used().end());
  SetColumns(table, row, others, job, errors);
  if (!errors.empty()) return tl::unexpected(JoinErrors(errors));
  ResolveFiles(job, folder);
  return job;
}

void NumberEqualNames(JobSpec& job, const JobSpec& pattern, const std::string& what) {
  if (job.name() != pattern.name()) return;
  job.set_name(job.name() + (job.name().empty() ? "" : " ") + what);
}

Result<std::vector<JobSpec>> MakeSeries(const JobSpec& pattern, const io::CsvTable& table,
                                        const std::filesystem::path& folder) {
  if (table.rows.empty()) {
    return Fail(ErrorCode::kMissing,
                "the table has no rows: write one piece in each row");
  }
  std::vector<JobSpec> jobs;
  std::vector<Error> errors;
  std::set<std::string> reported;  // also of another row
  for (const io::CsvRow& row : table.rows) {
    auto job = FillRow(pattern, table, row, folder);
    if (job) {
      NumberEqualNames(*job, pattern, std::to_string(jobs.size() + 1));
      jobs.push_back(std::move(*job));
      continue;
    }
    Error error = std::move(job.error());
    std::string news;
    for (const std::string& line : Lines(error.message)) {
      if (!reported.insert(line).second) continue;
      news +=
          fmt::format("{}line {}: {}", news.empty() ? "" : "\n", row.line_number, line);
    }
    if (news.empty()) continue;
    error.message = std::move(news);
    errors.push_back(std::move(error));
  }
  if (!errors.empty()) return tl::unexpected(JoinErrors(errors));
  return jobs;
}

}  // namespace intaglio
