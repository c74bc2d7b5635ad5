#include "engrave/galvo/files/ct5.h"

#include <fmt/format.h>

#include <span>

#include "engrave/core/check.h"
#include "engrave/galvo/files/little_endian.h"
#include "engrave/io/crc32.h"

namespace intaglio::galvo {
namespace {

constexpr std::size_t kCt5Cells = std::size_t{kCt5Nodes} * kCt5Nodes;
constexpr std::int32_t kFullScale = 1 << 20;

std::uint32_t CheckOf(std::string_view bytes) {
  return ~io::Crc32(std::as_bytes(std::span(bytes.data(), bytes.size())));
}

}  // namespace

Result<Ct5> ReadCt5(std::string_view bytes, std::string_view name) {
  if (bytes.size() != kCt5Bytes) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("{}: has {} bytes, a .ct5 file has {}; give the file as the "
                            "control board's maker supplies it",
                            name, bytes.size(), kCt5Bytes),
                fmt::format("{}", bytes.size()));
  }
  Ct5 file;
  std::size_t at = 0;
  const auto take = [&bytes, &at](std::span<std::int32_t> numbers) {
    CopyLittleEndian(bytes, at, numbers);
    at += numbers.size_bytes();
  };
  take(file.header);
  for (auto& table : file.tables) {
    table.resize(kCt5Cells);
    take(table);
  }
  const auto check = LittleEndian<std::uint32_t>(bytes, at);
  if (check != CheckOf(bytes.substr(0, at))) file.kept_check = check;
  if (file.header[kCt5Calibration] <= 0) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{}: the calibration is {} bit/mm; give a file with one "
                            "above 0",
                            name, file.header[kCt5Calibration]),
                fmt::format("{}", file.header[kCt5Calibration]));
  }
  for (std::size_t t = 0; t < 2; ++t) {
    for (std::size_t i = 0; i < kCt5Cells; ++i) {
      const std::int32_t node = file.tables[t][i];
      if (node >= 0 && node <= kFullScale) continue;
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("{}: table {}, row {}, column {}: output {} is outside "
                              "0..{}; the file is damaged, copy it again",
                              name, t, i / kCt5Nodes, i % kCt5Nodes, node, kFullScale),
                  fmt::format("{}", node));
    }
  }
  return file;
}

std::string WriteCt5(const Ct5& file) {
  std::string bytes;
  bytes.reserve(kCt5Bytes);
  AppendLittleEndian(std::span<const std::int32_t>(file.header), bytes);
  for (const auto& table : file.tables) {
    Require(table.size() == kCt5Cells, "a .ct5 table of {} nodes, not {}", table.size(),
            kCt5Cells);
    AppendLittleEndian(std::span<const std::int32_t>(table), bytes);
  }
  AppendLittleEndian(file.kept_check.value_or(CheckOf(bytes)), bytes);
  return bytes;
}

}  // namespace intaglio::galvo
