#include "services/job/files/batch_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "engrave/core/try.h"
#include "engrave/io/byte_order_mark.h"
#include "engrave/io/whole_file.h"
#include "services/job/checks/job_check.h"
#include "services/job/files/json_position.h"
#include "services/job/files/series.h"
#include "services/platform/text_format/field_suggestion.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
namespace pb = google::protobuf;

// More mistakes than a person corrects at once.
constexpr std::size_t kMaxErrors = 100;

const std::set<std::string> kOwnColumns = {"id", "after", "cell", "job", "key"};

Error At(std::size_t line_number, ErrorCode code, const std::string& what,
         const std::string& value = {}) {
  return {code, fmt::format("line {}: {}", line_number, what), value};
}

tl::unexpected<Error> Together(std::vector<Error> errors) {
  const std::size_t count = errors.size();
  if (count > kMaxErrors) {
    errors.resize(kMaxErrors);
    errors.push_back(
        {errors[0].code, fmt::format("and {} more", count - kMaxErrors), ""});
  }
  return tl::unexpected(JoinErrors(errors));
}

/// A value as a person would write it into a table.
Result<std::string> TextOf(const pb::Value& value, const std::string& path) {
  switch (value.kind_case()) {
    case pb::Value::kNumberValue:
      return fmt::format("{}", value.number_value());
    case pb::Value::kStringValue:
      return value.string_value();
    case pb::Value::kBoolValue:
      return std::string(value.bool_value() ? "true" : "false");
    case pb::Value::kListValue: {
      std::string words;
      for (const pb::Value& element : value.list_value().values()) {
        if (element.kind_case() != pb::Value::kNumberValue) break;
        words += fmt::format("{}{}", words.empty() ? "" : " ", element.number_value());
      }
      if (!words.empty()) return words;
      break;
    }
    default:
      break;
  }
  return Fail(
      ErrorCode::kInvalidValue,
      fmt::format(
          "overrides.{}: give a number, a text, true, false or a list of numbers; write "
          "a group of fields field by field, as \"block.margin_mm\": 5",
          path),
      path);
}

/// Adds the entry's overrides and its priority as columns of one row.
void AddColumns(const BatchEntry& entry, BatchLine& line, std::vector<Error>& errors) {
  std::map<std::string, std::string> columns;
  for (const auto& [path, value] : entry.overrides()) {
    auto text = TextOf(value, path);
    if (path.empty() || path.starts_with('#')) {
      errors.push_back(At(line.line_number, ErrorCode::kInvalidValue,
                          fmt::format("overrides: '{}' is not a field", path), path));
    } else if (text) {
      columns[path] = std::move(*text);
    } else {
      errors.push_back(At(line.line_number, text.error().code, text.error().message));
    }
  }
  if (entry.has_priority()) columns["priority"] = std::to_string(entry.priority());
  io::CsvRow& row = line.columns.rows.emplace_back();
  row.line_number = line.line_number;
  for (auto& [path, text] : columns) {
    line.columns.names.push_back(path);
    row.fields.push_back(std::move(text));
  }
}

std::vector<std::string> TokensOf(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

void CheckId(const BatchLine& line, std::vector<Error>& errors) {
  if (line.id.find_first_of(" \t\r\n") == std::string::npos) return;
  errors.push_back(At(line.line_number, ErrorCode::kInvalidValue,
                      fmt::format("id '{}': contains blanks; use '-'", line.id),
                      line.id));
}

using ById = std::map<std::string, const BatchLine*>;

/// The ids that are left when jobs that wait for no remaining job are removed, again and
/// again: all circles, and the jobs that wait for one.
std::set<std::string> NeverFree(const ById& by_id) {
  std::map<std::string, std::size_t> waits_for;
  std::map<std::string, std::vector<std::string>> followers;
  std::vector<std::string> free;
  for (const auto& [id, line] : by_id) {
    for (const std::string& before : line->after) {
      if (!by_id.contains(before)) continue;
      followers[before].push_back(id);
      ++waits_for[id];
    }
    if (waits_for[id] == 0) free.push_back(id);
  }
  while (!free.empty()) {
    const std::string id = free.back();
    free.pop_back();
    waits_for.erase(id);
    for (const std::string& follower : followers[id]) {
      if (--waits_for[follower] == 0) free.push_back(follower);
    }
  }
  std::set<std::string> left;
  for (const auto& [id, count] : waits_for) left.insert(id);
  return left;
}

/// From one that is never free: every one of them waits for another, so a walk along them
/// comes to a circle, which begins and ends with the same id; empty when it comes to
/// where an earlier walk was.
std::vector<std::string> CircleFrom(const ById& by_id, const std::set<std::string>& left,
                                    std::string id, std::set<std::string>& walked) {
  std::map<std::string, std::size_t> seen;
  std::vector<std::string> way;
  while (seen.emplace(id, way.size()).second) {
    if (!walked.insert(id).second) return {};
    way.push_back(id);
    const auto& after = by_id.at(id)->after;
    id = *std::find_if(after.begin(), after.end(),
                       [&](const std::string& before) { return left.contains(before); });
  }
  way.erase(way.begin(), way.begin() + static_cast<std::ptrdiff_t>(seen.at(id)));
  way.push_back(id);
  return way;
}

/// The circles of a batch, or as many as are reported.
void AddCircles(const ById& by_id, std::vector<Error>& errors) {
  std::set<std::string> walked;
  const std::set<std::string> left = NeverFree(by_id);
  for (const std::string& id : left) {
    if (errors.size() >= kMaxErrors) return;
    const auto circle = CircleFrom(by_id, left, id, walked);
    if (circle.empty()) continue;
    errors.push_back(
        At(by_id.at(circle.front())->line_number, ErrorCode::kInvalidValue,
           fmt::format(
               "after: the jobs wait for each other in a cycle, {}; remove one of these",
               fmt::join(circle, " after ")),
           circle.front()));
  }
}

}  // namespace

Result<std::vector<BatchLine>> ParseBatchJson(std::string_view text,
                                              const BatchLimits& limits) {
  if (text.size() > limits.max_bytes) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("is larger than {} bytes", limits.max_bytes));
  }
  text = io::WithoutByteOrderMark(text);
  std::vector<BatchLine> lines;
  std::vector<Error> errors;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const auto end = std::min(text.find('\n'), text.size());
    const std::string_view row = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (row.find_first_not_of(" \t\r") == row.npos) continue;
    if (lines.size() == limits.max_jobs) {
      return Fail(ErrorCode::kTooLarge,
                  fmt::format("has more than {} jobs: divide the file", limits.max_jobs));
    }
    BatchLine& line = lines.emplace_back();
    line.line_number = number;
    BatchEntry entry;
    const auto read = pb::util::JsonStringToMessage({row.data(), row.size()}, &entry);
    if (!read.ok()) {
      const std::string what(read.message());
      std::string where = LocateJsonError(row, what);
      where = where.starts_with("1:") ? "column " + where.substr(2) : where;
      where += SuggestionFor(*BatchEntry::descriptor(), what);
      errors.push_back(At(number, ErrorCode::kUnreadable, where));
      continue;
    }
    line.id = entry.id().empty() ? std::to_string(lines.size()) : entry.id();
    line.job_file = entry.job();
    line.after = {entry.after().begin(), entry.after().end()};
    line.cell = entry.cell();
    line.key = entry.key();
    AddColumns(entry, line, errors);
    CheckId(line, errors);
  }
  if (lines.empty()) {
    return Fail(ErrorCode::kMissing, "has no jobs: write one JSON object a line");
  }
  if (!errors.empty()) return Together(std::move(errors));
  return lines;
}

Result<std::vector<BatchLine>> ParseBatchCsv(std::string_view text,
                                             const BatchLimits& limits) {
  const io::CsvLimits csv_limits{.max_file_bytes = limits.max_bytes,
                                 .max_rows = limits.max_jobs};
  const auto table = INTAGLIO_TRY(io::ParseCsv(text, csv_limits));
  if (table.rows.empty()) {
    return Fail(ErrorCode::kMissing, "has no rows: write one job in each row");
  }
  std::vector<BatchLine> lines;
  std::vector<Error> errors;
  for (const io::CsvRow& row : table.rows) {
    BatchLine& line = lines.emplace_back();
    line.line_number = row.line_number;
    const auto field = [&](const char* name) {
      const std::string* text_of = table.Find(row, name);
      return text_of == nullptr ? std::string() : *text_of;
    };
    line.id = field("id").empty() ? std::to_string(lines.size()) : field("id");
    line.job_file = field("job");
    line.after = TokensOf(field("after"));
    line.cell = field("cell");
    line.key = field("key");
    io::CsvRow& own = line.columns.rows.emplace_back();
    own.line_number = row.line_number;
    for (std::size_t i = 0; i < table.names.size(); ++i) {
      if (kOwnColumns.contains(table.names[i])) continue;
      line.columns.names.push_back(table.names[i]);
      own.fields.push_back(row.fields[i]);
    }
    CheckId(line, errors);
  }
  if (!errors.empty()) return Together(std::move(errors));
  return lines;
}

std::vector<Error> CheckBatchOrder(const std::vector<BatchLine>& lines) {
  std::vector<Error> errors;
  ById by_id;
  for (const BatchLine& line : lines) {
    const auto [other, is_new] = by_id.emplace(line.id, &line);
    if (is_new) continue;
    errors.push_back(At(line.line_number, ErrorCode::kInvalidValue,
                        fmt::format("id '{}': is already used in line {}", line.id,
                                    other->second->line_number),
                        line.id));
  }
  for (const BatchLine& line : lines) {
    for (const std::string& before : line.after) {
      if (by_id.contains(before)) continue;
      errors.push_back(
          At(line.line_number, ErrorCode::kNotFound,
             fmt::format("after '{}': no job of this file has that id", before), before));
    }
  }
  AddCircles(by_id, errors);
  return errors;
}

Result<std::vector<BatchLine>> ReadBatchFile(const fs::path& file) {
  const std::string ending = file.extension().string();
  const bool json = ending == ".jsonl" || ending == ".ndjson";
  if (!json && ending != ".csv") {
    return Fail(
        ErrorCode::kUnsupported,
        fmt::format("{}: the extension has to be .jsonl, .ndjson or .csv", file.string()),
        ending);
  }
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(file, BatchLimits().max_bytes));
  auto lines = json ? ParseBatchJson(text) : ParseBatchCsv(text);
  if (!lines) {
    Error error = lines.error();
    std::string message;
    std::istringstream in(error.message);
    for (std::string line; std::getline(in, line);) {
      message +=
          fmt::format("{}{}, {}", message.empty() ? "" : "\n", file.string(), line);
    }
    error.message = std::move(message);
    return tl::unexpected(std::move(error));
  }
  return lines;
}

Result<JobSpec> JobOf(const BatchLine& line, const JobSpec& pattern,
                      const fs::path& folder) {
  auto job = FillRow(pattern, line.columns, line.columns.rows.at(0), folder);
  if (job) NumberEqualNames(*job, pattern, line.id);
  return job;
}

}  // namespace intaglio
