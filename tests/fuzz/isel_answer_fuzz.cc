#include <cstdint>
#include <string>
#include <vector>

#include "engrave/core/check.h"
#include "services/drivers/isel/isel_text.h"

// Whatever a controller sends, in pieces of any length: no more answers than were
// expected, and places of 24 bits. The first byte chooses what is expected.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio::drivers;
  using intaglio::Require;
  if (size < 2) return 0;
  IselAnswerReader reader;
  std::size_t expected = 0;
  for (int bit = 0; bit < 8; ++bit, ++expected) {
    reader.Expect((bytes[0] >> bit & 1) != 0 ? IselExpected::kPlace
                                             : IselExpected::kCode);
  }
  std::vector<IselAnswer> answers;
  for (std::size_t at = 1; at < size;) {
    const std::size_t count = std::min<std::size_t>(size - at, bytes[at] % 7 + 1);
    reader.Feed(std::as_bytes(std::span(bytes + at, count)), answers);
    at += count;
  }
  Require(answers.size() <= expected, "{} answers", answers.size());
  Require(reader.is_expecting() == (answers.size() < expected), "an answer is lost");
  for (const IselAnswer& answer : answers) {
    Require(!TextOfIselError(answer.code).empty(), "no sentence");
    if (!answer.place) continue;
    for (const std::int32_t steps : *answer.place)
      Require(steps >= -kIselMaxSteps - 1 && steps <= kIselMaxSteps, "{} steps", steps);
  }
  return 0;
}
