// `intaglio galvo plan`: how fast a web may run under a scan head that marks it.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/galvo/web_order.h"
#include "engrave/io/atomic_file.h"
#include "engrave/render/png_file.h"
#include "engrave/render/web/web_picture.h"
#include "services/cli/galvo/drawing_strokes.h"
#include "services/cli/galvo/galvo_command.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"

namespace intaglio::cli {
namespace {

constexpr std::size_t kMaxMarks = 50'000;  // a look-ahead of some seconds

struct WebPlanOptions {
  DrawingOptions drawing;
  std::string csv, picture;
  double field_mm = 0, delay_ms = 0.6;
  std::optional<double> pitch_mm, web_mm_s;
  std::uint32_t repeats = 1;
};

struct WebContent {
  std::vector<galvo::MarkStroke> strokes;
  std::vector<galvo::WebMark> marks;  // one a stroke
};

/// One mark a stroke. What is at the right of the drawing arrives first.
Result<galvo::WebMark> MarkOf(const galvo::MarkStroke& stroke, std::size_t number,
                              const WebPlanOptions& options) {
  const Box3 box = ExtentOfStroke(stroke);
  const Vec3 low = box.min_mm, high = box.max_mm;
  if (box.size_mm().x() >= options.field_mm ||
      std::max(high.y(), -low.y()) > options.field_mm / 2) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("{}: contour {} is {:.4g} mm long and lies in y {:.4g}..{:.4g} "
                    "mm from the middle; the field is {:.4g} mm: divide it, or use "
                    "a larger field",
                    options.drawing.file, number + 1, box.size_mm().x(), low.y(),
                    high.y(), options.field_mm));
  }
  return galvo::WebMark{
      {-box.center_mm().x(), box.center_mm().y()},
      box.size_mm().x(),
      LengthOfStroke(stroke) / options.drawing.mark_mm_s + options.delay_ms / 1000};
}

Result<WebContent> ReadContent(const WebPlanOptions& options) {
  const auto once = INTAGLIO_TRY(ReadMarkStrokes(options.drawing));
  if (once.size() * options.repeats > kMaxMarks) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("{}: {} {} are more than {} marks; plan fewer "
                            "repeats",
                            options.drawing.file, Counted(once.size(), "contour"),
                            Counted(static_cast<std::uint64_t>(options.repeats), "time"),
                            kMaxMarks));
  }
  if (options.repeats > 1 && !options.pitch_mm)
    return Fail(ErrorCode::kMissing, "--repeats: needs --pitch, the way of a repeat, mm");
  WebContent content;
  for (std::uint32_t k = 0; k < options.repeats; ++k) {
    for (const galvo::MarkStroke& stroke : once) {
      galvo::MarkStroke moved = stroke;
      for (Vec2& p : moved.points_mm) p.x() -= k * options.pitch_mm.value_or(0);
      content.marks.push_back(
          INTAGLIO_TRY(MarkOf(moved, content.marks.size() % once.size(), options)));
      content.strokes.push_back(std::move(moved));
    }
  }
  return content;
}

std::vector<std::string> WebFigures(const WebContent& content,
                                    const galvo::WebOrder& arrival,
                                    const galvo::WebOrder& fastest, double field_mm) {
  double total_s = 0, first_mm = arrival.timed.front().along_mm, last_mm = first_mm;
  for (const galvo::TimedMark& mark : arrival.timed) {
    total_s += mark.time_s;
    last_mm = std::max(last_mm, mark.along_mm);
  }
  const double frames_mm_s = galvo::FrameSpeed(arrival.timed, field_mm).value();
  const auto gain = [&](double mm_s) {
    return fmt::format("{:.1f} mm/s, {:.2f} times frames", mm_s, mm_s / frames_mm_s);
  };
  return {
      fmt::format("marks         {} in {:.4g} mm of web, {:.3f} ms each with its jump",
                  content.marks.size(), last_mm - first_mm,
                  1e3 * total_s / static_cast<double>(content.marks.size())),
      fmt::format("frames        {:.1f} mm/s, by frames of half the field", frames_mm_s),
      "arrival       " + gain(arrival.max_mm_s),
      "chosen order  " + gain(fastest.max_mm_s)};
}

Status WriteOrder(const std::string& file, const WebContent& content,
                  const galvo::WebOrder& order, const std::vector<bool>& missed) {
  std::string text = "order,contour,x_mm,y_mm,time_ms,missed\n";
  for (std::size_t k = 0; k < order.order.size(); ++k) {
    const galvo::WebMark& mark = content.marks[order.order[k]];
    text +=
        fmt::format("{},{},{},{},{},{}\n", k + 1, order.order[k] + 1, -mark.centre_mm.x(),
                    mark.centre_mm.y(), 1e3 * order.timed[k].time_s, missed[k] ? 1 : 0);
  }
  return io::WriteFileAtomically(file, std::string_view(text));
}

Status DrawPlan(const WebPlanOptions& options, const WebContent& content,
                const galvo::WebOrder& order, std::vector<bool> missed,
                const std::vector<std::string>& figures) {
  render::WebPicture picture{
      {},
      std::move(missed),
      options.field_mm,
      std::filesystem::path(options.drawing.file).filename().string(),
      figures};
  for (const std::size_t mark : order.order)
    picture.marks_mm.push_back(OutlineOf(content.strokes[mark]));
  return render::WritePng(options.picture, render::DrawWeb(picture));
}

/// Whether all marks are made at the speed of the web, if one is given.
Result<bool> PlanWeb(const WebPlanOptions& options) {
  const WebContent content = INTAGLIO_TRY(ReadContent(options));
  const galvo::WebHead head{options.field_mm, options.drawing.jump_mm_s};
  const auto arrival = INTAGLIO_TRY(galvo::ArrivalOrder(content.marks, head));
  const auto fastest = INTAGLIO_TRY(galvo::FastestOrder(content.marks, head));
  std::vector<std::string> figures =
      WebFigures(content, arrival, fastest, options.field_mm);
  std::vector<bool> missed(content.marks.size(), false);
  bool good = true;
  if (options.web_mm_s) {
    const auto indices =
        galvo::MissedMarks(fastest.timed, options.field_mm, *options.web_mm_s);
    for (const std::size_t k : indices) missed[k] = true;
    good = indices.empty();
    figures.push_back(
        good ? fmt::format("verdict       all marks are made at {:.6g} mm/s",
                           *options.web_mm_s)
             : fmt::format("verdict       at {:.6g} mm/s {} of {} {} missed, first "
                           "contour {} at x {:.4g} mm",
                           *options.web_mm_s, indices.size(),
                           Counted(missed.size(), "mark"), IsOrAre(indices.size()),
                           fastest.order[indices.front()] + 1,
                           -fastest.timed[indices.front()].along_mm));
  }
  for (const std::string& line : figures) std::cout << line << "\n";
  if (!options.csv.empty())
    INTAGLIO_TRY(WriteOrder(options.csv, content, fastest, missed));
  if (!options.picture.empty())
    INTAGLIO_TRY(DrawPlan(options, content, fastest, missed, figures));
  return good;
}

}  // namespace

void AddGalvoPlanCommand(command_line::Command galvo) {
  auto o = std::make_shared<WebPlanOptions>();
  command_line::Command plan =
      galvo.AddCommand("plan", "how fast a web may run, and the order of its marks");
  AddDrawingOptions(plan, o->drawing);
  plan.AddOption("--field", o->field_mm, "width of the square field, mm")
      .Within(1.0, 2000.0)
      .Require();
  plan.AddOption("--delay", o->delay_ms, "ms of delays and run-in of each mark")
      .Within(0.0, 1000.0)
      .ShowDefault();
  plan.AddOption("--repeats", o->repeats, "of the drawing along the web").ShowDefault();
  plan.AddOption("--pitch", o->pitch_mm, "mm from one repeat to the next").Positive();
  plan.AddOption("--web-speed", o->web_mm_s, "mm/s: are all marks made at this speed?")
      .Positive();
  plan.AddOption("--csv", o->csv, "the order, one row for each mark");
  plan.AddOption("--picture", o->picture, "PNG: the marks in their order");
  plan.SetFooter(
      "Example: intaglio galvo plan label.svg --field 20 --repeats 10 --pitch 30\n"
      "The web moves along +x of the drawing: what is at the right arrives first.\n"
      "Exit code: 0 good, 2 wrong input, 3 marks are missed at --web-speed.");
  plan.SetAction([o]() -> int {
    const auto good = PlanWeb(*o);
    if (!good) return Complain(good.error(), client::kExitWrongInput);
    return *good ? client::kExitGood : client::kExitNotGood;
  });
}

}  // namespace intaglio::cli
