#pragma once

// A virtual BJJCZ board at the driver of its family, behind a line that a test cuts.

#include <chrono>
#include <memory>
#include <random>
#include <string>

#include "services/drivers/mark_driver.h"
#include "tests/services/drivers/bjjcz/virtual_bjjcz.h"
#include "tests/services/drivers/marks/mark_rig.h"
#include "tests/services/platform/link/faulty_line.h"

namespace intaglio::drivers {

inline constexpr int kBjjczDoorInput = 3;
inline constexpr const char* kBjjczSerialNumber = "000142420017";

/// A field of 100 mm, jumps of 5 m/s.
MachineSpec BjjczProfile(BjjczLaser laser);

/// Board, line and mains switch, on a clock that the test moves by 1 ms.
class BjjczMachine {
 public:
  explicit BjjczMachine(BjjczLaser laser);
  BjjczMachine(const BjjczMachine&) = delete;
  BjjczMachine& operator=(const BjjczMachine&) = delete;

  void Advance();
  void Cut(bool cut);
  void SwitchOff() { board.SwitchOff(); }
  void SwitchOn() { board.SwitchOn(); }
  std::unique_ptr<MarkDriver> MakeDriver(const MachineSpec& profile);

  bjjcz::VirtualBjjcz board;

 private:
  std::chrono::nanoseconds now_ = std::chrono::hours(3);
  std::shared_ptr<link::FaultyPipe> to_board_, to_host_;
  std::shared_ptr<std::mt19937_64> random_ = std::make_shared<std::mt19937_64>(1);
  std::unique_ptr<link::ByteStream> end_;
};

std::unique_ptr<MarkRig> MakeBjjczMarkRig(const std::string& name,
                                          const std::string& serial_number);

}  // namespace intaglio::drivers
