#include "engrave/contour/files/kicad_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "engrave/contour/files/gerber_region.h"
#include "engrave/contour/files/kicad_shapes.h"
#include "engrave/contour/region/loose_edges.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

constexpr double kOldestVersion = 20171130;
constexpr double kNewestVersion = 20241229;
constexpr std::size_t kMaxLayers = 32;
constexpr double kOutlineJoint_mm = 0.01;
constexpr double kMaxDrill_mm = 1000;

class KicadReader {
 public:
  KicadReader(std::string_view name, const KicadLimits& limits)
      : name_(name), limits_(limits) {}

  Result<KicadBoard> Read(const SExpression& root) {
    line_ = root.line();
    const auto version = root.Find("version");
    const double number = version ? version->Number(1).value_or(0) : 0;
    if (root.name() != "kicad_pcb" || number < kOldestVersion)
      return Wrong(ErrorCode::kUnreadable,
                   "no board of KiCad 5 or newer; save it with a newer KiCad");
    if (number > kNewestVersion)
      return Wrong(ErrorCode::kUnsupported,
                   fmt::format("boards of version {:.0f} are not read; export it for an "
                               "older KiCad",
                               number));
    INTAGLIO_TRY(ReadLayers(root));
    for (const SExpression& item : root.items()) {
      if (!item.is_list()) continue;
      line_ = item.line();
      auto read = ReadItem(item);
      if (!read) return Placed(read.error());
      if (board_.elements.size() > limits_.max_elements)
        return Wrong(
            ErrorCode::kTooLarge,
            fmt::format("more than {} elements; divide the board", limits_.max_elements));
    }
    auto outline = JoinLoops(edge_cuts_, kOutlineJoint_mm);
    if (!outline)
      return Wrong(outline.error().code,
                   "the board's outline (Edge.Cuts): " + outline.error().message);
    board_.outline = std::move(*outline);
    return std::move(board_);
  }

 private:
  tl::unexpected<Error> Wrong(ErrorCode code, const std::string& sentence) const {
    return Fail(code, fmt::format("{}: line {}: {}", name_, line_, sentence));
  }
  tl::unexpected<Error> Placed(const Error& error) const {
    return Wrong(error.code, error.message + "; save the board again");
  }

  void LeaveOut(std::string what, Effect effect = Effect::kLost,
                std::string remedy = "draw it with tracks or polygons") {
    board_.findings.Add({std::move(what), fmt::format("line {}", line_),
                         std::move(remedy), 1, 0, effect});
  }

  /// (layers (0 "F.Cu" signal) ..): those of copper, front first.
  Status ReadLayers(const SExpression& root) {
    if (const auto layers = root.Find("layers")) {
      for (const SExpression& layer : layers->items()) {
        const std::string name = layer.is_list() ? layer.Text(1) : "";
        if (name.ends_with(".Cu")) board_.layers.push_back(name);
      }
    }
    if (board_.layers.empty())
      return Wrong(ErrorCode::kMissing, "no layers of copper; the file is damaged");
    if (board_.layers.size() > kMaxLayers)
      return Wrong(ErrorCode::kTooLarge, "more than 32 layers of copper");
    return {};
  }

  Status ReadItem(const SExpression& item) {
    const std::string_view name = item.name();
    if (name == "net") return ReadNet(item);
    if (name == "segment") return ReadSegment(item);
    if (name == "arc") return ReadArc(item);
    if (name == "via") return ReadVia(item);
    if (name == "zone") return ReadZone(item);
    if (name == "footprint" || name == "module") return ReadFootprint(item);
    if (name.starts_with("gr_")) return ReadGraphic(item, {}, {});
    // The members of what KiCad generates are items of their own.
    if (name != "generated") LeaveOutOnCopper(item);
    return {};
  }

  /// Dimensions, pictures, tables, texts: what is drawn on copper and is not read.
  void LeaveOutOnCopper(const SExpression& item) {
    const auto hide = item.Find("hide");
    const auto items = item.items();
    const bool is_hidden = (hide && hide->Text(1) != "no") ||
                           std::ranges::any_of(items, [](const SExpression& part) {
                             return !part.is_list() && part.text() == "hide";
                           });
    if (!is_hidden && LayersOf(item) != 0) LeaveOut(std::string(item.name()));
  }

  Status ReadNet(const SExpression& item) {
    const auto number = item.Number(1);
    if (!number) return Fail(ErrorCode::kInvalidValue, "expected (net NUMBER NAME)");
    nets_[*number] = item.Text(2);
    return {};
  }

  Result<std::string> NetOf(const SExpression& item) const {
    const auto net = item.Find("net");
    if (!net) return std::string();
    const auto found = nets_.find(net->Number(1).value_or(-1));
    if (found != nets_.end()) return found->second;
    return Fail(ErrorCode::kMissing, fmt::format("net {} is not declared", net->Text(1)));
  }

  /// The bits of the copper layers that (layer ..) or (layers ..) names.
  std::uint32_t LayersOf(const SExpression& item) const {
    std::uint32_t bits = 0;
    for (const char* list_name : {"layer", "layers"}) {
      const auto list = item.Find(list_name);
      if (!list) continue;
      const auto names = list->items();
      for (std::size_t k = 1; k < names.size(); ++k) {
        const std::string name = names[k].text();
        for (std::size_t layer = 0; layer < board_.layers.size(); ++layer) {
          const std::string& copper = board_.layers[layer];
          const bool outer = copper == "F.Cu" || copper == "B.Cu";
          if (name == copper || name == "*.Cu" || (name == "F&B.Cu" && outer))
            bits |= 1U << layer;
        }
      }
    }
    return bits;
  }

  void Add(Shape shape, std::string name, const std::string& net, bool terminal,
           std::uint32_t layers) {
    board_.elements.push_back(
        {{std::move(shape), std::move(name), net}, net, terminal, layers});
  }

  Status ReadSegment(const SExpression& item) {
    const KicadPlace origin;
    const Vec2 begin = origin.Of(INTAGLIO_TRY(KicadPoint(item, "start")));
    const Vec2 end = origin.Of(INTAGLIO_TRY(KicadPoint(item, "end")));
    const double width = INTAGLIO_TRY(KicadNumber(item, "width", 0));
    const std::string net = INTAGLIO_TRY(NetOf(item));
    Add(Track{begin, end, width}, net, net, false, LayersOf(item));
    return {};
  }

  Status ReadArc(const SExpression& item) {
    const Vec2 begin = INTAGLIO_TRY(KicadPoint(item, "start"));
    const Vec2 middle = INTAGLIO_TRY(KicadPoint(item, "mid"));
    const Vec2 end = INTAGLIO_TRY(KicadPoint(item, "end"));
    const double width = INTAGLIO_TRY(KicadNumber(item, "width", 0));
    const std::string net = INTAGLIO_TRY(NetOf(item));
    const KicadPlace origin;
    const Edge arc = KicadArc(origin.Of(begin), origin.Of(middle), origin.Of(end));
    if (arc.is_arc())
      Add(ArcTrack{arc, width}, net, net, false, LayersOf(item));
    else
      Add(Track{arc.begin_mm, arc.end_mm, width}, net, net, false, LayersOf(item));
    return {};
  }

  /// A via names its first and its last layer.
  Status ReadVia(const SExpression& item) {
    const KicadPlace at = INTAGLIO_TRY(KicadAt(item));
    const double size = INTAGLIO_TRY(KicadNumber(item, "size", 0));
    const double drill = INTAGLIO_TRY(KicadNumber(item, "drill", 0));
    const std::string net = INTAGLIO_TRY(NetOf(item));
    const std::uint32_t named = LayersOf(item);
    std::uint32_t layers = 0;
    for (std::size_t k = 0; k < board_.layers.size(); ++k) {
      const std::uint32_t up_to = (2U << k) - 1;
      if ((named & up_to) != 0 && (named >> k) != 0) layers |= 1U << k;
    }
    Add(Circle{at.at_mm, size}, net.empty() ? "via" : "via of " + net, net, true, layers);
    return AddHole(at.at_mm, drill);
  }

  Status AddHole(const Vec2& at, double diameter) {
    if (diameter == 0) return {};
    if (!(diameter > 0 && diameter <= kMaxDrill_mm))
      return Fail(ErrorCode::kInvalidValue, "the diameter of a drill is not positive");
    board_.holes.push_back({at, diameter});
    return {};
  }

  /// Filled polygons have their holes by cut-ins. Before version 6, and where the zone
  /// says so, their outlines are drawn with the smallest thickness.
  Status ReadZone(const SExpression& item) {
    if (item.Find("keepout")) return {};
    const std::string net = INTAGLIO_TRY(NetOf(item));
    const std::uint32_t of_zone = LayersOf(item);
    const auto exact = item.Find("filled_areas_thickness");
    const double stroke = exact && exact->Text(1) == "no"
                              ? 0
                              : INTAGLIO_TRY(KicadNumber(item, "min_thickness", 0));
    bool filled = false;
    for (const SExpression& polygon : item.items()) {
      if (!polygon.is_list() || polygon.name() != "filled_polygon") continue;
      filled = true;
      line_ = polygon.line();
      const std::uint32_t own = LayersOf(polygon);
      const std::uint32_t layers = own != 0 ? own : of_zone;
      INTAGLIO_TRY(AddFilled(polygon, net, layers, stroke));
    }
    const auto fill = item.Find("fill");
    if (!filled && of_zone != 0 && !(fill && fill->Text(1) == "yes"))
      LeaveOut(fmt::format("zone of net '{}' that is not filled", net), Effect::kLost,
               "fill all zones and save the board");
    return {};
  }

  Status AddFilled(const SExpression& polygon, const std::string& net,
                   std::uint32_t layers, double stroke) {
    const auto corners = INTAGLIO_TRY(KicadCorners(polygon, {}));
    Edges path;
    for (std::size_t k = 0; k < corners.size(); ++k)
      path.push_back(MakeLine(corners[k], corners[(k + 1) % corners.size()]));
    Outline outline = INTAGLIO_TRY(RegionOutline(path));
    const bool is_sliver = outline.loops.empty();
    if (stroke > 0) {
      for (const Edges& loop : is_sliver ? std::vector<Edges>{path} : outline.loops) {
        for (const Edge& edge : loop)
          Add(Track{edge.begin_mm, edge.end_mm, stroke}, net, net, false, layers);
      }
    }
    if (!is_sliver) Add(std::move(outline), net, net, false, layers);
    return {};
  }

  Status ReadGraphic(const SExpression& item, const KicadPlace& place,
                     const std::string& net) {
    const auto layer = item.Find("layer");
    const bool outline = layer && layer->Text(1) == "Edge.Cuts";
    const std::uint32_t layers = LayersOf(item);
    if (!outline && layers == 0) return {};
    const auto graphic = INTAGLIO_TRY(GraphicOf(item, place));
    if (!graphic) {
      LeaveOut(std::string(item.name()));
    } else if (outline) {
      edge_cuts_.insert(edge_cuts_.end(), graphic->edges.begin(), graphic->edges.end());
    } else {
      for (Shape& shape : ShapesOf(*graphic))
        Add(std::move(shape), net, net, false, layers);
    }
    return {};
  }

  Status ReadFootprint(const SExpression& item) {
    const KicadPlace at = INTAGLIO_TRY(KicadAt(item));
    std::string reference;
    for (const SExpression& part : item.items()) {
      if (!part.is_list()) continue;
      const std::string kind = part.Text(1);
      if ((part.name() == "fp_text" && kind == "reference") ||
          (part.name() == "property" && kind == "Reference"))
        reference = part.Text(2);
    }
    for (const SExpression& part : item.items()) {
      if (!part.is_list()) continue;
      line_ = part.line();
      if (part.name() == "pad")
        INTAGLIO_TRY(ReadPad(part, at, reference));
      else if (part.name() == "zone")
        INTAGLIO_TRY(ReadZone(part));
      else if (part.name().starts_with("fp_") && part.name() != "fp_text")
        INTAGLIO_TRY(ReadGraphic(part, at, {}));
      else
        LeaveOutOnCopper(part);
    }
    return {};
  }

  /// The angle of a pad is that on the board; its place is relative to the footprint.
  Status ReadPad(const SExpression& pad, const KicadPlace& footprint,
                 const std::string& reference) {
    const Vec2 at = INTAGLIO_TRY(KicadPoint(pad, "at"));
    const KicadPlace own = INTAGLIO_TRY(KicadAt(pad));
    const KicadPlace place{footprint.Of(at), own.turned_rad};
    INTAGLIO_TRY(ReadDrill(pad, place));
    const std::uint32_t layers = LayersOf(pad);
    if (layers == 0 || pad.Text(2) == "np_thru_hole") return {};
    const std::string net = INTAGLIO_TRY(NetOf(pad));
    std::vector<std::string> left_out;
    auto shapes = INTAGLIO_TRY(PadShapes(pad, place, left_out));
    for (const std::string& what : left_out) LeaveOut(what, Effect::kChanged);
    for (Shape& shape : shapes)
      Add(std::move(shape), reference + "-" + pad.Text(1), net, true, layers);
    return {};
  }

  /// (drill D) or (drill oval WIDTH HEIGHT).
  Status ReadDrill(const SExpression& pad, const KicadPlace& place) {
    const auto drill = pad.Find("drill");
    if (!drill) return {};
    if (drill->Text(1) != "oval")
      return AddHole(place.at_mm, drill->Number(1).value_or(0));
    const double width = drill->Number(2).value_or(0);
    const double height = drill->Number(3).value_or(width);
    if (width == height) return AddHole(place.at_mm, width);
    const double narrow = std::min(width, height);
    if (!(narrow > 0 && std::max(width, height) <= kMaxDrill_mm))
      return Fail(ErrorCode::kInvalidValue, "the size of a drill is not positive");
    const Vec2 end = 0.5 * Vec2(width - narrow, height - narrow);
    board_.slots.push_back({Track{place.Of(-end), place.Of(end), narrow}, {}});
    return {};
  }

  std::string_view name_;
  KicadLimits limits_;
  std::size_t line_ = 1;
  std::map<double, std::string> nets_;
  Edges edge_cuts_;
  KicadBoard board_;
};

}  // namespace

Result<KicadBoard> ReadKicadBoard(std::string_view text, std::string_view name,
                                  const KicadLimits& limits) {
  if (text.size() > limits.max_file_bytes)
    return Fail(
        ErrorCode::kTooLarge,
        fmt::format("{}: line 1: the file has {} bytes, the limit is {}; divide it", name,
                    text.size(), limits.max_file_bytes));
  const SExpressions all = INTAGLIO_TRY(
      SExpressions::Read(text, name, {limits.max_expressions, limits.max_nesting}));
  return KicadReader(name, limits).Read(all.root());
}

std::vector<Element> ElementsOfLayer(const KicadBoard& board, std::uint32_t layer) {
  std::vector<Element> elements;
  for (const NetElement& drawn : board.elements) {
    if ((drawn.layers >> layer & 1) != 0) elements.push_back(drawn.element);
  }
  return elements;
}

}  // namespace intaglio::contour
