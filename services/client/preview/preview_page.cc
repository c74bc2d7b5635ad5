#include "services/client/preview/preview_page.h"

#include <fmt/format.h>

#include <span>

#include "services/client/figure_text.h"
#include "services/client/preview/preview_text.h"
#include "services/client/preview/preview_view.h"
#include "services/platform/text_format/base64.h"

namespace intaglio::client {
namespace {

constexpr std::string_view kStyle = R"(
  :root { color-scheme: light dark; }
  body { font: 16px/1.45 system-ui, sans-serif; margin: 0 auto; max-width: 1100px;
         padding: 1.5rem; }
  h1 { font-size: 1.5rem; margin: 0 0 .25rem; overflow-wrap: anywhere; }
  .verdict { display: inline-block; padding: .2rem .7rem; border-radius: .3rem;
             color: #fff; background: #1d7a3c; }
  .verdict.warning { background: #a86400; }
  .verdict.consent { background: #b3261e; }
  .verdict.draft { background: #5f6368; }
  canvas { width: 100%; height: auto; margin: 1rem 0; border-radius: .3rem;
           touch-action: none; cursor: grab; }
  img { width: 100%; height: auto; margin: 1rem 0; border-radius: .3rem; }
  table { border-collapse: collapse; width: 100%; margin: .5rem 0 1.25rem; }
  th, td { text-align: left; vertical-align: top; padding: .3rem .8rem .3rem 0;
           border-bottom: 1px solid #8884; overflow-wrap: anywhere; }
  th { font-weight: 600; white-space: nowrap; }
  td.bad { color: #b3261e; font-weight: 600; }
  li { margin: .3rem 0; }
  .weight { font-weight: 600; }
  .weight.warning { color: #a86400; }
  .weight.consent { color: #b3261e; }
  footer { opacity: .7; font-size: .85rem; }
)";

std::string ClassOf(const JobPreview& figures) {
  if (figures.verdict() == kReady) return "";
  if (figures.verdict() == kDraft) return " draft";
  return figures.verdict() == kReadyWithWarnings ? " warning" : " consent";
}

std::string PictureOf(const PreviewPicture& picture, const std::string& description) {
  return fmt::format("<img alt=\"{}\" src=\"data:image/png;base64,{}\">\n",
                     HtmlOf(description),
                     Base64Of(std::as_bytes(std::span(picture.png))));
}

std::string FigureTable(const JobPreview& figures) {
  std::string rows;
  for (const PreviewLine& line : LinesOf(figures)) {
    rows += fmt::format("<tr><th>{}</th><td{}>{}</td></tr>\n", HtmlOf(line.label),
                        line.bad ? " class=\"bad\"" : "", HtmlOf(line.value));
  }
  return "<table>\n" + rows + "</table>\n";
}

std::string WarningTexts(const JobPreview& figures) {
  if (figures.warnings().empty()) return "<p>No warnings.</p>\n";
  std::string items;
  for (const WarningRecord& warning : figures.warnings()) {
    items += fmt::format("<li><span class=\"weight {0}\">{0}</span> {1}</li>\n",
                         HtmlOf(warning.weight()), HtmlOf(warning.text()));
  }
  return "<h2>Warnings</h2>\n<ul>\n" + items + "</ul>\n";
}

std::string ModelTable(const JobPreview& figures) {
  std::string rows;
  for (const ModelPreview& model : figures.models()) {
    rows += fmt::format(
        "<tr><th>{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
        HtmlOf(model.name()), HtmlOf(model.kind()), HtmlOf(model.method()),
        GroupedCount(model.point_count(), "point"), SizeText(model.size_mm()));
  }
  return "<h2>Models</h2>\n<table>\n" + rows + "</table>\n";
}

}  // namespace

std::string HtmlOf(std::string_view text) {
  std::string html;
  for (const char c : text) {
    switch (c) {
      case '&':
        html += "&amp;";
        break;
      case '<':
        html += "&lt;";
        break;
      case '>':
        html += "&gt;";
        break;
      case '"':
        html += "&quot;";
        break;
      case '\'':
        html += "&#39;";
        break;
      default:
        html += c;
    }
  }
  return html;
}

std::string PageOf(const Preview& preview) {
  const JobPreview& figures = preview.figures;
  std::string page = fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{0}: preview</title>\n<style>{1}</style>\n</head>\n<body>\n"
      "<h1>{0}</h1>\n<p><span class=\"verdict{2}\">{3}</span></p>\n",
      HtmlOf(figures.name()), kStyle, ClassOf(figures), HtmlOf(VerdictText(figures)));
  for (std::size_t i = 0; i < preview.pictures.size() && i < 1; ++i) {
    page += PictureOf(preview.pictures[i], "views of the planned points in the block");
  }
  const Vector3& block = figures.block_size_mm();
  page += TurningView(preview.points_mm, Vec3(block.x(), block.y(), block.z()));
  page += FigureTable(figures);
  if (figures.verdict() != kDraft) page += WarningTexts(figures) + ModelTable(figures);
  for (std::size_t i = 1; i < preview.pictures.size(); ++i) {
    page += PictureOf(preview.pictures[i], preview.pictures[i].file);
  }
  return page + fmt::format("<footer>intaglio {}{}{}</footer>\n</body>\n</html>\n",
                            HtmlOf(figures.software_version()),
                            figures.made_utc().empty() ? "" : ", ",
                            HtmlOf(figures.made_utc()));
}

}  // namespace intaglio::client
