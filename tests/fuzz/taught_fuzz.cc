// Any text as a profile in which positions are taught: if it is one, then the changed
// text is the same profile with other positions.

#include <google/protobuf/text_format.h>
#include <google/protobuf/util/message_differencer.h>

#include <cstdint>
#include <string>

#include "engrave/core/check.h"
#include "proto/machine.pb.h"
#include "services/job/teach/profile_history.h"

namespace {

bool Parse(const std::string& text, intaglio::MachineSpec& machine) {
  google::protobuf::TextFormat::Parser parser;
  parser.RecordErrorsTo(nullptr);
  return parser.ParseFromString(text, &machine);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace intaglio;
  const std::string text(reinterpret_cast<const char*>(bytes), size);
  TaughtPositions taught;
  taught.set_number(7);
  const std::string changed = WithTaught(text, taught);
  MachineSpec before, after;
  if (!Parse(text, before)) return 0;
  if (!Parse(changed, after)) return 0;  // then the whole profile is written anew
  *before.mutable_taught() = taught;
  Require(google::protobuf::util::MessageDifferencer::Equals(before, after),
          "another profile");
  return 0;
}
