#include "engrave/galvo/files/ct5_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/core/try.h"

namespace intaglio::galvo {
namespace {

constexpr int kMiddle = (kCt5Nodes - 1) / 2;
constexpr double kFullOutput = (1 << 20) - 1;
// The share of full output that the calibration angle means, by the maker.
constexpr double kCalibratedShare = 0.96;

double NodeBits(int i) { return static_cast<double>(i - kMiddle) * kCt5NodeBits; }

std::int32_t Output(double bits) {
  return static_cast<std::int32_t>(
      std::lround(std::clamp(bits + kCt5Zero, 0.0, kFullOutput)));
}

Status CheckCalibration(int bit_per_mm) {
  if (bit_per_mm >= 1 && bit_per_mm <= 1 << 20) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("a calibration of {} bit/mm; give 1..{}", bit_per_mm, 1 << 20),
              fmt::format("{}", bit_per_mm));
}

Ct5 EmptyCt5(int bit_per_mm) {
  Ct5 file;
  file.header[kCt5Calibration] = bit_per_mm;
  for (auto& table : file.tables)
    table.assign(std::size_t{kCt5Nodes} * kCt5Nodes, kCt5Zero);
  return file;
}

/// Tables 2 and 3 from the outputs, in bits: the target t with output(t) = node.
void FillInverse(const CorrectionTable& outputs_bits, Ct5& file) {
  constexpr int kSteps = 60;
  for (int y = 0; y < kCt5Nodes; ++y) {
    for (int x = 0; x < kCt5Nodes; ++x) {
      const Vec2 node(NodeBits(x), NodeBits(y));
      Vec2 by = Vec2::Zero();
      for (int i = 0; i < kSteps; ++i) {
        const Vec2 next = -outputs_bits.At(node + by);
        const bool same = (next - by).norm() < 1e-3;
        by = next;
        if (same) break;
      }
      const std::size_t at = Ct5::IndexOf(x, y);
      file.tables[2][at] = static_cast<std::int32_t>(std::lround(by.x())) + kCt5Zero;
      file.tables[3][at] = static_cast<std::int32_t>(std::lround(by.y())) + kCt5Zero;
    }
  }
}

Status FillFrom(const Ct5& outputs, Ct5& file) {
  FieldGrid bits{kCt5Nodes, NodeBits(0), kCt5NodeBits, {}};
  for (int y = 0; y < kCt5Nodes; ++y) {
    for (int x = 0; x < kCt5Nodes; ++x) {
      const std::size_t at = Ct5::IndexOf(x, y);
      bits.values_mm.emplace_back(outputs.tables[0][at] - kCt5Zero - NodeBits(x),
                                  outputs.tables[1][at] - kCt5Zero - NodeBits(y));
    }
  }
  const auto table =
      INTAGLIO_TRY(CorrectionTable::Make(std::move(bits), Interpolation::kBilinear));
  FillInverse(table, file);
  return {};
}

}  // namespace

FieldGrid GridOf(const Ct5& file) {
  const double mm = 1.0 / file.header[kCt5Calibration];
  FieldGrid grid{kCt5Nodes, NodeBits(0) * mm, kCt5NodeBits * mm, {}};
  for (int y = 0; y < kCt5Nodes; ++y) {
    for (int x = 0; x < kCt5Nodes; ++x) {
      const std::size_t at = Ct5::IndexOf(x, y);
      grid.values_mm.emplace_back(mm * (file.tables[0][at] - kCt5Zero - NodeBits(x)),
                                  mm * (file.tables[1][at] - kCt5Zero - NodeBits(y)));
    }
  }
  return grid;
}

Result<Ct5> Ct5Of(const CorrectionTable& commands, int bit_per_mm, const Ct5* like) {
  INTAGLIO_TRY(CheckCalibration(bit_per_mm));
  Ct5 file = EmptyCt5(bit_per_mm);
  if (like != nullptr) file.header = like->header;
  file.header[kCt5Calibration] = bit_per_mm;
  for (int y = 0; y < kCt5Nodes; ++y) {
    for (int x = 0; x < kCt5Nodes; ++x) {
      const Vec2 target(NodeBits(x), NodeBits(y));
      const Vec2 bits = target + bit_per_mm * commands.At(target / bit_per_mm);
      const std::size_t at = Ct5::IndexOf(x, y);
      file.tables[0][at] = Output(bits.x());
      file.tables[1][at] = Output(bits.y());
    }
  }
  INTAGLIO_TRY(FillFrom(file, file));
  return file;
}

Result<Ct5> Ct5OfHead(const Head& head, int bit_per_mm, double calibration_angle_deg) {
  INTAGLIO_TRY(CheckHead(head));
  INTAGLIO_TRY(CheckCalibration(bit_per_mm));
  if (!(calibration_angle_deg > 0 && calibration_angle_deg < 45)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("a calibration angle of {} degrees; give one above 0 and "
                            "below 45, mechanical",
                            calibration_angle_deg),
                fmt::format("{}", calibration_angle_deg));
  }
  Ct5 file = EmptyCt5(bit_per_mm);
  file.header[kCt5FocalLength] =
      static_cast<std::int32_t>(std::lround(20 * head.heights_mm[0]));
  file.header[kCt5CalibrationAngle] =
      static_cast<std::int32_t>(std::lround(1000 * calibration_angle_deg));
  const double bit_per_rad = kCalibratedShare * kCt5Zero / calibration_angle_deg * 90 /
                             std::numbers::pi;  // optical: half of it is mechanical
  for (int y = 0; y < kCt5Nodes; ++y) {
    for (int x = 0; x < kCt5Nodes; ++x) {
      const Vec2 place_mm = Vec2(NodeBits(x), NodeBits(y)) / bit_per_mm;
      const Vec2 angles_rad = INTAGLIO_TRY(AnglesFor(place_mm, head));
      const std::size_t at = Ct5::IndexOf(x, y);
      file.tables[0][at] = Output(bit_per_rad * angles_rad.x());
      file.tables[1][at] = Output(bit_per_rad * angles_rad.y());
    }
  }
  INTAGLIO_TRY(FillFrom(file, file));
  return file;
}

}  // namespace intaglio::galvo
