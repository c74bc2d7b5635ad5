#include "engrave/core/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "engrave/core/counted.h"

namespace intaglio {
namespace {

constexpr std::size_t kMaxNames = 64;
constexpr std::size_t kMaxNameBytes = 60;

/// Letters of other scripts stay; control characters and a cut end do not.
std::string Printable(std::string_view text) {
  std::string shown(text.substr(0, kMaxNameBytes));
  for (char& c : shown) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7F') c = '?';
  }
  if (shown.size() == text.size()) return shown;
  while (!shown.empty() && (static_cast<unsigned char>(shown.back()) & 0xC0) == 0x80)
    shown.pop_back();
  if (!shown.empty() && static_cast<unsigned char>(shown.back()) >= 0xC0)
    shown.pop_back();
  return shown + "...";
}

std::string_view VerbOf(Effect effect) {
  switch (effect) {
    case Effect::kNothingSeen:
      return "not needed for the piece";
    case Effect::kLost:
      return "left out, so it is missing in the piece";
    case Effect::kChanged:
      return "not obeyed, so the piece differs from the file";
    case Effect::kMeaningLost:
      return "not supported, and the file cannot be read right without it";
  }
  return "";
}

std::string SentenceOf(std::string_view file, const FileFinding& finding) {
  std::string text = fmt::format(
      "{}: {}", file,
      finding.plural.empty() ? fmt::format("{} x {}", finding.count, finding.what)
                             : Counted(finding.count, finding.what, finding.plural));
  if (!finding.where.empty()) {
    text += fmt::format(" ({}{})", finding.count > 1 ? "the first: " : "", finding.where);
  }
  if (finding.area_mm2 > 0) text += fmt::format(" over {:.3g} mm^2", finding.area_mm2);
  text += fmt::format(": {}", VerbOf(finding.effect));
  if (!finding.remedy.empty()) text += "; " + finding.remedy;
  return text;
}

}  // namespace

void FileFindings::Add(FileFinding finding) {
  finding.what = Printable(finding.what);
  finding.where = Printable(finding.where);
  const auto same = [&](const FileFinding& known) {
    return known.effect == finding.effect && known.what == finding.what;
  };
  auto known = std::ranges::find_if(all_, same);
  if (known == all_.end() && all_.size() >= kMaxNames) {
    finding.what = "other";
    known = std::ranges::find_if(all_, same);
  }
  if (known == all_.end()) {
    all_.push_back(std::move(finding));
    return;
  }
  known->count += finding.count;
  known->area_mm2 += finding.area_mm2;
}

bool FileFindings::IsNew(std::string_view what, Effect effect) const {
  const std::string name = Printable(what);
  return all_.size() < kMaxNames &&
         std::ranges::none_of(all_, [&](const FileFinding& known) {
           return known.effect == effect && known.what == name;
         });
}

std::uint64_t FileFindings::CountOf(std::string_view what) const {
  std::uint64_t count = 0;
  for (const FileFinding& finding : all_) {
    if (finding.what == what) count += finding.count;
  }
  return count;
}

Status CheckMeaning(std::string_view file, const FileFindings& findings) {
  for (const FileFinding& finding : findings) {
    if (finding.effect != Effect::kMeaningLost) continue;
    return Fail(ErrorCode::kUnsupported, SentenceOf(file, finding), finding.what);
  }
  return {};
}

Warnings WarningsOf(std::string_view file, const FileFindings& findings) {
  Warnings warnings;
  for (const FileFinding& finding : findings) {
    Warning warning = MakeWarning(WarningCode::kLeftOut, SentenceOf(file, finding));
    warning.weight = finding.effect == Effect::kNothingSeen ? WarningWeight::kNote
                                                            : WarningWeight::kWarning;
    warnings.push_back(std::move(warning));
  }
  return warnings;
}

}  // namespace intaglio
