#include "services/cli/sheet/sheet_command.h"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engrave/contour/files/drawing_loops.h"
#include "engrave/contour/milling/material_use.h"
#include "engrave/contour/milling/nest.h"
#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/image/image_file.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/whole_file.h"
#include "engrave/render/png_file.h"
#include "services/cli/contour/contour_picture.h"
#include "services/cli/flags/size_limits_flag.h"
#include "services/cli/sheet/sheet_picture.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/job/convert/model_kind.h"
#include "services/job/models/flat_models.h"
#include "services/job/models/read_limits.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct SheetOptions {
  std::vector<std::string> files;
  std::vector<double> sheet_mm;
  double pixels_per_mm = 1, gap_mm = 2, margin_mm = 5, size_limits = 1;
  std::uint32_t copies = 1;
  bool upright = false;
  std::string out, picture;
};

/// A picture or a drawing, or what is wrong with the file.
Result<bool> IsPicture(const std::string& file) {
  const auto kind = KindOfFile(file);
  if (!kind) return Fail(kind.error().code, file + ": " + kind.error().message, file);
  if (*kind == ModelKind::kImage || *kind == ModelKind::kDrawing)
    return *kind == ModelKind::kImage;
  return Fail(ErrorCode::kUnsupported,
              fmt::format("{}: is {}; parts and sheets are read from a drawing or, for "
                          "their use, a picture",
                          file, NameOf(*kind)),
              file);
}

Result<std::vector<contour::Edges>> ReadLoops(const std::string& file,
                                              double size_limits) {
  const ReadLimits limits = ReadLimitsTimes(size_limits);
  const std::string text = INTAGLIO_TRY(io::ReadWholeFile(file, limits.max_file_bytes));
  Warnings warnings;
  const auto drawing = ReadDrawing(file, text, limits.drawings, warnings);
  if (!drawing) return tl::unexpected(WithRemedy(drawing.error(), limits));
  PrintWarningLines(warnings);
  auto loops = contour::LoopsOfDrawing(*drawing);
  if (!loops) loops.error().message = file + ": " + loops.error().message;
  return loops;
}

contour::Edges RectangleOf(const Vec2& a, const Vec2& sides) {
  const Vec2 b = a + sides, right(b.x(), a.y()), left(a.x(), b.y());
  return {contour::MakeLine(a, right), contour::MakeLine(right, b),
          contour::MakeLine(b, left), contour::MakeLine(left, a)};
}

/// The sheet around the middle of all loops: where it is does not matter for its use.
Result<contour::Edges> SheetAround(const std::vector<contour::Edges>& loops,
                                   const Vec2& sheet_mm) {
  Vec2 low(1e300, 1e300), high(-1e300, -1e300);
  for (const contour::Edges& loop : loops) {
    for (const contour::Edge& edge : loop) {
      for (int k = 0; k < 4; ++k) {
        const Vec2 place = contour::PointAt(edge, edge.length_mm * k / 4);
        low = low.cwiseMin(place);
        high = high.cwiseMax(place);
      }
    }
  }
  const Vec2 sides = high - low;
  if ((sides.array() >= sheet_mm.array()).any()) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("--sheet: the drawing of {:.4g} x {:.4g} mm does not lie "
                            "within a sheet of {:.4g} x {:.4g} mm; give a larger one",
                            sides.x(), sides.y(), sheet_mm.x(), sheet_mm.y()));
  }
  return RectangleOf((low + high - sheet_mm) / 2, sheet_mm);
}

Status RequireSides(const std::vector<double>& sheet_mm) {
  for (const double side : sheet_mm) {
    if (side >= 1 && side <= 100'000) continue;
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("--sheet: {:g} mm is outside 1..100000", side),
                fmt::format("{:g}", side));
  }
  return {};
}

Result<contour::MaterialUse> UseOf(const SheetOptions& options) {
  const std::string& file = options.files[0];
  if (INTAGLIO_TRY(IsPicture(file))) {
    const ReadLimits limits = ReadLimitsTimes(options.size_limits);
    const std::string bytes =
        INTAGLIO_TRY(io::ReadWholeFile(file, limits.max_file_bytes));
    image::ImageOptions read;
    read.samples = image::Samples::kAsStored;
    read.limits = limits.images;
    const auto picture = image::ParseImage(bytes, read);
    if (!picture) {
      return Fail(picture.error().code, file + ": " + picture.error().message,
                  picture.error().value);
    }
    return contour::MaterialUseOf(picture->samples, options.pixels_per_mm);
  }
  auto loops = INTAGLIO_TRY(ReadLoops(file, options.size_limits));
  if (!options.sheet_mm.empty()) {
    loops.push_back(
        INTAGLIO_TRY(SheetAround(loops, Vec2(options.sheet_mm[0], options.sheet_mm[1]))));
  }
  return contour::MaterialUseOf(loops);
}

Status PrintUse(const SheetOptions& options) {
  INTAGLIO_TRY(RequireSides(options.sheet_mm));
  const contour::MaterialUse use = INTAGLIO_TRY(UseOf(options));
  fmt::print(std::cout, "sheet         {:.2f} mm2\n", use.sheet_mm2);
  if (!INTAGLIO_TRY(IsPicture(options.files[0]))) {
    fmt::print(std::cout, "parts         {}, {:.2f} mm2\n", use.part_count,
               use.parts_mm2);
    fmt::print(std::cout, "holes         {}, {:.2f} mm2\n", use.hole_count,
               use.holes_mm2);
  }
  fmt::print(std::cout, "used          {:.2f} mm2\n", use.used_mm2);
  fmt::print(std::cout, "use           {:.2f} %\n", use.use_percent);
  return {};
}

/// plate.svg, plate_2.svg ...
fs::path FileOfSheet(const fs::path& out, std::uint32_t sheet) {
  if (sheet == 0) return out;
  return out.parent_path() /
         fmt::format("{}_{}{}", out.stem().string(), sheet + 1, out.extension().string());
}

Status Nest(const SheetOptions& options) {
  INTAGLIO_TRY(RequireSides(options.sheet_mm));
  std::vector<contour::Region> parts;
  for (const std::string& file : options.files) {
    const auto area = INTAGLIO_TRY(
        contour::RegionOfLoops(INTAGLIO_TRY(ReadLoops(file, options.size_limits))));
    for (const contour::Region& part : contour::ConnectedParts(area)) {
      for (std::uint32_t k = 0; k < options.copies; ++k) parts.push_back(part);
    }
  }
  contour::NestOptions nest_options;
  nest_options.sheet_mm = Vec2(options.sheet_mm[0], options.sheet_mm[1]);
  nest_options.gap_mm = options.gap_mm;
  nest_options.margin_mm = options.margin_mm;
  nest_options.turn = !options.upright;
  const contour::Nest nest = INTAGLIO_TRY(contour::NestParts(parts, nest_options));
  fmt::print(std::cout, "parts         {} on {} of {:g} x {:g} mm\n", parts.size(),
             Counted(nest.sheet_count, "sheet"), options.sheet_mm[0],
             options.sheet_mm[1]);
  fmt::print(std::cout, "use           {:.2f} %\n", nest.use_percent);
  fmt::print(std::cout, "last sheet    used to {:.1f} mm of its height\n",
             nest.last_top_mm);
  std::vector<SheetDrawing> sheets(nest.sheet_count);
  for (const contour::NestedPart& place : nest.parts)
    sheets[place.sheet].parts.push_back(contour::Placed(parts[place.part], place));
  if (!options.picture.empty()) {
    const render::Canvas picture =
        DrawSheets(sheets, nest_options.sheet_mm, options.margin_mm);
    INTAGLIO_TRY(render::WritePng(options.picture, picture));
    fmt::print(std::cout, "picture       {}\n", options.picture);
  }
  if (options.out.empty()) return {};
  for (std::uint32_t k = 0; k < nest.sheet_count; ++k) {
    const fs::path file = FileOfSheet(options.out, k);
    INTAGLIO_TRY(io::WriteFileAtomically(
        file, SvgOfSheet(sheets[k].parts, nest_options.sheet_mm)));
    fmt::print(std::cout, "sheet         {}\n", file.string());
  }
  return {};
}

void AddUseCommand(command_line::Command sheet) {
  auto options = std::make_shared<SheetOptions>();
  command_line::Command use = sheet.AddCommand("use", "how much of a sheet parts use");
  use.AddOption(
         "FILE", options->files,
         "drawing (.dxf .svg .hpgl .plt .nci) of the parts and their holes, its "
         "outermost contour the sheet, or picture (.png .jpg .tif .bmp .pcx) of the "
         "sheet, parts black")
      .Require()
      .TakeValues(1);
  use.AddOption("--sheet", options->sheet_mm,
                "mm, width and height of the sheet, where the drawing has none")
      .TakeValues(2);
  use.AddOption("--pixels-per-mm", options->pixels_per_mm, "of a picture")
      .Within(0.001, 10000.0)
      .ShowDefault();
  AddSizeLimitsFlag(use, options->size_limits);
  use.SetFooter(
      "Example: intaglio sheet use plate.dxf --sheet 600 400\n"
      "Exit code: 0 good, 2 wrong input.");
  use.SetAction([options] {
    const Status made = PrintUse(*options);
    return made ? client::kExitGood : Complain(made.error());
  });
}

void AddNestCommand(command_line::Command sheet) {
  auto options = std::make_shared<SheetOptions>();
  command_line::Command nest =
      sheet.AddCommand("nest", "put parts on as few sheets as possible");
  nest.AddOption(
          "FILE", options->files,
          "drawings (.dxf .svg .hpgl .plt .nci); each closed contour, with the holes "
          "in it, is a part")
      .Require();
  nest.AddOption("--sheet", options->sheet_mm, "mm, width and height of a sheet")
      .TakeValues(2)
      .Require();
  nest.AddOption("--gap", options->gap_mm, "mm between parts, at least the kerf")
      .Within(0.0, 1000.0)
      .ShowDefault();
  nest.AddOption("--margin", options->margin_mm, "mm along the sheet's border")
      .Within(0.0, 1000.0)
      .ShowDefault();
  nest.AddOption("--copies", options->copies, "of each part")
      .Within(1, 1000)
      .ShowDefault();
  nest.AddFlag("--upright", options->upright, "turn no part");
  nest.AddOption("--out", options->out,
                 "SVG, 1:1, of the parts on a sheet; further sheets are NAME_2.svg ...");
  nest.AddOption("--picture", options->picture,
                 "PNG of all sheets with their parts, to look at");
  AddSizeLimitsFlag(nest, options->size_limits);
  nest.SetFooter(
      "Example: intaglio sheet nest parts.dxf --sheet 600 400 --out sheet.svg --picture "
      "sheets.png\n"
      "Exit code: 0 good, 2 wrong input.");
  nest.SetAction([options] {
    const Status made = Nest(*options);
    return made ? client::kExitGood : Complain(made.error());
  });
}

}  // namespace

void AddSheetCommand(command_line::Command app) {
  command_line::Command sheet =
      app.AddCommand("sheet", "parts on sheets of material: their use and their places");
  sheet.RequireCommand();
  AddUseCommand(sheet);
  AddNestCommand(sheet);
  sheet.SetFooter("Example: intaglio sheet use plate.dxf --sheet 600 400");
}

}  // namespace intaglio::cli
