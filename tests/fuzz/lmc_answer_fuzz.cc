#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engrave/core/check.h"
#include "services/drivers/bjjcz/bjjcz_driver.h"

namespace {

using namespace intaglio;

/// What a board sends is the input, a few bytes at each reading.
class Scripted final : public link::ByteStream {
 public:
  Scripted(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes), size_(size) {}
  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    const std::size_t count = std::min({buffer.size(), size_ - at_, paused_ ? 0UL : 8UL});
    std::copy_n(reinterpret_cast<const std::byte*>(bytes_ + at_), count, buffer.data());
    at_ += count;
    paused_ = !paused_;
    return count;
  }
  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    return bytes.size();
  }
  int fd() const override { return -1; }

 private:
  const std::uint8_t* bytes_;
  std::size_t size_, at_ = 0;
  bool paused_ = false;
};

}  // namespace

// Whatever a board answers, a mark ends at most once, and never before it was begun.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace std::chrono_literals;
  MachineSpec machine;
  machine.mutable_scan_head()->set_field_mm(100);
  machine.mutable_scan_head()->set_jump_mm_s(5000);
  machine.mutable_bjjcz_board()->set_laser(BJJCZ_LASER_UV);
  machine.mutable_bjjcz_board()->set_door_input(0);
  std::chrono::nanoseconds now = 1h;
  const auto driver = drivers::MakeBjjczDriver(
      machine,
      [&]() -> Result<std::unique_ptr<link::ByteStream>> {
        return std::make_unique<Scripted>(bytes, size);
      },
      [&] { return now; });
  mark::Pen pen;
  pen.speed_mm_s = 1000;
  pen.frequency_hz = 30000;
  std::uint32_t run = 0;
  std::vector<drivers::MarkFate> last;
  for (std::size_t step = 0; step < size / 4 + 100; ++step) {
    now += 1ms;
    (void)driver->Permit(true);
    driver->Poll();
    (void)driver->Reset();
    if (driver->state().settled && driver->Begin(run + 1, {&pen, 1})) {
      ++run;
      last.clear();
      if (driver->Append({0, {0, false, 0, {{Vec2(0, 0)}, {Vec2(1, 0)}}}}))
        (void)driver->Finish();
    }
    for (const drivers::MarkEvent& event : driver->TakeEvents()) {
      if (event.run != run) continue;
      Require(last.empty() == (event.fate == drivers::MarkFate::kBegun) ||
                  event.fate == drivers::MarkFate::kNotBegun,
              "a fate of {} behind {} others", static_cast<int>(event.fate), last.size());
      last.push_back(event.fate);
      Require(last.size() <= 2, "a mark has {} fates", last.size());
    }
  }
  return 0;
}
