#include "engrave/formats/tool_way.h"

#include <fmt/format.h>

#include <cmath>

#include "engrave/core/try.h"
#include "engrave/formats/record_file.h"

namespace intaglio::formats {
namespace {

constexpr RecordKind kToolWay{"INTTOOL1", "record of a tool's way", 1,
                              1,          kToolWayHeaderSize,       kToolWayStepSize};
constexpr std::size_t kMaxToolWayFile = std::size_t{1} << 30;

Result<ToolWayHeader> ParseToolWayHeader(const std::byte* at) {
  const ToolWayHeader header{NumberAt<double>(at + 16), NumberAt<double>(at + 24),
                             NumberAt<double>(at + 32),
                             NumberAt<std::uint32_t>(at + 40) == 1};
  const auto is_size = [](double mm) { return std::isfinite(mm) && mm > 0; };
  if (is_size(header.tool_diameter_mm) && is_size(header.sheet_thickness_mm) &&
      std::isfinite(header.sheet_height_mm))
    return header;
  return Fail(ErrorCode::kUnreadable,
              fmt::format("the record of a tool's way has a tool of {} mm and a sheet of "
                          "{} mm at {} mm",
                          header.tool_diameter_mm, header.sheet_thickness_mm,
                          header.sheet_height_mm));
}

}  // namespace

std::vector<std::byte> EncodeToolWayHeader(const ToolWayHeader& header) {
  std::vector<std::byte> bytes = NewRecordHeader(kToolWay);
  PutNumber(bytes.data() + 16, header.tool_diameter_mm);
  PutNumber(bytes.data() + 24, header.sheet_thickness_mm);
  PutNumber(bytes.data() + 32, header.sheet_height_mm);
  PutNumber(bytes.data() + 40, std::uint32_t{header.is_laser});
  Seal(bytes);
  return bytes;
}

void AppendToolWayStep(const ToolWayStep& step, std::vector<std::byte>& out) {
  const std::span<std::byte> record = AppendRecord(kToolWay, out);
  std::byte* at = record.data();
  PutNumber(at, step.end_us);
  for (int axis = 0; axis < 3; ++axis) PutNumber(at + 8 + 8 * axis, step.end_mm[axis]);
  PutNumber(at + 32, step.power);
  PutNumber(at + 40, std::uint32_t{step.is_on});
  Seal(record);
}

Result<ToolWay> ParseToolWay(std::span<const std::byte> bytes) {
  INTAGLIO_TRY(CheckRecordHeader(kToolWay, bytes));
  ToolWay way;
  way.header = INTAGLIO_TRY(ParseToolWayHeader(bytes.data()));
  way.steps.reserve(RecordRoom(kToolWay, bytes));
  way.torn_bytes = ReadRecords(kToolWay, bytes, [&](const std::byte* at) {
    ToolWayStep step;
    step.end_us = NumberAt<std::uint64_t>(at);
    for (int axis = 0; axis < 3; ++axis)
      step.end_mm[axis] = NumberAt<double>(at + 8 + 8 * axis);
    step.power = NumberAt<double>(at + 32);
    step.is_on = NumberAt<std::uint32_t>(at + 40) == 1;
    if (!step.end_mm.allFinite() || !std::isfinite(step.power)) return false;
    way.steps.push_back(step);
    return true;
  });
  return way;
}

Result<ToolWay> ReadToolWay(const std::filesystem::path& file) {
  return ReadRecordFile(file, kMaxToolWayFile, ParseToolWay);
}

}  // namespace intaglio::formats
