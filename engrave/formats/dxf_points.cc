// An ASCII DXF is pairs of lines, a group code and its value. Code 0 begins a section, an
// entity or the end; the codes 10, 20, 30 that follow a POINT are its x, y and z, which
// are world coordinates whatever its extrusion (AutoCAD DXF reference, "POINT").

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/formats/coordinate_lines.h"
#include "engrave/formats/point_file.h"
#include "engrave/formats/point_table_rules.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/dxf_unit.h"
#include "engrave/io/number_text.h"
#include "engrave/io/text_behind.h"
#include "engrave/io/trimmed_line.h"

namespace intaglio::formats {
namespace {

struct Pair {
  int code = 0;
  std::string_view value;
};

/// The pairs of lines one after another.
class Pairs {
 public:
  explicit Pairs(std::string_view rest) : rest_(rest) {}

  /// Nothing at the end. A line that is not a group code is an error.
  Result<std::optional<Pair>> Next() {
    if (rest_.empty()) return std::nullopt;
    const std::string_view line = io::TrimmedLine(TakeLine());
    Pair pair;
    const auto parsed =
        std::from_chars(line.data(), line.data() + line.size(), pair.code);
    if (parsed.ec != std::errc() || parsed.ptr != line.data() + line.size()) {
      return Fail(ErrorCode::kUnreadable,
                  fmt::format("line {} is not a group code of a DXF: \"{:.60}\"; export "
                              "the drawing again, as ASCII DXF",
                              line_number_, line));
    }
    pair.value = io::TrimmedLine(TakeLine());
    return pair;
  }

  std::size_t line_number() const { return line_number_; }  ///< of the last line taken
  std::string_view rest() const { return rest_; }

 private:
  std::string_view TakeLine() {
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    const std::string_view line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++line_number_;
    return line;
  }

  std::string_view rest_;
  std::size_t line_number_ = 0;
};

class PointReader {
 public:
  PointReader(std::string_view bytes, const PointFileLimits& limits)
      : pairs_(bytes), limits_(limits) {}

  Result<PointTable> Read();

 private:
  Status Receive(const Pair& pair);
  Status TakeUnit(std::string_view value);
  Status TakeCoordinate(const Pair& pair);
  Status EndPoint();
  void Begin(std::string_view what);
  std::string PassedOver() const;

  Pairs pairs_;
  const PointFileLimits& limits_;
  PointTable table_;
  double unit_mm_ = 1;
  bool begins_section_ = false;  // the next code 2 is its name
  std::string_view section_;
  std::string_view variable_;  // of the header
  std::optional<Vec3> point_;  // that is being read, drawing units
  bool ended_ = false;
  std::map<std::string_view, std::uint64_t> passed_over_;
  std::uint64_t passed_over_count_ = 0;
};

Status PointReader::TakeUnit(std::string_view value) {
  const std::optional<double> unit_mm = io::DxfUnitMm(value);
  if (!unit_mm) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("its unit ($INSUNITS) is {:.20}; set the drawing's unit to "
                            "millimetres (4)",
                            value),
                std::string(value.substr(0, 20)));
  }
  unit_mm_ = *unit_mm;
  return {};
}

Status PointReader::TakeCoordinate(const Pair& pair) {
  if (const std::optional<double> number = io::ParseNumber(pair.value)) {
    (*point_)[pair.code / 10 - 1] = *number;
    return {};
  }
  return Fail(ErrorCode::kUnreadable,
              fmt::format("line {} is not a coordinate: \"{:.60}\"; export the drawing "
                          "again",
                          pairs_.line_number(), pair.value));
}

Status PointReader::EndPoint() {
  if (!point_) return {};
  const Vec3 p_mm = *point_ * unit_mm_;
  point_.reset();
  if (!p_mm.allFinite()) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format(
            "the POINT before line {} is at ({}, {}, {}), which is not finite; remove it",
            pairs_.line_number(), p_mm.x(), p_mm.y(), p_mm.z()));
  }
  if (table_.points_mm.size() >= limits_.max_points)
    return MorePointsThanAllowed(limits_);
  table_.points_mm.push_back(p_mm);
  return {};
}

/// The kind of object that a code 0 begins.
void PointReader::Begin(std::string_view what) {
  begins_section_ = what == "SECTION";
  if (what == "EOF") ended_ = true;
  if (what == "ENDSEC") section_ = {};
  if (section_ != "ENTITIES" || ended_) return;
  if (what == "POINT") {
    point_ = Vec3::Zero();
  } else if (what != "VERTEX" && what != "SEQEND") {  // parts of a POLYLINE
    ++passed_over_[what];
    ++passed_over_count_;
  }
}

Status PointReader::Receive(const Pair& pair) {
  if (pair.code == 0) {
    INTAGLIO_TRY(EndPoint());
    Begin(pair.value);
    return {};
  }
  if (pair.code == 999) table_.comments.push_back(OneLine(pair.value));
  if (begins_section_ && pair.code == 2) {
    section_ = pair.value;
    begins_section_ = false;
  }
  if (section_ == "HEADER" && pair.code == 9) variable_ = pair.value;
  if (section_ == "HEADER" && pair.code == 70 && variable_ == "$INSUNITS") {
    return TakeUnit(pair.value);
  }
  const bool coordinate = pair.code == 10 || pair.code == 20 || pair.code == 30;
  if (point_ && coordinate) return TakeCoordinate(pair);
  return {};
}

std::string PointReader::PassedOver() const {
  std::string text;
  constexpr int kMaxKinds = 8;
  int kinds = 0;
  for (const auto& [kind, count] : passed_over_) {
    if (++kinds > kMaxKinds) return text + ", ...";
    text += fmt::format("{}{:.30} {}", text.empty() ? "" : ", ", OneLine(kind), count);
  }
  return text;
}

Result<PointTable> PointReader::Read() {
  while (!ended_) {
    const auto pair = INTAGLIO_TRY(pairs_.Next());
    if (!pair) {
      return Fail(ErrorCode::kUnreadable,
                  fmt::format("it ends after line {} without EOF, so it is truncated; "
                              "export the drawing again",
                              pairs_.line_number()));
    }
    if (Status status = Receive(*pair); !status) return tl::unexpected(status.error());
  }
  if (!io::TextBehind(pairs_.rest(), 0).empty()) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("there is more behind its EOF (line {}), of which nothing "
                            "would be read; divide the file, or delete it",
                            pairs_.line_number()));
  }
  if (table_.points_mm.empty()) {
    return Fail(ErrorCode::kMissing,
                passed_over_count_ == 0
                    ? std::string("it has no POINT; draw points in its model space")
                    : fmt::format("it has no POINT, only {}; import it as a drawing, "
                                  "which makes points along its curves",
                                  PassedOver()));
  }
  if (passed_over_count_ > 0) {
    table_.comments.push_back(
        fmt::format("{} other than POINT {} ignored: {}",
                    Counted(passed_over_count_, "entity", "entities"),
                    WasOrWere(passed_over_count_), PassedOver()));
  }
  return std::move(table_);
}

void AppendPair(int code, std::string_view value, std::string& text) {
  text += fmt::format("{}\n{}\n", code, value);
}

}  // namespace

Status WriteDxf(const std::filesystem::path& file, const PointTable& table) {
  RequireWritable(table);
  io::AtomicFile out = INTAGLIO_TRY(io::AtomicFile::Create(file));
  std::string text;
  for (const std::string& comment : table.comments) AppendPair(999, comment, text);
  text +=
      "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n"
      "0\nSECTION\n2\nENTITIES\n";
  for (const Vec3& p : table.points_mm) {
    text += "0\nPOINT\n8\npoints\n";
    for (int axis = 0; axis < 3; ++axis) {
      text += fmt::format("{}\n", 10 * (axis + 1));
      io::AppendShortestFixed(p[axis], text);
      text += '\n';
    }
    INTAGLIO_TRY(out.Write(text));
    text.clear();
  }
  text += "0\nENDSEC\n0\nEOF\n";
  INTAGLIO_TRY(out.Write(text));
  return out.Commit();
}

Result<PointTable> ParseDxf(std::string_view bytes, const PointFileLimits& limits) {
  if (bytes.starts_with("AutoCAD Binary DXF")) {
    return Fail(ErrorCode::kUnsupported,
                "it is a binary DXF; save the drawing as ASCII DXF");
  }
  return PointReader(bytes, limits).Read();
}

}  // namespace intaglio::formats
