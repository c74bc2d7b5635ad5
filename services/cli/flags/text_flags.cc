#include "services/cli/flags/text_flags.h"

#include <fmt/format.h>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "services/job/convert/model_kind.h"
#include "services/job/models/arrangement.h"

namespace intaglio::cli {
namespace {

constexpr const char* kDefaultFont = "DejaVu Sans";
constexpr const char* kText = "Text";

std::vector<Text*> TextsOf(JobSpec& job) {
  std::vector<Text*> texts;
  for (Model& model : *job.mutable_models()) {
    if (IsText(model)) texts.push_back(model.mutable_text());
  }
  return texts;
}

/// A shell passes "\n" as two characters.
std::string WithLines(const std::string& typed) {
  std::string text;
  for (std::size_t i = 0; i < typed.size(); ++i) {
    const bool divides = typed.compare(i, 2, "\\n") == 0;
    text += divides ? '\n' : typed[i];
    if (divides) ++i;
  }
  return text;
}

Status SetText(const std::string& typed, JobSpec& job) {
  const std::vector<Text*> texts = TextsOf(job);
  if (texts.size() > 1) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("--text: the job has {}; change them in the job file, or "
                            "use a series (--series)",
                            Counted(texts.size(), "text")),
                typed);
  }
  Text& text = texts.empty() ? *job.add_models()->mutable_text() : *texts.front();
  text.set_text(WithLines(typed));
  if (text.font().empty()) text.set_font(kDefaultFont);
  return {};
}

/// The only code of the job; a new one where it has none.
Result<MarkCode*> CodeOf(const TextFlags& flags, JobSpec& job) {
  std::vector<MarkCode*> codes;
  for (Model& model : *job.mutable_models())
    if (model.has_code()) codes.push_back(model.mutable_code());
  if (codes.size() == 1) return codes.front();
  if (codes.empty() && flags.code) return job.add_models()->mutable_code();
  const char* option = flags.code        ? "--code"
                       : flags.code_kind ? "--code-kind"
                                         : "--module";
  return Fail(
      ErrorCode::kInvalidValue,
      fmt::format("{}: the job has {}; {}", option, Counted(codes.size(), "code"),
                  codes.empty() ? "give one with --code" : "change them in the job file"),
      option);
}

Status SetCode(const TextFlags& flags, JobSpec& job) {
  if (!flags.code && !flags.code_kind && !flags.module_mm) return {};
  MarkCode& code = *INTAGLIO_TRY(CodeOf(flags, job));
  if (flags.code) code.set_text(*flags.code);
  if (flags.code_kind) {
    code.set_kind(*flags.code_kind == "qr" ? MARK_CODE_KIND_QR
                                           : MARK_CODE_KIND_DATA_MATRIX);
  }
  if (flags.module_mm) code.set_module_mm(*flags.module_mm);
  return {};
}

/// The first option of those that need a text; empty: none is given.
std::string NameOfGiven(const TextFlags& flags) {
  if (flags.font) return "--font";
  if (flags.place) return "--text-place";
  if (flags.height_mm) return "--text-height";
  if (!flags.fallback_fonts.empty()) return "--fallback-font";
  return flags.shrink_to_fit ? "--shrink-to-fit" : "";
}

}  // namespace

void AddTextFlags(command_line::Command command, TextFlags& flags) {
  command
      .AddOption("--text", flags.text,
                 "text to engrave, beside the models or instead of the job's text; \\n "
                 "divides lines")
      .Group(kText);
  command
      .AddOption("--text-place", flags.place,
                 "where the text lies, as seen from the front of the models: beside "
                 "models that are given without a job file the default is below")
      .OneOf({kTextPlaces.begin(), kTextPlaces.end()})
      .Group(kText);
  command
      .AddOption("--font", flags.font,
                 "font of the texts: a family (intaglio fonts) or a file, default DejaVu "
                 "Sans")
      .Group(kText);
  command
      .AddOption("--text-height", flags.height_mm,
                 "height of capital letters, mm, default 5")
      .Group(kText);
  command
      .AddOption("--fallback-font", flags.fallback_fonts,
                 "fonts for characters that the font does not have, in this order; none: "
                 "no other font; default: usual fonts of this computer")
      .Group(kText);
  command
      .AddFlag("--shrink-to-fit", flags.shrink_to_fit,
               "reduce the height of a text that is too large for its place")
      .Group(kText);
  command
      .AddOption("--code", flags.code,
                 "text of a code to engrave, beside the models: its dark modules are "
                 "filled with points")
      .Group(kText);
  command.AddOption("--code-kind", flags.code_kind, "of the code, default data-matrix")
      .OneOf({"data-matrix", "qr"})
      .Group(kText);
  command
      .AddOption("--module", flags.module_mm,
                 "side of a module of the code, mm, default "
                 "0.5")
      .Group(kText);
}

Status SetTexts(const TextFlags& flags, JobSpec& job) {
  INTAGLIO_TRY(SetCode(flags, job));
  if (flags.text) INTAGLIO_TRY(SetText(*flags.text, job));
  const std::vector<Text*> texts = TextsOf(job);
  const std::string given = NameOfGiven(flags);
  if (texts.empty() && !given.empty()) {
    return Fail(ErrorCode::kInvalidValue,
                given + ": the job has no text; give one with --text", given);
  }
  for (Text* text : texts) {
    if (flags.font) text->set_font(*flags.font);
    if (flags.height_mm) text->set_height_mm(*flags.height_mm);
    if (flags.shrink_to_fit) text->set_shrink_to_fit(true);
    if (flags.fallback_fonts.empty()) continue;
    text->mutable_fallback_fonts()->Assign(flags.fallback_fonts.begin(),
                                           flags.fallback_fonts.end());
  }
  return {};
}

}  // namespace intaglio::cli
