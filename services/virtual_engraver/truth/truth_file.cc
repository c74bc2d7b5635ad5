#include "services/virtual_engraver/truth/truth_file.h"

#include <fmt/format.h>
#include <google/protobuf/text_format.h>

#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/whole_file.h"
#include "services/platform/text_format/text_format.h"
#include "services/virtual_engraver/truth/truth_check.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;

// The messages nest three deep.
constexpr int kMaxDepth = 8;

}  // namespace

Result<MachineTruth> ParseTruth(std::string_view text, const std::string& name) {
  INTAGLIO_TRY(
      CheckTextSize(text, name, kMaxTruthFileBytes, "a truth file (proto/truth.proto)"));
  MachineTruth truth;
  INTAGLIO_TRY(ParseTextFormat(text, name, kMaxDepth, truth));
  std::string wrong;
  for (const Error& error : CheckTruth(truth)) {
    wrong += fmt::format("{}{}: {}", wrong.empty() ? "" : "\n", name, error.message);
  }
  if (!wrong.empty()) return Fail(ErrorCode::kInvalidValue, wrong);
  return truth;
}

Result<MachineTruth> ReadTruthFile(const std::filesystem::path& file) {
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxTruthFileBytes));
  return ParseTruth(text, file.string());
}

void Replace(const MachineTruth& changes, MachineTruth& truth) {
  if (changes.laser().rates_hz_size() > 0) truth.mutable_laser()->clear_rates_hz();
  if (changes.laser().channel_offset_mm_size() > 0) {
    truth.mutable_laser()->clear_channel_offset_mm();
  }
  if (changes.laser().inputs_size() > 0) truth.mutable_laser()->clear_inputs();
  if (changes.block().stations_size() > 0) truth.mutable_block()->clear_stations();
  if (changes.obstacles_size() > 0) truth.clear_obstacles();
  if (changes.stage().positioner().mirrors().has_deviations())
    truth.mutable_stage()->mutable_positioner()->mutable_mirrors()->clear_deviations();
  truth.MergeFrom(changes);
}

Status WriteTruthFile(const std::filesystem::path& file, const MachineTruth& truth) {
  std::string text;
  pb::TextFormat::PrintToString(truth, &text);
  return io::WriteFileAtomically(file, std::string_view(text));
}

}  // namespace intaglio
