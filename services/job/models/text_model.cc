#include "services/job/models/text_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/drawing/font_list.h"
#include "engrave/drawing/font_outline.h"
#include "engrave/drawing/text_coverage.h"
#include "engrave/drawing/utf8_characters.h"
#include "engrave/io/lower_case.h"
#include "engrave/io/whole_file.h"
#include "services/job/convert/model_kind.h"
#include "services/job/convert/placeholders.h"
#include "services/job/models/model_sources.h"
#include "services/job/models/text_fit.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;

// As the range of height_mm.
constexpr double kMinHeightMm = 0.1;
constexpr double kHeightStepMm = 0.01;
// Texts in a DXF have it; its package is one on which that of intaglio depends.
constexpr const char* kUsualFont = "DejaVu Sans";

drawing::TextAlignment AlignmentOf(TextAlignment alignment) {
  switch (alignment) {
    case TEXT_ALIGNMENT_CENTRE:
      return drawing::TextAlignment::kCentre;
    case TEXT_ALIGNMENT_RIGHT:
      return drawing::TextAlignment::kRight;
    default:
      return drawing::TextAlignment::kLeft;
  }
}

/// What is engraved: one text, or one for each copy.
std::vector<std::string> TextsOf(const Model& model, const Block& block) {
  const std::string& pattern = model.text().text();
  const std::size_t count =
      IsNumbered(model.text()) ? CopyOffsetsOf(model, block).size() : 1;
  std::vector<std::string> texts;
  for (std::size_t i = 1; i <= count; ++i) texts.push_back(NumberedText(pattern, i));
  return texts;
}

/// Every character that may occur.
std::string LettersOf(const Text& text) { return NumberedText(text.text(), 1234567890); }

/// Down to a whole step, so that the height can be written.
double RoundDown(double height_mm) {
  const double rounded = std::floor(height_mm / kHeightStepMm) * kHeightStepMm;
  return std::max(kMinHeightMm, rounded);
}

class Outliner {
 public:
  Outliner(const JobSpec& job, const Model& model,
           std::span<const drawing::FontSource> fonts)
      : job_(job), model_(model) {
    const Text& text = model.text();
    options_.font = fonts.front();
    options_.fallbacks.assign(fonts.begin() + 1, fonts.end());
    options_.cap_height_mm = text.height_mm();
    options_.line_spacing_ratio = text.line_ratio();
    options_.alignment = AlignmentOf(text.alignment());
  }

  Result<OutlinedText> Outline() {
    const std::vector<std::string> texts = TextsOf(model_, job_.block());
    auto fits = INTAGLIO_TRY(LargestScale(texts));
    OutlinedText made;
    made.height_mm = options_.cap_height_mm;
    if (fits < 1) {
      options_.cap_height_mm = RoundDown(fits * made.height_mm);
      made.warnings.push_back(MakeWarning(
          WarningCode::kTextShrunk,
          fmt::format("\"{}\": letters are {:g} mm high instead of {:g} mm, to fit",
                      texts.front(), options_.cap_height_mm, made.height_mm)));
      made.height_mm = options_.cap_height_mm;
    }
    for (const std::string& text : texts) {
      auto outline = INTAGLIO_TRY(drawing::TextOutline(text, options_));
      made.outlines.push_back(std::move(outline));
    }
    return made;
  }

 private:
  /// The scale that fits all copies, 1 at most.
  Result<double> LargestScale(const std::vector<std::string>& texts) const {
    double scale = 1;
    for (std::size_t i = 0; i < texts.size(); ++i) {
      const auto outline = INTAGLIO_TRY(drawing::TextOutline(texts[i], options_));
      const int copy = IsNumbered(model_.text()) ? static_cast<int>(i) : -1;
      const auto fit = INTAGLIO_TRY(FitText(job_, model_, outline, copy));
      if (fit.scale_ratio < 1) INTAGLIO_TRY(CheckMayShrink(texts[i], fit));
      scale = std::min(scale, fit.scale_ratio);
    }
    return scale;
  }

  Status CheckMayShrink(const std::string& text, const TextFit& fit) const {
    const double height_mm = fit.scale_ratio * options_.cap_height_mm;
    const bool can = height_mm >= kMinHeightMm;
    if (can && model_.text().shrink_to_fit()) return {};
    const std::string remedy =
        can ? fmt::format("shorten it, use height_mm {:g} or shrink_to_fit: true",
                          RoundDown(height_mm))
            : "move it, or change its placement: a smaller height does not help";
    return Fail(ErrorCode::kOutsideBlock,
                fmt::format("\"{}\" {}; {}", text, fit.obstacle, remedy), text);
  }

  const JobSpec& job_;
  const Model& model_;
  drawing::TextOptions options_;
};

std::vector<drawing::FontSource> FontsOf(const Text& text) {
  std::vector<drawing::FontSource> fonts = {{text.font()}};
  for (const std::string& font : text.fallback_fonts()) fonts.push_back({font});
  return fonts;
}

Result<std::string> FontFileOf(const std::string& font) {
  if (drawing::IsFontFile(font)) return font;
  return drawing::FindFontFile(font);
}

/// The fallback fonts of a text, as files; those that it needs alone.
Result<std::vector<std::string>> FallbacksOf(const Text& text, Findings& findings,
                                             const std::string& path) {
  const auto& asked = text.fallback_fonts();
  if (asked.size() == 1 && asked[0] == kNoFallback) return std::vector<std::string>();
  if (asked.empty()) return drawing::InstalledFallbacks(LettersOf(text), text.font());
  std::vector<std::string> files;
  for (int i = 0; i < asked.size(); ++i) {
    auto file = FontFileOf(asked[i]);
    if (file) {
      files.push_back(std::move(*file));
    } else {
      findings.found().push_back(
          {Error{file.error().code,
                 fmt::format("{}.fallback_fonts[{}]: {}", path, i, file.error().message),
                 asked[i]},
           fmt::format("{}.fallback_fonts[{}]", path, i)});
    }
  }
  return drawing::NeededFallbacks(LettersOf(text), text.font(), files);
}

/// Whether the DXF has an entity that a font makes visible. Of a file that cannot be read
/// the check of the job reports the error.
bool HoldsTexts(const std::string& file) {
  const auto bytes = io::ReadWholeFile(file, drawing::DrawingLimits().max_file_bytes);
  if (!bytes) return false;
  std::istringstream lines(*bytes);
  for (std::string line; std::getline(lines, line);) {
    const auto first = line.find_first_not_of(" \t");
    const auto last = line.find_last_not_of(" \t\r");
    if (first == line.npos) continue;
    const std::string word = line.substr(first, last - first + 1);
    if (word == "TEXT" || word == "MTEXT" || word == "ATTRIB") return true;
  }
  return false;
}

/// The font of a DXF's texts: a file; without one the usual font, where it is installed.
void FindFontOfDrawing(Model& model) {
  const std::string ending = fs::path(model.file()).extension().string();
  if (io::LowerCaseExtension(ending) != "dxf") return;
  const bool asked = !model.text().font().empty();
  if (!asked && (model.has_text() || !HoldsTexts(model.file()))) return;
  if (auto file = FontFileOf(asked ? model.text().font() : kUsualFont)) {
    model.mutable_text()->set_font(std::move(*file));
  }
}

bool FontIsThere(const Text& text) {
  std::error_code ignored;
  return fs::is_regular_file(text.font(), ignored);
}

void ResolveFontsOf(Text& text, const std::string& path, Findings& findings) {
  if (auto file = FontFileOf(text.font())) text.set_font(std::move(*file));
  if (!FontIsThere(text)) return;  // the check of the job reports it
  auto files = FallbacksOf(text, findings, path);
  if (files) {
    text.mutable_fallback_fonts()->Assign(files->begin(), files->end());
    return;
  }
  findings.found().push_back(
      {Error{files.error().code, fmt::format("{}.text: {}", path, files.error().message),
             ""},
       path + ".text"});
}

}  // namespace

bool IsNumbered(const Text& text) {
  const auto names = PlaceholdersOf(text.text());
  return std::find(names.begin(), names.end(), "n") != names.end();
}

Result<OutlinedText> OutlineText(const JobSpec& job, const Model& model,
                                 std::span<const drawing::FontSource> fonts) {
  const auto coverage = INTAGLIO_TRY(drawing::CoverageOf(LettersOf(model.text()), fonts));
  INTAGLIO_TRY(drawing::CheckCoverage(coverage));
  auto made = INTAGLIO_TRY(Outliner(job, model, fonts).Outline());
  for (const auto& [font, characters] : coverage.borrowed) {
    made.warnings.push_back(MakeWarning(
        WarningCode::kFallbackFont,
        fmt::format("\"{}\": {} is in the style of {}, because {} does not have it",
                    model.text().text(), drawing::Utf8Of(characters),
                    coverage.fonts[font], coverage.fonts.front())));
  }
  return made;
}

std::vector<Finding> ResolveFonts(JobSpec& job) {
  Findings findings;
  for (int i = 0; i < job.models_size(); ++i) {
    if (IsText(job.models(i))) {
      ResolveFontsOf(*job.mutable_models(i)->mutable_text(),
                     fmt::format("models[{}].text", i), findings);
    } else {
      FindFontOfDrawing(*job.mutable_models(i));
    }
  }
  for (int i = 0; i < job.marks().items_size(); ++i) {
    if (!job.marks().items(i).has_text()) continue;
    ResolveFontsOf(*job.mutable_marks()->mutable_items(i)->mutable_text(),
                   fmt::format("marks.items[{}].text", i), findings);
  }
  return std::move(findings.found());
}

std::vector<Finding> CheckTexts(const JobSpec& job, Warnings& notes) {
  std::vector<Finding> found;
  for (int i = 0; i < job.models_size(); ++i) {
    const Model& model = job.models(i);
    if (!IsText(model) || model.text().text().empty() || !FontIsThere(model.text())) {
      continue;
    }
    const std::string field = fmt::format("models[{}].text.text", i);
    const auto outlined = OutlineText(job, model, FontsOf(model.text()));
    if (!outlined) {
      found.push_back(
          {Error{outlined.error().code, field + ": " + outlined.error().message,
                 outlined.error().value},
           field});
      continue;
    }
    for (Warning warning : outlined->warnings) {
      warning.text = fmt::format("models[{}].text: {}", i, warning.text);
      notes.push_back(std::move(warning));
    }
  }
  return found;
}

}  // namespace intaglio
