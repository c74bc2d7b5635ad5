#include "services/job/course/course_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "engrave/contour/files/drawing_loops.h"
#include "engrave/contour/files/excellon_read.h"
#include "engrave/contour/files/gerber_read.h"
#include "engrave/contour/files/kicad_read.h"
#include "engrave/contour/files/project_file.h"
#include "engrave/contour/region/region_index.h"
#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/io/lower_case.h"
#include "services/job/model_kind.h"
#include "services/job/models/flat_models.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
/// Ends of curves that are one contour: below what a drawing program rounds to.
constexpr double kJoinedEndsMm = 0.01;
/// Of splines and ellipses: below the resolution of every machine.
constexpr double kChordsMm = 0.001;
/// A drill file declares itself in its first lines.
constexpr std::size_t kHeadBytes = 4096;

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

void WarnOfDrillFile(const std::string& file, const contour::DrillFile& drilled,
                     Warnings& warnings) {
  const auto warn = [&](std::string text) {
    Warning warning = MakeWarning(WarningCode::kLeftOut, std::move(text));
    warning.weight = WarningWeight::kWarning;
    warnings.push_back(std::move(warning));
  };
  for (const auto& [command, count] : drilled.left_out) {
    warn(fmt::format("{}: left out {} commands {}", FileName(file), count, command));
  }
  if (drilled.slots.empty()) return;
  warn(fmt::format(
      "{}: left out {} slots, the first {}; mill them from a drawing with "
      "--make curves",
      FileName(file), drilled.slots.size(), contour::Describe(drilled.slots.front())));
}

Result<std::uint32_t> LayerOf(const contour::KicadBoard& board, const std::string& file,
                              const std::string& name) {
  if (name.empty()) return 0;
  const auto found = std::ranges::find(board.layers, name);
  if (found != board.layers.end())
    return static_cast<std::uint32_t>(found - board.layers.begin());
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("course.layer: {} has no copper layer {:?}; it has {}", file,
                          name, fmt::join(board.layers, ", ")),
              name);
}

Status AddKicadBoard(const std::string& file, std::string_view text,
                     const std::string& layer, CourseFiles& files, Warnings& warnings) {
  auto board = INTAGLIO_TRY(contour::ReadKicadBoard(text, file));
  DrawnNets drawn{file, board.layers, INTAGLIO_TRY(LayerOf(board, file, layer)), {}};
  std::ranges::move(contour::ElementsOfLayer(board, drawn.layer),
                    std::back_inserter(files.elements));
  contour::DrillFile drilled;
  drilled.slots = std::move(board.slots);
  drilled.left_out.insert(board.left_out.begin(), board.left_out.end());
  WarnOfDrillFile(file, drilled, warnings);
  std::ranges::move(board.holes, std::back_inserter(files.holes));
  drawn.elements = std::move(board.elements);
  files.boards.push_back(std::move(drawn));
  return {};
}

Status AddBoard(const std::string& file, std::string_view text, const std::string& layer,
                CourseFiles& files, Warnings& warnings) {
  const std::string_view head = text.substr(0, kHeadBytes);
  const auto has = [&](std::string_view mark) {
    return head.find(mark) != std::string_view::npos;
  };
  const std::string extension = io::LowerCase(fs::path(file).extension().string());
  if (extension == ".kicad_pcb") return AddKicadBoard(file, text, layer, files, warnings);
  if (extension == ".xml") {
    const auto project = INTAGLIO_TRY(contour::ReadProject(text, file));
    contour::Board board = contour::BoardOf(project);
    std::ranges::move(board.elements, std::back_inserter(files.elements));
    std::ranges::move(board.holes, std::back_inserter(files.holes));
    return {};
  }
  if (has("%FS") || has("%MO")) {
    auto elements = INTAGLIO_TRY(contour::ReadGerber(text, file));
    std::ranges::move(elements, std::back_inserter(files.elements));
    return {};
  }
  if (has("M48")) {
    auto drilled = INTAGLIO_TRY(contour::ReadExcellon(text, file));
    WarnOfDrillFile(file, drilled, warnings);
    std::ranges::move(drilled.holes, std::back_inserter(files.holes));
    return {};
  }
  return Fail(ErrorCode::kUnreadable,
              file +
                  ": is neither a drawing (.dxf, .svg, .hpgl, .plt), a project (.xml), "
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

}  // namespace

Result<CourseFiles> CourseFilesOf(const Course& course,
                                  const std::vector<std::string_view>& texts,
                                  const ReadLimits& limits, Warnings& warnings) {
  Require(texts.size() == static_cast<std::size_t>(course.files_size()),
          "{} texts are those of {} files", texts.size(), course.files_size());
  CourseFiles files;
  std::vector<DrawnLoop> loops;
  for (int i = 0; i < course.files_size(); ++i) {
    const std::string& file = course.files(i);
    const std::string_view text = texts[static_cast<std::size_t>(i)];
    Model model;
    model.set_file(file);
    const auto kind = KindOf(model);
    if (!kind || *kind != ModelKind::kDrawing) {
      INTAGLIO_TRY(AddBoard(file, text, course.layer(), files, warnings));
      continue;
    }
    const auto drawing = ReadDrawing(file, text, limits.drawings, warnings);
    if (!drawing) return tl::unexpected(WithRemedy(drawing.error(), limits));
    INTAGLIO_TRY(course.make() == COURSE_MAKE_CURVES ? AddCurves(file, *drawing, files)
                                                     : AddLoops(file, *drawing, loops));
  }
  AddOutlines(std::move(loops), files.elements);
  if (files.elements.empty() && files.holes.empty() && files.curves.empty()) {
    return Fail(ErrorCode::kMissing, fmt::format("{}: holds nothing to make",
                                                 fmt::join(course.files(), ", ")));
  }
  return files;
}

}  // namespace intaglio
