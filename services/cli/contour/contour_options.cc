#include "services/cli/contour/contour_options.h"

#include <google/protobuf/descriptor.h>

#include <cctype>
#include <string_view>

#include "engrave/core/check.h"
#include "engrave/io/lower_case.h"
#include "services/cli/flags/field_options.h"

namespace intaglio::cli {
namespace {

constexpr std::string_view kMakePrefix = "COURSE_MAKE_";

/// COURSE_MAKE_OUTLINE is outline.
std::vector<std::string> MakeNames() {
  std::vector<std::string> names;
  for (int i = 0; i < CourseMake_descriptor()->value_count(); ++i) {
    const std::string name = CourseMake_descriptor()->value(i)->name();
    names.push_back(io::LowerCase(std::string_view(name).substr(kMakePrefix.size())));
  }
  return names;
}

CourseMake MakeOf(const std::string& name) {
  std::string value(kMakePrefix);
  for (const char c : name)
    value += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  CourseMake make = COURSE_MAKE_ISOLATION;
  Require(CourseMake_Parse(value, &make), "--make '{}' has passed its check", name);
  return make;
}

void SetNumber(const google::protobuf::FieldDescriptor& field, double value,
               Course& course) {
  const google::protobuf::Reflection& reflection = *course.GetReflection();
  if (field.cpp_type() == google::protobuf::FieldDescriptor::CPPTYPE_UINT32) {
    reflection.SetUInt32(&course, &field, static_cast<std::uint32_t>(value));
  } else {
    reflection.SetDouble(&course, &field, value);
  }
}

void AddToolOptions(command_line::Command contour, ContourOptions& options) {
  contour
      .AddOption("--make", options.make,
                 "isolation: around the copper, so that its nets are cut apart; outline: "
                 "once around everything; curves: along the curves of drawings; pocket: "
                 "clear what they enclose; cut: parts out of a sheet")
      .OneOf(MakeNames())
      .ShowDefault();
  contour.AddOption("--layer", options.layer,
                    "of a board of KiCad, e.g. B.Cu; default of cuts Edge.Cuts, else its "
                    "first of copper");
  contour
      .AddOption("--mirror", options.mirror,
                 "all is turned over; auto: when a file draws the back of a board")
      .OneOf({"auto", "yes", "no"})
      .ShowDefault();
  contour
      .AddOption(
          "--mirror-x", options.mirror_x_mm,
          "mm, of the line along y about which it is; default the middle of a board "
          "of KiCad, else 0")
      .Within(-10000.0, 10000.0);
  const auto align = contour.AddOption(
      "--align", options.alignment_y_mm,
      "Y1 Y2, mm: holes for pins on this line, beside the board, which hold it where it "
      "is turned over");
  align.TakeValues(2);
  contour
      .AddOption("--align-diameter", options.alignment_diameter_mm, "mm, of these holes")
      .Within(0.1, 50.0)
      .ShowDefault()
      .Need(align);
  const auto units = contour.AddOption(
      "--drill-units", options.drill_units,
      "of drill files that declare none: the line of their header, e.g. "
      "INCH,TZ or METRIC,LZ,000.000");
  contour
      .AddFlag("--replace-drill-units", options.replace_drill_units,
               "--drill-units goes before what drill files declare, which is a warning")
      .Need(units);
  contour.AddFlag("--inside", options.inside,
                  "of cuts: openings into a sheet, and not parts out of it");
  contour
      .AddOption("--corners", options.corners,
                 "of outlines: sharp as published, or round as the tool leaves them")
      .OneOf({"sharp", "round"})
      .ShowDefault();
  contour
      .AddOption("--order", options.order,
                 "improved, or to the nearest contour as published")
      .OneOf({"improved", "nearest"})
      .ShowDefault();
  contour.AddOption("--start", options.start_mm, "mm, x and y where the tool comes from")
      .TakeValues(2);
}

/// The numbers of a course, by the rules of its fields.
void AddNumbers(command_line::Command contour, ContourOptions& options) {
  for (const auto* field : FieldsOf(*Course::descriptor())) {
    if (!RuleOf(*field).option().empty())
      AddFieldOption(contour, *field, options.numbers[field->number()]);
  }
  contour.OptionOf("--tab-distance").Exclude(contour.OptionOf("--tabs"));
  contour.OptionOf("--power").Exclude(contour.OptionOf("--depth"));
}

void AddProgramOptions(command_line::Command contour, ContourOptions& options) {
  const auto mill = contour.AddOption("--template", options.mill_template,
                                      "of the program: a name in deploy/post/mill (grbl, "
                                      "grbl-laser, hpgl, krl, krl-full, "
                                      "linuxcnc, sinumerik), or a file");
  const auto out = contour.AddOption("--out", options.out, "the program").Need(mill);
  contour
      .AddOption("--drill-template", options.drill_template,
                 "of the holes: a name in deploy/post/drill, or a file; default the name "
                 "of the template")
      .Need(out);
  contour
      .AddOption(
          "--parameter", options.parameters,
          "NAME=TEXT, of the templates, e.g. BASE_DATA=4 of krl-full; once for each")
      .Need(out);
  contour.AddOption("--origin", options.origin_mm, "mm, x and y that become 0 0")
      .TakeValues(2)
      .Need(out);
  contour.AddFlag("--chords", options.chords, "lines in place of arcs").Need(out);
  contour
      .AddOption("--chord-tolerance", options.chord_um,
                 "um, of lines in place of arcs; default the template's, 1")
      .Within(0.1, 1000.0)
      .Need(out);
  contour
      .AddOption("--max-bytes", options.max_bytes,
                 "maximum size of a program; longer ones are divided")
      .Within(200, 1'000'000'000)
      .Need(out);
  const auto heights = contour.AddOption("--height-map", options.height_map,
                                         "probed heights of the surface, x y z a line, "
                                         "or answers of Grbl: the tool follows");
  heights.Need(out);
  contour
      .AddOption("--height-map-zero", options.height_zero_mm,
                 "mm, x y z of the work's zero in the places of the heights")
      .TakeValues(3)
      .Need(heights);
  contour
      .AddOption("--probe-grid", options.probe_step_mm,
                 "mm: also a program, NAME_probe, that measures the surface so far apart")
      .Within(0.1, 1000.0)
      .Need(out);
  contour
      .AddOption("--axis-speed", options.axis_speed_deg_s,
                 "deg/s, maximum of a lathe's turning axis; default the template's")
      .Within(0.01, 100000.0)
      .Need(out);
}

void AddViewOptions(command_line::Command contour, ContourOptions& options) {
  contour.AddOption("--picture", options.picture,
                    "SVG, 1:1: copper, contours by pass, idle ways, holes");
  contour.AddOption("--xml", options.xml, "the elements and holes as a project");
  const auto frames =
      contour.AddOption("--frames", options.frames,
                        "folder of an animation: PNG files and a table of them");
  contour
      .AddOption("--frame-step", options.frame_step_s,
                 "s between frames, default a hundredth of the time")
      .Within(0.001, 1000.0)
      .Need(frames);
  contour.AddOption("--page", options.page,
                    "HTML: play, pause, stop and feed of the work in a browser");
  contour.AddOption(
      "--machine", options.machine,
      "profile whose drive follows: time, frames and page with planned speeds");
}

}  // namespace

Course TypedCourse(const ContourOptions& options) {
  Course course;
  for (const std::string& file : options.files) course.add_files(file);
  course.set_make(MakeOf(options.make));
  course.set_round_corners(options.corners == "round");
  course.set_nearest_order(options.order == "nearest");
  if (!options.layer.empty()) course.set_layer(options.layer);
  if (options.inside) course.set_inside(true);
  for (const auto& [number, value] : options.numbers) {
    if (value) SetNumber(FieldOf<Course>(number), *value, course);
  }
  return course;
}

Result<post::Parameters> TypedParameters(const ContourOptions& options) {
  post::Parameters parameters;
  for (const std::string& typed : options.parameters) {
    const std::size_t equals = typed.find('=');
    if (equals == std::string::npos || equals == 0 ||
        !parameters.emplace(typed.substr(0, equals), typed.substr(equals + 1)).second) {
      return Fail(ErrorCode::kInvalidValue,
                  "--parameter: '" + typed + "' is not NAME=TEXT, or NAME is given twice",
                  typed);
    }
  }
  return parameters;
}

CourseFileOptions TypedFileOptions(const ContourOptions& options) {
  CourseFileOptions typed;
  typed.drill_units = options.drill_units;
  typed.replace_drill_units = options.replace_drill_units;
  if (options.mirror != "auto") typed.mirror = options.mirror == "yes";
  typed.mirror_x_mm = options.mirror_x_mm;
  typed.alignment_y_mm = options.alignment_y_mm;
  typed.alignment_diameter_mm = options.alignment_diameter_mm;
  return typed;
}

void AddContourOptions(command_line::Command contour, ContourOptions& options) {
  AddToolOptions(contour, options);
  AddNumbers(contour, options);
  AddProgramOptions(contour, options);
  AddViewOptions(contour, options);
}

}  // namespace intaglio::cli
