#include "services/drivers/isel/isel_text.h"

#include <fmt/format.h>

#include <charconv>
#include <utility>

namespace intaglio::drivers {
namespace {

constexpr std::size_t kDigitsPerAxis = 6, kAxes = 3;

bool IsHex(char digit) {
  return (digit >= '0' && digit <= '9') || (digit >= 'A' && digit <= 'F') ||
         (digit >= 'a' && digit <= 'f');
}

IselSteps PlaceOf(const std::string& digits) {
  IselSteps place{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    std::uint32_t bits = 0;
    const char* first = digits.data() + i * kDigitsPerAxis;
    std::from_chars(first, first + kDigitsPerAxis, bits, 16);
    place[i] = static_cast<std::int32_t>(bits);
    if (bits >= 0x800000u) place[i] -= 0x1000000;
  }
  return place;
}

}  // namespace

void IselAnswerReader::Clear() {
  expected_.clear();
  digits_.clear();
  in_place_ = false;
}

void IselAnswerReader::End(std::optional<IselSteps> place,
                           std::vector<IselAnswer>& answers) {
  answers.push_back({'0', place});
  expected_.pop_front();
  digits_.clear();
  in_place_ = false;
}

void IselAnswerReader::Feed(std::span<const std::byte> bytes,
                            std::vector<IselAnswer>& answers) {
  for (const std::byte byte : bytes) {
    const auto character = static_cast<char>(byte);
    if (expected_.empty()) continue;
    if (in_place_) {
      if (!IsHex(character)) {
        End(std::nullopt, answers);
        continue;
      }
      digits_ += character;
      if (digits_.size() == kAxes * kDigitsPerAxis) End(PlaceOf(digits_), answers);
    } else if (expected_.front() == IselExpected::kPlace && character == '0') {
      in_place_ = true;
    } else {
      answers.push_back({character, std::nullopt});
      expected_.pop_front();
    }
  }
}

std::string IselMove(const IselSteps& to, const IselSteps& speed) {
  return fmt::format("@0M{},{},{},{},{},{},0,{}\r", to[0], speed[0], to[1], speed[1],
                     to[2], speed[2], speed[2]);
}

std::string TextOfIselError(char code) {
  constexpr std::pair<char, const char*> kTexts[] = {
      {'2', "a limit switch was hit: home it"},
      {'5', "it does not know a command: check its model and software version"},
      {'7', "a command has the wrong number of parameters: check its model"},
      {'9', "it was reset or switched off"},
      {'D',
       "a speed is outside its range: lower max_speed_mm_s, or correct steps_per_mm"},
      {'F', "it was stopped at its own key"},
      {'H', "the cover or the chain of door and stop is open: close it"},
      {'R', "it has no reference: home it (intaglio teach home)"},
  };
  for (const auto& [known, text] : kTexts) {
    if (known == code) return text;
  }
  const bool printable = code > ' ' && code < '\x7f';
  return printable ? fmt::format("it answered '{}', which its manual explains", code)
                   : fmt::format(
                         "it answered with the byte {}: check the cable and the "
                         "baud rate",
                         static_cast<unsigned char>(code));
}

}  // namespace intaglio::drivers
