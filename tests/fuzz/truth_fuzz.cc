// Any bytes as a truth file: refused with a message, or a truth that a machine can be
// built from and that reads back the same when it is written.

#include <google/protobuf/text_format.h>
#include <google/protobuf/util/message_differencer.h>

#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "services/virtual_engraver/truth/truth_file.h"
#include "services/virtual_engraver/truth_options.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  const auto truth =
      ParseTruth({reinterpret_cast<const char*>(bytes), size}, "fuzz.textproto");
  if (!truth) {
    if (truth.error().message.empty()) std::abort();
    return 0;
  }
  virtual_engraver::Stage stage(virtual_engraver::OptionsOf(*truth).stage);
  for (int i = 0; i < 3; ++i) stage.AdvanceTick(100);
  if (!stage.place_mm().allFinite()) std::abort();
  std::string written;
  if (!google::protobuf::TextFormat::PrintToString(*truth, &written)) std::abort();
  const auto again = ParseTruth(written, "written");
  if (!again || !google::protobuf::util::MessageDifferencer::Equals(*again, *truth))
    std::abort();
  return 0;
}
