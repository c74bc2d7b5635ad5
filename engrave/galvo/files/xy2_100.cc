#include "engrave/galvo/files/xy2_100.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <iterator>

namespace intaglio::galvo {
namespace {

constexpr int kFrameBits = 20;
constexpr std::uint32_t kControl = 1;  // 001

class ValueChanges {
 public:
  explicit ValueChanges(std::string& text) : text_(text) {}

  void Begin(std::uint64_t time) { time_ = time, written_ = false; }
  /// A change of signal `i`, if it is one.
  void Set(std::size_t i, bool value) {
    if (states_[i] == static_cast<int>(value)) return;
    if (!written_) fmt::format_to(std::back_inserter(text_), "#{}\n", time_);
    written_ = true;
    states_[i] = value;
    text_ += value ? '1' : '0';
    text_ += kSymbols[i];
    text_ += '\n';
  }

  static constexpr std::array<char, 5> kSymbols = {'c', 's', 'x', 'y', 'l'};

 private:
  std::string& text_;
  std::uint64_t time_ = 0;
  bool written_ = false;
  std::array<int, 5> states_ = {-1, -1, -1, -1, -1};
};

}  // namespace

std::uint32_t Xy2Frame(std::uint16_t position) {
  const std::uint32_t frame = kControl << 17 | static_cast<std::uint32_t>(position) << 1;
  return frame | (static_cast<std::uint32_t>(std::popcount(frame)) & 1);
}

Result<std::uint16_t> ReadXy2Frame(std::uint32_t frame) {
  const auto fail = [frame](const char* what) {
    return Fail(ErrorCode::kUnreadable,
                fmt::format("the XY2-100 frame {:05X}h {}; check the line", frame, what),
                fmt::format("{:05X}", frame));
  };
  if (frame >> kFrameBits != 0) return fail("has more than 20 bits");
  if (frame >> 17 != kControl) return fail("does not begin with 001");
  if (std::popcount(frame) % 2 != 0) return fail("has an odd number of ones");
  return static_cast<std::uint16_t>(frame >> 1);
}

Result<std::string> WriteXy2Capture(std::span<const HeadOutput> outputs) {
  if (outputs.size() > kMaxXy2Frames) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("{} frames are more than the {} of a capture; write a part",
                            outputs.size(), kMaxXy2Frames),
                fmt::format("{}", outputs.size()));
  }
  std::string text =
      "$timescale 250 ns $end\n$scope module xy2_100 $end\n"
      "$var wire 1 c CLK $end\n$var wire 1 s SYNC $end\n$var wire 1 x X $end\n"
      "$var wire 1 y Y $end\n$var wire 1 l LASER $end\n"
      "$upscope $end\n$enddefinitions $end\n";
  ValueChanges changes(text);
  std::uint64_t time = 0;  // half periods of the clock
  for (const HeadOutput& output : outputs) {
    const std::uint32_t x = Xy2Frame(output.x), y = Xy2Frame(output.y);
    for (int bit = kFrameBits - 1; bit >= 0; --bit) {
      changes.Begin(time++);
      changes.Set(0, true);
      changes.Set(1, bit != 0);
      changes.Set(2, (x >> bit & 1) != 0);
      changes.Set(3, (y >> bit & 1) != 0);
      changes.Set(4, output.laser);
      changes.Begin(time++);
      changes.Set(0, false);
    }
  }
  fmt::format_to(std::back_inserter(text), "#{}\n", time);
  return text;
}

}  // namespace intaglio::galvo
