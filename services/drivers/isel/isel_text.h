#pragma once

// The text of isel's stepper controllers: commands, answers as values, and their errors
// as sentences. A command begins with '@', the device's number 0, and ends in CR. An
// answer is one character without a line end, '0' when the command is done; behind the
// '0' to @0P come 6 hexadecimal digits an axis, 24 bits in two's complement, in steps.
//
// As an answer does not tell which command it is of, and how long it is, the reader is
// given what is expected before a command is sent.
//
// The facts that it follows are the tests of virtual_isel_test.cc; the letters are those
// of controllers with the CNC operating system 5, and differ by model (MC1: a, r).

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace intaglio::drivers {

/// Places of x, y, z in steps, -8388608..8388607.
using IselSteps = std::array<std::int32_t, 3>;
inline constexpr std::int32_t kIselMaxSteps = 8388607;

enum class IselExpected : std::uint8_t { kCode, kPlace };

struct IselAnswer {
  char code = '0';
  std::optional<IselSteps> place;  ///< of @0P that was answered with '0'
};

/// Answers out of bytes, in the order in which they are expected. Never fails.
class IselAnswerReader {
 public:
  void Expect(IselExpected what) { expected_.push_back(what); }
  bool is_expecting() const { return !expected_.empty(); }
  void Clear();
  /// Bytes that nothing expects are dropped. A digit that is none ends the place: its
  /// answer has no place.
  void Feed(std::span<const std::byte> bytes, std::vector<IselAnswer>& answers);

 private:
  void End(std::optional<IselSteps> place, std::vector<IselAnswer>& answers);

  std::deque<IselExpected> expected_;
  std::string digits_;  // of a place
  bool in_place_ = false;
};

// Commands, each with its CR.
inline constexpr char kIselInit[] = "@07\r";
inline constexpr char kIselHome[] = "@0R7\r";
inline constexpr char kIselPlace[] = "@0P\r";
inline constexpr char kIselOff[] = "@0B1,0\r";
/// The output on and off, in one write: so nothing but a cut between both leaves it on.
inline constexpr char kIselPulse[] = "@0B1,1\r@0B1,0\r";
/// A move by nothing: it is answered by what would hold a move back.
inline constexpr char kIselNoMove[] = "@0A0,100,0,100,0,100,0,100\r";
inline constexpr char kIselStopByte = static_cast<char>(253);

/// To a place, at the speeds of the axes in steps/s.
std::string IselMove(const IselSteps& to, const IselSteps& speed);

/// What a controller means by an answer other than '0', for people.
std::string TextOfIselError(char code);

}  // namespace intaglio::drivers
