#include "engrave/io/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/io/byte_order_mark.h"
#include "engrave/io/whole_file.h"

namespace intaglio::io {
namespace {

// A tab is in no name by chance.
constexpr std::string_view kSeparators = "\t,;";

constexpr bool IsLineEnd(char c) { return c == '\r' || c == '\n'; }

/// The separator that occurs most often in the header line; the first of several.
char SeparatorOf(std::string_view bytes) {
  std::array<std::size_t, kSeparators.size()> counts{};
  bool quoted = false;
  for (const char c : bytes) {
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (IsLineEnd(c)) break;
    if (const auto which = kSeparators.find(c); which != kSeparators.npos)
      ++counts[which];
  }
  const auto largest = std::ranges::max_element(counts);
  if (*largest == 0) return ',';
  return kSeparators[static_cast<std::size_t>(largest - counts.begin())];
}

/// Takes record after record off the text.
class Records {
 public:
  Records(std::string_view rest, const CsvLimits& limits)
      : rest_(rest), limits_(limits), separator_(SeparatorOf(rest)) {}

  bool AtEnd() {
    while (AtLineEnd() && !rest_.empty()) TakeLineEnd();
    return rest_.empty();
  }

  Result<CsvRow> Next() {
    CsvRow row;
    row.line_number = line_number_;
    while (true) {
      std::string field = INTAGLIO_TRY(TakeField());
      if (row.fields.size() == limits_.max_columns) {
        return TooLarge(fmt::format("more than the {} columns", limits_.max_columns));
      }
      row.fields.push_back(std::move(field));
      if (rest_.starts_with(separator_)) {
        rest_.remove_prefix(1);
        continue;
      }
      TakeLineEnd();
      return row;
    }
  }

 private:
  bool AtLineEnd() const { return rest_.empty() || IsLineEnd(rest_.front()); }
  void TakeLineEnd() {
    if (rest_.empty()) return;
    rest_.remove_prefix(rest_.starts_with("\r\n") ? 2 : 1);
    ++line_number_;
  }

  tl::unexpected<Error> Unreadable(std::size_t line, std::string_view what) const {
    return Fail(ErrorCode::kUnreadable, fmt::format("line {} {}", line, what));
  }
  tl::unexpected<Error> TooLarge(std::string_view what) const {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("line {} has {} allowed; divide the table or raise the limit",
                            line_number_, what));
  }

  Result<std::string> TakeField() {
    if (rest_.starts_with('"')) return TakeQuoted();
    std::size_t size = 0;
    for (; size < rest_.size(); ++size) {
      const char c = rest_[size];
      if (c == separator_ || IsLineEnd(c)) break;
      if (c == '"') {
        return Unreadable(line_number_,
                          "has a quote inside a field; put the whole field in quotes and "
                          "write the quote twice");
      }
      if (c == '\0') {
        return Unreadable(line_number_, "has a NUL byte; save the table as UTF-8 text");
      }
      if (size == limits_.max_field_bytes) return TooLarge(FieldBytes());
    }
    std::string field(rest_.substr(0, size));
    rest_.remove_prefix(size);
    return field;
  }

  Result<std::string> TakeQuoted() {
    const std::size_t first_line = line_number_;
    std::string field;
    rest_.remove_prefix(1);
    while (true) {
      const std::size_t size = rest_.find('"');
      if (size == std::string_view::npos) {
        return Unreadable(first_line,
                          "has an opening quote without a closing one; add it");
      }
      const std::string_view part = rest_.substr(0, size);
      if (field.size() + size > limits_.max_field_bytes) return TooLarge(FieldBytes());
      if (part.find('\0') != std::string_view::npos) {
        return Unreadable(line_number_, "has a NUL byte; save the table as UTF-8 text");
      }
      line_number_ +=
          static_cast<std::size_t>(std::count(part.begin(), part.end(), '\n'));
      field += part;
      rest_.remove_prefix(size + 1);
      if (!rest_.starts_with('"')) break;
      field += '"';
      rest_.remove_prefix(1);
    }
    if (!AtLineEnd() && rest_.front() != separator_) {
      return Unreadable(line_number_,
                        "has text behind a closing quote; put the whole field in quotes "
                        "and write a quote in it twice");
    }
    return field;
  }

  std::string FieldBytes() const {
    return fmt::format("a field of more than the {} bytes", limits_.max_field_bytes);
  }

  std::string_view rest_;
  const CsvLimits& limits_;
  char separator_;
  std::size_t line_number_ = 1;
};

std::string_view Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

Result<std::vector<std::string>> NamesOf(const CsvRow& header) {
  std::vector<std::string> names;
  for (const std::string& field : header.fields) {
    std::string name(Trimmed(field));
    if (name.empty()) {
      return Fail(
          ErrorCode::kMissing,
          fmt::format("line {}: column {} has no name; the first line names every "
                      "column",
                      header.line_number, names.size() + 1));
    }
    if (std::find(names.begin(), names.end(), name) != names.end()) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("line {}: two columns are named '{:.60}'; rename one",
                              header.line_number, name),
                  name);
    }
    names.push_back(std::move(name));
  }
  return names;
}

}  // namespace

std::string CsvField(std::string_view text) {
  if (text.find_first_of(",;\t\"\r\n") == std::string_view::npos)
    return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) quoted.append(c == '"' ? 2 : 1, c);
  return quoted + '"';
}

const std::string* CsvTable::Find(const CsvRow& row, std::string_view name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return nullptr;
  return &row.fields[static_cast<std::size_t>(found - names.begin())];
}

Result<CsvTable> ParseCsv(std::string_view bytes, const CsvLimits& limits) {
  bytes = WithoutByteOrderMark(bytes);
  Records records(bytes, limits);
  if (records.AtEnd()) {
    return Fail(ErrorCode::kMissing,
                "it is empty; the first line names the columns, then one row follows for "
                "each piece");
  }
  const CsvRow header = INTAGLIO_TRY(records.Next());
  std::vector<std::string> names = INTAGLIO_TRY(NamesOf(header));
  CsvTable table{std::move(names), {}};
  while (!records.AtEnd()) {
    CsvRow row = INTAGLIO_TRY(records.Next());
    if (row.fields.size() != table.names.size()) {
      return Fail(ErrorCode::kUnreadable,
                  fmt::format("line {} has {} for {}; put a field with a "
                              "separator in quotes",
                              row.line_number, Counted(row.fields.size(), "field"),
                              Counted(table.names.size(), "column")));
    }
    if (table.rows.size() == limits.max_rows) {
      return Fail(ErrorCode::kTooLarge,
                  fmt::format("it has more than the {} rows allowed; divide the table or "
                              "raise the limit",
                              limits.max_rows));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

Result<CsvTable> ReadCsv(const std::filesystem::path& file, const CsvLimits& limits) {
  const std::string bytes = INTAGLIO_TRY(ReadWholeFile(file, limits.max_file_bytes));
  return ParseCsv(bytes, limits).map_error([&](const Error& error) {
    return AboutFile(error, file);
  });
}

}  // namespace intaglio::io
