// The first line is the text of a code, what follows a table: refused with the field, or
// each repeat has a text without anything left to be filled in.

#include <cstdint>
#include <string_view>

#include "engrave/core/check.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/convert/placeholders.h"
#include "services/job/marks/mark_table.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  const std::string_view input(reinterpret_cast<const char*>(bytes), size);
  const std::size_t line = std::min(input.find('\n'), input.size());
  Marks marks;
  marks.set_table("rows.csv");
  marks.add_items()->mutable_code()->set_text(std::string(input.substr(0, line)));
  marks.mutable_repeats()->set_pitch_mm(1);
  marks = WithDefaults(std::move(marks));
  const auto table = MarkTable::Make(
      marks, {"rows.csv", input.substr(std::min(line + 1, input.size()))});
  if (!table) {
    Require(table.error().message.starts_with("marks."), "an error without its field: {}",
            table.error().message);
    return 0;
  }
  Require(table->repeat_count() > 0, "no repeat");
  for (std::size_t repeat = 0; repeat < table->repeat_count() && repeat < 50; ++repeat) {
    const auto item = table->Fill(marks.items(0), "marks.items[0]", repeat);
    if (!item) {
      Require(item.error().message.starts_with("marks.items[0]"),
              "an error without its field: {}", item.error().message);
      break;
    }
    Require(MarkTable::Varies(marks.items(0)) ||
                item->code().text() == marks.items(0).code().text() ||
                marks.items(0).code().text().find_first_of("{}") != std::string::npos,
            "another text");
    (void)table->NameOf(marks.items(0), repeat);
  }
  return 0;
}
