#include "engrave/formats/tool_way.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "engrave/core/try.h"
#include "engrave/io/crc32.h"
#include "engrave/io/whole_file.h"

namespace intaglio::formats {
namespace {

static_assert(std::endian::native == std::endian::little,
              "numbers are copied as they lie in memory");
constexpr char kToolWayMagic[] = "INTTOOL1";
constexpr std::uint32_t kToolWayVersion = 1;
constexpr std::size_t kMaxToolWayFile = std::size_t{1} << 30;

template <typename T>
void PutToolNumber(std::byte* at, T value) {
  std::memcpy(at, &value, sizeof value);
}

template <typename T>
T ToolNumber(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

bool HasCrcAt44(const std::byte* at) {
  return ToolNumber<std::uint32_t>(at + 44) == io::Crc32({at, 44});
}

Result<ToolWayHeader> ParseToolWayHeader(const std::byte* at) {
  if (const auto version = ToolNumber<std::uint32_t>(at + 8);
      version != kToolWayVersion) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("the record of a tool's way has version {}; this program "
                            "reads {}",
                            version, kToolWayVersion),
                fmt::format("{}", version));
  }
  const ToolWayHeader header{ToolNumber<double>(at + 16), ToolNumber<double>(at + 24),
                             ToolNumber<double>(at + 32),
                             ToolNumber<std::uint32_t>(at + 40) == 1};
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
  std::vector<std::byte> bytes(kToolWayHeaderSize);
  std::memcpy(bytes.data(), kToolWayMagic, 8);
  PutToolNumber(bytes.data() + 8, kToolWayVersion);
  PutToolNumber(bytes.data() + 12, static_cast<std::uint32_t>(kToolWayStepSize));
  PutToolNumber(bytes.data() + 16, header.tool_diameter_mm);
  PutToolNumber(bytes.data() + 24, header.sheet_thickness_mm);
  PutToolNumber(bytes.data() + 32, header.sheet_height_mm);
  PutToolNumber(bytes.data() + 40, std::uint32_t{header.is_laser});
  PutToolNumber(bytes.data() + 44, io::Crc32(std::span(bytes).first(44)));
  return bytes;
}

void AppendToolWayStep(const ToolWayStep& step, std::vector<std::byte>& out) {
  const std::size_t begin = out.size();
  out.resize(begin + kToolWayStepSize);
  std::byte* at = out.data() + begin;
  PutToolNumber(at, step.end_us);
  for (int axis = 0; axis < 3; ++axis)
    PutToolNumber(at + 8 + 8 * axis, step.end_mm[axis]);
  PutToolNumber(at + 32, step.power);
  PutToolNumber(at + 40, std::uint32_t{step.is_on});
  PutToolNumber(at + 44, io::Crc32({at, 44}));
}

Result<ToolWay> ParseToolWay(std::span<const std::byte> bytes) {
  if (bytes.size() < kToolWayHeaderSize ||
      std::memcmp(bytes.data(), kToolWayMagic, 8) != 0 || !HasCrcAt44(bytes.data())) {
    return Fail(ErrorCode::kUnreadable,
                "not a record of a tool's way: its header is missing or damaged");
  }
  ToolWay way;
  way.header = INTAGLIO_TRY(ParseToolWayHeader(bytes.data()));
  std::size_t offset = kToolWayHeaderSize;
  way.steps.reserve((bytes.size() - offset) / kToolWayStepSize);
  for (; offset + kToolWayStepSize <= bytes.size(); offset += kToolWayStepSize) {
    const std::byte* at = bytes.data() + offset;
    if (!HasCrcAt44(at)) break;
    ToolWayStep step;
    step.end_us = ToolNumber<std::uint64_t>(at);
    for (int axis = 0; axis < 3; ++axis)
      step.end_mm[axis] = ToolNumber<double>(at + 8 + 8 * axis);
    step.power = ToolNumber<double>(at + 32);
    step.is_on = ToolNumber<std::uint32_t>(at + 40) == 1;
    if (!step.end_mm.allFinite() || !std::isfinite(step.power)) break;
    way.steps.push_back(step);
  }
  way.torn_bytes = bytes.size() - offset;
  return way;
}

Result<ToolWay> ReadToolWay(const std::filesystem::path& file) {
  const std::string text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxToolWayFile));
  return ParseToolWay(std::as_bytes(std::span(text))).map_error([&](Error error) {
    error.message = file.string() + ": " + error.message;
    return error;
  });
}

}  // namespace intaglio::formats
