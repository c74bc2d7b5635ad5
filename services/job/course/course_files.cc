#include "services/job/course/course_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <utility>

#include "engrave/contour/files/drawing_loops.h"
#include "engrave/contour/files/excellon_read.h"
#include "engrave/contour/files/gerber_parameters.h"
#include "engrave/contour/files/gerber_read.h"
#include "engrave/contour/files/kicad_read.h"
#include "engrave/contour/files/project_file.h"
#include "engrave/contour/region/region_index.h"
#include "engrave/core/check.h"
#include "engrave/core/findings.h"
#include "engrave/core/try.h"
#include "engrave/io/lower_case.h"
#include "services/job/convert/model_kind.h"
#include "services/job/course/course_holes.h"
#include "services/job/course/course_side.h"
#include "services/job/course/course_slots.h"
#include "services/job/models/flat_models.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
/// Ends of curves that are one contour: below what a drawing program rounds to.
constexpr double kJoinedEndsMm = 0.01;
/// Chords of splines and ellipses: below the resolution of every machine.
constexpr double kChordsMm = 0.001;
/// A drill file declares itself in its first lines.
constexpr std::size_t kHeadBytes = 4096;
/// KiCad's layer that has the outline of the board.
constexpr std::string_view kOutlineLayer = "Edge.Cuts";

std::string FileName(const std::string& file) {
  return fs::path(file).filename().string();
}

/// Along the curves as they are drawn, open ones among them.
Status AddCurves(const std::string& file, const drawing::Drawing& drawing,
                 CourseFiles& files) {
  auto curves =
      INTAGLIO_TRY(contour::CurvesOfDrawing(drawing, {kChordsMm, kJoinedEndsMm}));
  int number = 0;
  for (contour::FollowedCurve& curve : curves) {
    files.curves.push_back({fmt::format("{}, curve {}", FileName(file), ++number),
                            std::move(curve.edges), curve.closed});
  }
  return {};
}

/// Points of a drawing have no length to work along.
FileFindings PointsIn(const drawing::Drawing& drawing) {
  FileFindings points;
  for (const drawing::Curve& curve : drawing.curves) {
    const auto* line = curve.pieces.size() == 1
                           ? std::get_if<drawing::Polyline>(&curve.pieces[0])
                           : nullptr;
    if (line == nullptr || line->points_mm.size() != 1) continue;
    const Vec3& at = line->points_mm[0];
    points.Add({"point", fmt::format("({:.6g}, {:.6g})", at.x(), at.y()),
                "draw holes as circles, or drill them from an Excellon file", 1, 0,
                Effect::kLost});
  }
  return points;
}

/// A closed contour of a drawing, lines and arcs.
struct DrawnLoop {
  std::string name;  ///< "plate.dxf, contour 3"
  contour::Edges edges;
  contour::EdgeBox box;
};

Status AddLoops(const std::string& file, const drawing::Drawing& drawing,
                std::vector<DrawnLoop>& loops) {
  auto read = contour::LoopsOfDrawing(drawing, {kChordsMm, kJoinedEndsMm});
  if (!read) {
    Error error = read.error();
    error.message = fmt::format("{}: {}, or follow its curves with --make curves",
                                FileName(file), error.message);
    return tl::unexpected(error);
  }
  int number = 0;
  for (contour::Edges& loop : *read) {
    const contour::EdgeBox box = contour::BoxOfEdges(loop);
    loops.push_back(
        {fmt::format("{}, contour {}", FileName(file), ++number), std::move(loop), box});
  }
  return {};
}

/// What is read of the files so far.
struct CourseReading {
  CourseFiles files;
  std::vector<DrawnLoop> loops;
  std::vector<DrilledFile> drilled;
  CourseSide side;
};

void AddWarnings(const std::string& file, const FileFindings& findings,
                 Warnings& warnings) {
  std::ranges::move(WarningsOf(FileName(file), findings), std::back_inserter(warnings));
}

Result<std::uint32_t> LayerOf(const contour::KicadBoard& board, const std::string& file,
                              const std::string& name) {
  if (name.empty()) return 0;
  const auto found = std::ranges::find(board.layers, name);
  if (found != board.layers.end())
    return static_cast<std::uint32_t>(found - board.layers.begin());
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("course.layer: {} has no copper layer {:?}; it has {}, and {} "
                          "as its outline",
                          file, name, fmt::join(board.layers, ", "), kOutlineLayer),
              name);
}

/// The outline of a board, as what it is made of asks for.
Status AddBoardOutline(const std::string& file, const contour::KicadBoard& board,
                       CourseMake make, CourseReading& reading) {
  if (board.outline.empty()) {
    return Fail(
        ErrorCode::kMissing,
        fmt::format("{}: has no outline on {}; draw it, or name a layer of copper "
                    "(course.layer): it has {}",
                    file, kOutlineLayer, fmt::join(board.layers, ", ")),
        file);
  }
  int number = 0;
  for (const contour::Edges& loop : board.outline) {
    std::string name = fmt::format("{}, outline {}", FileName(file), ++number);
    if (make == COURSE_MAKE_CURVES)
      reading.files.curves.push_back({std::move(name), loop, true});
    else
      reading.loops.push_back({std::move(name), loop, contour::BoxOfEdges(loop)});
  }
  return {};
}

std::optional<double> MiddleOf(const std::vector<contour::Edges>& outline) {
  if (outline.empty()) return {};
  contour::EdgeBox all = contour::BoxOfEdges(outline.front());
  for (const contour::Edges& loop : outline) {
    const contour::EdgeBox box = contour::BoxOfEdges(loop);
    all.min_mm = all.min_mm.cwiseMin(box.min_mm);
    all.max_mm = all.max_mm.cwiseMax(box.max_mm);
  }
  return 0.5 * (all.min_mm.x() + all.max_mm.x());
}

Status AddKicadBoard(const std::string& file, std::string_view text, const Course& course,
                     CourseReading& reading, Warnings& warnings) {
  auto board = INTAGLIO_TRY(contour::ReadKicadBoard(text, file));
  AddWarnings(file, board.findings, warnings);
  INTAGLIO_TRY(AddSlots(course, FileName(file), board.slots, reading.files, warnings));
  reading.drilled.push_back(
      {FileName(file), std::move(board.holes), std::move(board.slots), true});
  if (!reading.side.middle_x_mm) reading.side.middle_x_mm = MiddleOf(board.outline);
  if (course.layer() == kOutlineLayer ||
      (course.layer().empty() && course.make() == COURSE_MAKE_CUT))
    return AddBoardOutline(file, board, course.make(), reading);
  DrawnNets drawn{
      file, board.layers, INTAGLIO_TRY(LayerOf(board, file, course.layer())), {}};
  if (board.layers[drawn.layer] == "B.Cu")
    reading.side.back = fmt::format("layer B.Cu of {}", FileName(file));
  std::ranges::move(contour::ElementsOfLayer(board, drawn.layer),
                    std::back_inserter(reading.files.elements));
  drawn.elements = std::move(board.elements);
  reading.files.boards.push_back(std::move(drawn));
  return {};
}

Status AddDrillFile(const Course& course, const std::string& file, std::string_view text,
                    const CourseFileOptions& typed, CourseReading& reading,
                    Warnings& warnings) {
  contour::ExcellonOptions options;
  options.units = typed.drill_units;
  options.replace_units = typed.replace_drill_units;
  auto read = INTAGLIO_TRY(contour::ReadExcellon(text, file, options));
  AddWarnings(file, read.findings, warnings);
  INTAGLIO_TRY(AddSlots(course, FileName(file), read.slots, reading.files, warnings));
  reading.drilled.push_back(
      {FileName(file), std::move(read.holes), std::move(read.slots)});
  return {};
}

bool IsDrillFile(const std::string& file, std::string_view text) {
  const std::string extension = io::LowerCase(fs::path(file).extension().string());
  if (extension == ".kicad_pcb" || extension == ".xml") return false;
  const std::string_view head = text.substr(0, kHeadBytes);
  return head.find("%FS") == std::string_view::npos &&
         head.find("%MO") == std::string_view::npos &&
         head.find("M48") != std::string_view::npos;
}

Status AddBoard(const std::string& file, std::string_view text, const Course& course,
                CourseReading& reading, Warnings& warnings) {
  const std::string_view head = text.substr(0, kHeadBytes);
  const auto has = [&](std::string_view mark) {
    return head.find(mark) != std::string_view::npos;
  };
  const std::string extension = io::LowerCase(fs::path(file).extension().string());
  if (extension == ".kicad_pcb")
    return AddKicadBoard(file, text, course, reading, warnings);
  if (extension == ".xml") {
    const auto project = INTAGLIO_TRY(contour::ReadProject(text, file));
    contour::Board board = contour::BoardOf(project);
    std::ranges::move(board.elements, std::back_inserter(reading.files.elements));
    std::ranges::move(board.holes, std::back_inserter(reading.files.holes));
    return {};
  }
  if (has("%FS") || has("%MO")) {
    auto elements = INTAGLIO_TRY(contour::ReadGerber(text, file));
    std::ranges::move(elements, std::back_inserter(reading.files.elements));
    if (contour::DrawsBackOfBoard(text)) reading.side.back = FileName(file);
    return {};
  }
  return Fail(
      ErrorCode::kUnreadable,
      file +
          ": is neither a drawing (.dxf, .svg, .hpgl, .plt, .nci), a project (.xml), "
          "a board of KiCad (.kicad_pcb), a Gerber file with %FS..*%, nor an "
          "Excellon file with M48; export "
          "one of these",
      file);
}

bool Encloses(const DrawnLoop& loop, const Vec2& place_mm) {
  return (place_mm.array() >= loop.box.min_mm.array()).all() &&
         (place_mm.array() <= loop.box.max_mm.array()).all() &&
         contour::IsInside({{loop.edges}}, place_mm);
}

/// One that lies in an odd number of others is a hole of the smallest of these.
void AddOutlines(std::vector<DrawnLoop> loops, std::vector<contour::Element>& elements) {
  std::vector<std::vector<std::size_t>> around(loops.size());
  for (std::size_t i = 0; i < loops.size(); ++i) {
    const Vec2 begin_mm = loops[i].edges.front().begin_mm;
    for (std::size_t k = 0; k < loops.size(); ++k) {
      if (k != i && Encloses(loops[k], begin_mm)) around[i].push_back(k);
    }
  }
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (around[i].size() % 2 != 0) continue;
    contour::Outline outline{{loops[i].edges}};
    for (std::size_t k = 0; k < loops.size(); ++k) {
      // A hole of this one: it lies in it, and in what this one lies in.
      if (around[k].size() == around[i].size() + 1 &&
          std::ranges::find(around[k], i) != around[k].end())
        outline.loops.push_back(loops[k].edges);
    }
    elements.push_back({std::move(outline), loops[i].name});
  }
}

Status AddFile(const Course& course, const std::string& file, std::string_view text,
               const ReadLimits& limits, const CourseFileOptions& options,
               CourseReading& reading, Warnings& warnings) {
  Model model;
  model.set_file(file);
  const auto kind = KindOf(model);
  if (!kind || *kind != ModelKind::kDrawing) {
    return IsDrillFile(file, text)
               ? AddDrillFile(course, file, text, options, reading, warnings)
               : AddBoard(file, text, course, reading, warnings);
  }
  const auto drawing = ReadDrawing(file, text, limits.drawings, warnings);
  if (!drawing) return tl::unexpected(WithRemedy(drawing.error(), limits));
  AddWarnings(file, PointsIn(*drawing), warnings);
  return course.make() == COURSE_MAKE_CURVES ? AddCurves(file, *drawing, reading.files)
                                             : AddLoops(file, *drawing, reading.loops);
}

}  // namespace

Result<CourseFiles> CourseFilesOf(const Course& course,
                                  const std::vector<std::string_view>& texts,
                                  const ReadLimits& limits, Warnings& warnings,
                                  const CourseFileOptions& options) {
  Require(texts.size() == static_cast<std::size_t>(course.files_size()),
          "{} texts are those of {} files", texts.size(), course.files_size());
  CourseReading reading;
  for (int i = 0; i < course.files_size(); ++i)
    INTAGLIO_TRY(AddFile(course, course.files(i), texts[static_cast<std::size_t>(i)],
                         limits, options, reading, warnings));
  CourseFiles& files = reading.files;
  AddOutlines(std::move(reading.loops), files.elements);
  std::ranges::move(INTAGLIO_TRY(WarningsOfHoles(reading.drilled, files.elements)),
                    std::back_inserter(warnings));
  for (const DrilledFile& file : reading.drilled)
    files.holes.insert(files.holes.end(), file.holes.begin(), file.holes.end());
  if (files.elements.empty() && files.holes.empty() && files.curves.empty()) {
    std::string why =
        fmt::format("{}: holds nothing to make", fmt::join(course.files(), ", "));
    if (!warnings.empty()) why += "; " + warnings.front().text;
    return Fail(ErrorCode::kMissing, why);
  }
  TurnToSide(options, reading.side, files, warnings);
  return std::move(files);
}

}  // namespace intaglio
