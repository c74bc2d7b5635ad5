#include "services/job/marks/mark_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

#include "engrave/core/try.h"
#include "engrave/io/nearest_name.h"
#include "services/job/convert/placeholders.h"

namespace intaglio {
namespace {

const std::string& VariableText(const MarkItem& item) {
  return item.has_code() ? item.code().text() : item.text().text();
}

}  // namespace

Result<MarkTable> MarkTable::Make(const Marks& marks, const MarkFile& file) {
  MarkTable made;
  made.first_number_ = marks.first_number();
  made.digits_ = marks.number_digits();
  made.file_ = std::filesystem::path(file.name).filename().string();
  if (!marks.table().empty()) {
    auto table = io::ParseCsv(file.bytes);
    if (!table) {
      Error error = std::move(table.error());
      error.message = fmt::format("marks.table: {}: {}", file.name, error.message);
      return tl::unexpected(error);
    }
    made.count_ = table->rows.size();
    made.table_ = std::move(*table);
  }
  if (marks.repeats().has_count()) {
    if (made.table_ && marks.repeats().count() > made.count_) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("marks.repeats.count: {} is more than the {} rows of {}; "
                              "use fewer, or remove it for all rows",
                              marks.repeats().count(), made.count_, file.name),
                  fmt::format("{}", marks.repeats().count()));
    }
    made.count_ = marks.repeats().count();
  }
  if (made.count_ == 0) {
    return Fail(
        ErrorCode::kMissing,
        fmt::format("marks.table: {} has no row; give one for each repeat", file.name),
        file.name);
  }
  return made;
}

bool MarkTable::Varies(const MarkItem& item) {
  return !PlaceholdersOf(VariableText(item)).empty();
}

Result<MarkItem> MarkTable::Fill(const MarkItem& item, const std::string& path,
                                 std::size_t repeat) const {
  std::string missing;
  const auto value = [&](const std::string& name) -> std::optional<std::string> {
    const std::string* field =
        table_ ? table_->Find(table_->rows[repeat], name) : nullptr;
    if (field != nullptr) return WithDoubledBraces(*field);
    if (name == "n") return fmt::format("{:0{}}", first_number_ + repeat, digits_);
    missing = name;
    return std::nullopt;
  };
  const std::string text =
      NumberedText(FillPlaceholders(VariableText(item), value), repeat + 1);
  if (!missing.empty()) {
    const std::string field = path + (item.has_code() ? ".code.text" : ".text.text");
    if (!table_)
      return Fail(ErrorCode::kNotFound,
                  fmt::format("{}: {{{}}} {}", field, missing,
                              "needs marks.table with this column"),
                  missing);
    const auto meant = io::NearestName(missing, table_->names);
    return Fail(
        ErrorCode::kNotFound,
        fmt::format("{}: {} has no column '{}'{}; it has: {}", field, file_, missing,
                    meant ? fmt::format(", did you mean {}?", *meant) : "",
                    fmt::join(table_->names, ", ")),
        missing);
  }
  MarkItem filled = item;
  if (item.has_code()) filled.mutable_code()->set_text(text);
  if (item.has_text()) filled.mutable_text()->set_text(text);
  return filled;
}

std::string MarkTable::NameOf(const MarkItem& item, std::size_t repeat) const {
  if (!Varies(item)) return "";
  if (!table_) return fmt::format(" (repeat {})", repeat + 1);
  return fmt::format(" (repeat {}, line {} of {})", repeat + 1,
                     table_->rows[repeat].line_number, file_);
}

}  // namespace intaglio
