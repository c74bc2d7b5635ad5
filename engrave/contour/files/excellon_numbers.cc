#include "engrave/contour/files/excellon_numbers.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "engrave/contour/files/excellon_terms.h"
#include "engrave/core/try.h"
#include "engrave/io/number_text.h"

namespace intaglio::contour {
namespace {

constexpr double kInch_mm = 25.4;
constexpr int kMaxDigits = 9;

tl::unexpected<Error> WrongNumber(ErrorCode code, const std::string& sentence,
                                  std::string_view value = {}) {
  return Fail(code, sentence, std::string(value.substr(0, 80)));
}

tl::unexpected<Error> UnitsMissing() {
  return WrongNumber(
      ErrorCode::kMissing,
      "the file declares neither METRIC nor INCH before it has a length; export it with "
      "units, or give its line of units, e.g. --drill-units METRIC,TZ");
}

std::string TextOf(double unit_mm) { return unit_mm == 1 ? "METRIC" : "INCH"; }
std::string TextOf(Zeros zeros) { return zeros == Zeros::kLeading ? "LZ" : "TZ"; }
std::string TextOf(const std::pair<int, int>& digits) {
  return fmt::format("{}:{} digits", digits.first, digits.second);
}

/// Sets what a file declares, unless something replaces it.
template <typename Field, typename Value>
void SetUnlessReplaced(const std::optional<Field>& declared,
                       const std::optional<Field>& replacing, Value& value,
                       std::vector<std::string>& replaced) {
  if (!declared) return;
  if (!replacing) {
    value = *declared;
  } else if (*declared != *replacing) {
    replaced.push_back(fmt::format("{} of the file, {} as given", TextOf(*declared),
                                   TextOf(*replacing)));
  }
}

}  // namespace

Result<ExcellonNumbers::Declared> ExcellonNumbers::Read(std::string_view line) {
  const bool metric = line.starts_with("METRIC");
  if (!metric && !line.starts_with("INCH"))
    return WrongNumber(ErrorCode::kUnreadable,
                       "expected METRIC or INCH, then LZ, TZ or digits, such as "
                       "METRIC,TZ,000.000; correct it",
                       line);
  Declared declared;
  declared.unit_mm = metric ? 1 : kInch_mm;
  line.remove_prefix(metric ? 6 : 4);
  while (!line.empty()) {
    const std::size_t end = line.find(',', 1);
    const std::string_view field = line.substr(1, end - 1);
    const std::size_t point = field.find('.');
    if (line.front() == ',' && (field == "LZ" || field == "TZ")) {
      declared.zeros = field == "LZ" ? Zeros::kLeading : Zeros::kTrailing;
    } else if (line.front() == ',' && point != std::string_view::npos &&
               field.size() <= kMaxDigits + 1 && field.size() > 1 &&
               field.find_first_not_of("0.") == std::string_view::npos) {
      declared.digits = {static_cast<int>(point),
                         static_cast<int>(field.size() - point) - 1};
    } else {
      return WrongNumber(ErrorCode::kUnreadable,
                         "expected LZ, TZ or digits such as 000.000; correct the header",
                         field);
    }
    line.remove_prefix(std::min(end, line.size()));
  }
  return declared;
}

void ExcellonNumbers::Declare(const Declared& declared) {
  SetUnlessReplaced(declared.unit_mm, replacing_.unit_mm, unit_mm_, replaced_texts_);
  SetUnlessReplaced(declared.zeros, replacing_.zeros, zeros_, replaced_texts_);
  SetUnlessReplaced(declared.digits, replacing_.digits, digits_, replaced_texts_);
}

Status ExcellonNumbers::ReadUnits(std::string_view line) {
  Declare(INTAGLIO_TRY(Read(line)));
  return {};
}

Status ExcellonNumbers::Replace(std::string_view line) {
  const Declared declared = INTAGLIO_TRY(Read(line));
  Declare(declared);
  replacing_ = declared;
  return {};
}

void ExcellonNumbers::SetUnit(double unit_mm) { Declare({unit_mm, {}, {}}); }

Status ExcellonNumbers::ReadComment(std::string_view line) {
  const std::size_t mark = line.find("FILE_FORMAT=");
  if (mark == std::string_view::npos) return {};
  const std::string_view digits = line.substr(mark + 12);
  const auto digit = [&](std::size_t k) {
    return k < digits.size() ? digits[k] - '0' : -1;
  };
  const int before = digit(0), behind = digit(2);
  if (before < 0 || before > 9 || behind < 0 || behind > 9 || digits[1] != ':' ||
      before + behind < 1 || before + behind > kMaxDigits)
    return WrongNumber(ErrorCode::kUnreadable,
                       "expected digits such as ;FILE_FORMAT=4:4; correct the header",
                       line);
  Declare({{}, {}, std::pair(before, behind)});
  return {};
}

std::pair<int, int> ExcellonNumbers::Digits() const {
  if (digits_.first + digits_.second > 0) return digits_;
  return *unit_mm_ == 1 ? std::pair(3, 3) : std::pair(2, 4);
}

Result<double> ExcellonNumbers::Length(std::string_view number) const {
  if (!unit_mm_) return UnitsMissing();
  if (number.find('.') != std::string_view::npos) return Diameter(number);
  auto value = io::ParseFinite(number);
  const auto [before, behind] = Digits();
  const bool sign = number.starts_with('-') || number.starts_with('+');
  const int count = static_cast<int>(number.size()) - (sign ? 1 : 0);
  // With all its digits a number is the same whichever zeros are left out.
  if (value && !zeros_ && count != before + behind)
    return WrongNumber(
        ErrorCode::kMissing,
        fmt::format(
            "a coordinate has no decimal point and {} digits in place of {}, and "
            "the header declares neither LZ nor TZ; export with decimal points, or "
            "give the line of units, e.g. --drill-units {},TZ",
            count, before + behind, *unit_mm_ == 1 ? "METRIC" : "INCH"),
        number);
  const int shift = zeros_ == Zeros::kLeading ? count - before : behind;
  if (value) value = *value * std::pow(10, -shift) * *unit_mm_;
  if (value && std::abs(*value) <= kMaxExcellon_mm) return *value;
  return WrongNumber(
      ErrorCode::kInvalidValue,
      fmt::format("expected a length of at most {} mm; correct it", kMaxExcellon_mm),
      number);
}

Result<double> ExcellonNumbers::Diameter(std::string_view number) const {
  if (!unit_mm_) return UnitsMissing();
  const auto value = io::ParseFinite(number);
  if (value && std::abs(*value * *unit_mm_) <= kMaxExcellon_mm) return *value * *unit_mm_;
  return WrongNumber(
      ErrorCode::kInvalidValue,
      fmt::format("expected a length of at most {} mm; correct it", kMaxExcellon_mm),
      number);
}

}  // namespace intaglio::contour
