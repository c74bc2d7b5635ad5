#include "services/virtual_engraver/truth/truth_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "services/platform/fields/field_defaults.h"

namespace intaglio {
namespace {

// What a laser controller's identity can list (services/platform/link/laser_protocol.h).
constexpr int kMaxRates = 32;
constexpr int kMaxInputs = 8;
// What a controller's identity can report.
constexpr std::size_t kMaxSerialNumber = 64;
// What a glass record can number (engrave/formats/glass_record.h), less the first.
constexpr int kMaxFurtherStations = 63;
constexpr int kMaxObstacles = 64;

class Checker {
 public:
  void CheckNumbers(const MachineTruth& truth) {
    for (NumberFault& fault : NumbersOutOfRange(truth, ""))
      errors_.push_back(std::move(fault.error));
  }

  void CheckSerialNumber(const std::string& text, const std::string& path) {
    const bool printable = std::all_of(text.begin(), text.end(),
                                       [](char c) { return c >= ' ' && c <= '~'; });
    if (printable && text.size() <= kMaxSerialNumber) return;
    Add(path, fmt::format("{:?}", text), "is not 0 to 64 printable ASCII characters");
  }

  void CheckTravel(const TruthStage& stage) {
    const auto axis = [this](const char* name, double min_mm, double max_mm) {
      if (!(min_mm >= max_mm)) return;
      Add(fmt::format("stage.travel_min_mm.{}", name), fmt::format("{}", min_mm),
          fmt::format("is not below stage.travel_max_mm.{}, {}", name, max_mm));
    };
    Vector3 max = stage.travel_max_mm();
    if (!stage.has_travel_max_mm()) {
      const double max_mm = DefaultOf<TruthStage>(TruthStage::kTravelMaxMmFieldNumber);
      max.set_x(max_mm), max.set_y(max_mm), max.set_z(max_mm);
    }
    axis("x", stage.travel_min_mm().x(), max.x());
    axis("y", stage.travel_min_mm().y(), max.y());
    axis("z", stage.travel_min_mm().z(), max.z());
  }

  void CheckBlockStage(const TruthStage& stage) {
    // A file that changes something else of it has no travel.
    const TruthBlockStage& block_stage = stage.block_stage();
    if (!block_stage.has_travel_min_mm() && !block_stage.has_travel_max_mm()) return;
    const Vector3 &min = block_stage.travel_min_mm(), &max = block_stage.travel_max_mm();
    if (min.x() < max.x() && min.y() < max.y()) return;
    Add("stage.block_stage.travel_min_mm", fmt::format("{}, {}", min.x(), min.y()),
        "is not below travel_max_mm in x and y");
  }

  void CheckDeviations(const TruthMirrors& mirrors) {
    if (!mirrors.has_deviations()) return;
    const TruthDeviations& all = mirrors.deviations();
    const auto nodes = static_cast<int>(all.nodes_a_side());
    if (all.x_nm_size() == nodes * nodes && all.y_nm_size() == nodes * nodes) return;
    Add("stage.positioner.mirrors.deviations",
        fmt::format("{} and {} numbers", all.x_nm_size(), all.y_nm_size()),
        fmt::format("are not nodes_a_side squared, {}", nodes * nodes));
  }

  void CheckOffsets(const TruthLaser& laser) {
    if (laser.channel_offset_mm_size() <= 3) return;
    Add("laser.channel_offset_mm",
        fmt::format("{} places", laser.channel_offset_mm_size()),
        "are more than 3, of channels 2 to 4");
  }

  void CheckStations(const TruthBlock& block) {
    if (block.stations_size() <= kMaxFurtherStations) return;
    Add("block.stations", fmt::format("{} stations", block.stations_size()),
        fmt::format("are more than {}", kMaxFurtherStations));
  }

  void CheckObstacles(const MachineTruth& truth) {
    if (truth.obstacles_size() > kMaxObstacles) {
      Add("obstacles", fmt::format("{} obstacles", truth.obstacles_size()),
          fmt::format("are more than {}", kMaxObstacles));
    }
    for (int i = 0; i < truth.obstacles_size(); ++i) {
      const Vector3 &min = truth.obstacles(i).min_mm(),
                    &max = truth.obstacles(i).max_mm();
      if (min.x() < max.x() && min.y() < max.y() && min.z() < max.z()) continue;
      Add(fmt::format("obstacles[{}].min_mm", i),
          fmt::format("{}, {}, {}", min.x(), min.y(), min.z()),
          "is not below max_mm in each axis");
    }
  }

  void CheckAxisDrives(const TruthStage& stage) {
    for (int i = 0; i < stage.axis_drives_size(); ++i) {
      const TruthAxisDrive& drive = stage.axis_drives(i);
      const std::string path = fmt::format("stage.axis_drives[{}]", i);
      if (drive.drive_case() == TruthAxisDrive::DRIVE_NOT_SET)
        Add(path, fmt::format("axis {}", drive.axis()), "has no drive");
      for (int k = 0; k < i; ++k) {
        if (stage.axis_drives(k).axis() != drive.axis()) continue;
        Add(path + ".axis", fmt::format("{}", drive.axis()), "occurs twice");
      }
    }
  }

  void CheckRates(const TruthLaser& laser) {
    if (laser.rates_hz_size() <= kMaxRates) return;
    Add("laser.rates_hz", fmt::format("{} rates", laser.rates_hz_size()),
        fmt::format("are more than {}", kMaxRates));
  }

  void CheckInputs(const TruthLaser& laser) {
    if (laser.inputs_size() <= kMaxInputs) return;
    Add("laser.inputs", fmt::format("{} inputs", laser.inputs_size()),
        fmt::format("are more than {}", kMaxInputs));
  }

  std::vector<Error> Take() { return std::move(errors_); }

 private:
  void Add(const std::string& path, const std::string& value, const std::string& what) {
    errors_.push_back(
        {ErrorCode::kInvalidValue, fmt::format("{}: {} {}", path, value, what), value});
  }

  std::vector<Error> errors_;
};

}  // namespace

std::vector<Error> CheckTruth(const MachineTruth& truth) {
  Checker checker;
  checker.CheckNumbers(truth);
  checker.CheckTravel(truth.stage());
  checker.CheckAxisDrives(truth.stage());
  checker.CheckBlockStage(truth.stage());
  checker.CheckSerialNumber(truth.stage().serial_number(), "stage.serial_number");
  checker.CheckRates(truth.laser());
  checker.CheckInputs(truth.laser());
  checker.CheckDeviations(truth.stage().positioner().mirrors());
  checker.CheckOffsets(truth.laser());
  checker.CheckStations(truth.block());
  checker.CheckObstacles(truth);
  checker.CheckSerialNumber(truth.laser().serial_number(), "laser.serial_number");
  checker.CheckSerialNumber(truth.head().serial_number(), "head.serial_number");
  checker.CheckSerialNumber(truth.mill().serial_number(), "mill.serial_number");
  return checker.Take();
}

}  // namespace intaglio
