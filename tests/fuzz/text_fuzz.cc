#include <cstdint>
#include <string>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/drawing/utf8_characters.h"
#include "services/job/convert/placeholders.h"

// The text of a job: characters that are read come back, and so does what a table gives.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using intaglio::Require;
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  const auto characters = intaglio::drawing::CharactersOf(text);
  if (characters) {
    Require(intaglio::drawing::Utf8Of(*characters) == text, "other characters");
  } else {
    Require(!characters.error().message.empty(), "an error without a sentence");
  }
  const auto nothing = [](const std::string&) { return std::nullopt; };
  Require(intaglio::FillPlaceholders(text, nothing) == text, "another text");
  const std::string value = intaglio::WithDoubledBraces(text);
  Require(intaglio::PlaceholdersOf(value).empty(), "a value with a placeholder");
  Require(intaglio::NumberedText(value, 1) == text, "another value");
  (void)intaglio::NumberedText(text, 1);
  return 0;
}
