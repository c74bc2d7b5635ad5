#include "services/cli/contour/contour_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <numbers>

namespace intaglio::cli {
namespace {

constexpr std::array<const char*, 6> kPassColors = {"#d62728", "#1f77b4", "#2ca02c",
                                                    "#9467bd", "#ff7f0e", "#17becf"};

class SvgText {
 public:
  std::string Take(double margin_mm) {
    const Vec2 low = low_ - Vec2::Constant(margin_mm);
    const Vec2 size = high_ - low_ + Vec2::Constant(2 * margin_mm);
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.4f}mm\" "
        "height=\"{1:.4f}mm\" viewBox=\"{2:.4f} {3:.4f} {0:.4f} {1:.4f}\">\n{4}</svg>\n",
        size.x(), size.y(), low.x(), -(low.y() + size.y()), text_);
  }

  /// y points down in SVG.
  std::string PlaceText(const Vec2& p) {
    low_ = low_.cwiseMin(p);
    high_ = high_.cwiseMax(p);
    return fmt::format("{:.6f} {:.6f}", p.x(), -p.y());
  }

  std::string PathText(const contour::Edges& edges) {
    std::string path = "M" + PlaceText(edges.front().begin_mm);
    for (const contour::Edge& edge : edges) {
      if (!edge.is_arc()) {
        path += "L" + PlaceText(edge.end_mm);
        continue;
      }
      // A circle that ends where it begins would be nothing: in two halves.
      const Vec2 middle = contour::PointAt(edge, edge.length_mm / 2);
      for (const Vec2& end : {middle, edge.end_mm}) {
        path += fmt::format("A{0:.6f} {0:.6f} 0 0 {1} {2}", edge.radius_mm,
                            edge.sweep_rad > 0 ? 0 : 1, PlaceText(end));
      }
    }
    return path;
  }

  void Add(std::string_view text) { text_ += text; }

 private:
  Vec2 low_{1e9, 1e9}, high_{-1e9, -1e9};
  std::string text_;
};

void AddCopper(const ContourWork& work, SvgText& svg) {
  if (work.copper.empty()) return;
  svg.Add("<path fill=\"#e8c9a0\" fill-rule=\"evenodd\" d=\"");
  for (const contour::Edges& edges : work.copper) svg.Add(svg.PathText(edges) + "Z");
  svg.Add("\"/>\n");
}

void AddIdle(const ContourWork& work, const Vec2& start_mm, SvgText& svg) {
  svg.Add(
      "<path fill=\"none\" stroke=\"#888888\" stroke-width=\"0.05\" "
      "stroke-dasharray=\"0.3\" d=\"");
  Vec2 at_mm = start_mm;
  for (const post::ToolPath& path : work.paths) {
    svg.Add("M" + svg.PlaceText(at_mm) + "L" + svg.PlaceText(path.begin_mm));
    at_mm = path.moves.empty() ? path.begin_mm : path.moves.back().end_mm;
  }
  svg.Add("\"/>\n");
}

/// Black lines along the path where its tabs are.
void AddTabs(const post::ToolPath& path, double tool_diameter_mm, SvgText& svg) {
  const contour::Edges edges = post::EdgesOf(path);
  for (std::size_t k = 0; k < edges.size(); ++k) {
    if (!path.moves[k].tab) continue;
    svg.Add(
        fmt::format("<path class=\"tab\" fill=\"none\" stroke=\"#000000\" "
                    "stroke-width=\"{:.4f}\" d=\"{}\"/>\n",
                    tool_diameter_mm / 3, svg.PathText({edges[k]})));
  }
}

}  // namespace

std::string SvgOf(const ContourWork& work, const Vec2& start_mm,
                  double tool_diameter_mm) {
  SvgText svg;
  AddCopper(work, svg);
  if (!work.paths.empty()) AddIdle(work, start_mm, svg);
  for (std::size_t k = 0; k < work.paths.size(); ++k) {
    const auto color =
        kPassColors[static_cast<std::size_t>(work.passes[k]) % kPassColors.size()];
    svg.Add(
        fmt::format("<path fill=\"none\" stroke=\"{}\" stroke-width=\"{:.4f}\" "
                    "stroke-opacity=\"0.6\" d=\"{}\"/>\n",
                    color, tool_diameter_mm, svg.PathText(post::EdgesOf(work.paths[k]))));
    AddTabs(work.paths[k], tool_diameter_mm, svg);
  }
  for (const post::DrillRound& round : work.rounds) {
    for (const Vec2& place : round.places_mm) {
      const Vec2 half = Vec2::Constant(round.diameter_mm / 2);
      svg.PlaceText(place - half);
      svg.PlaceText(place + half);
      svg.Add(
          fmt::format("<circle fill=\"none\" stroke=\"#000000\" "
                      "stroke-width=\"0.05\" cx=\"{:.6f}\" cy=\"{:.6f}\" "
                      "r=\"{:.6f}\"/>\n",
                      place.x(), -place.y(), round.diameter_mm / 2));
    }
  }
  return svg.Take(std::max(1.0, tool_diameter_mm));
}

std::string SvgOfSheet(const std::vector<contour::Region>& parts, const Vec2& sheet_mm) {
  SvgText svg;
  svg.PlaceText(Vec2::Zero());
  svg.PlaceText(sheet_mm);
  for (const contour::Region& part : parts) {
    svg.Add("<path fill=\"#e8c9a0\" fill-rule=\"evenodd\" d=\"");
    for (const contour::Edges& loop : part.loops) svg.Add(svg.PathText(loop) + "Z");
    svg.Add("\"/>\n");
  }
  return svg.Take(0);
}

}  // namespace intaglio::cli
