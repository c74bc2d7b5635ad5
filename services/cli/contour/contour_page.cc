#include "services/cli/contour/contour_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "services/client/preview/preview_page.h"

namespace intaglio::cli {
namespace {

constexpr double kSampleStepS = 0.005;
constexpr double kMaxSamples = 4000;

constexpr std::string_view kPageStyle = R"(
  body { margin: 0; background: #10141a; color: #e6ecf2;
         font: 15px/1.4 system-ui, sans-serif; }
  canvas { display: block; width: 100vw; height: calc(100vh - 8.5rem); }
  .row { display: flex; gap: .8rem; align-items: center; padding: .4rem .8rem; }
  .row label { display: flex; gap: .5rem; align-items: center; }
  button { font: inherit; padding: .25rem .9rem; }
  #progress { flex: 1; }
  #text { font-variant-numeric: tabular-nums; }
  #text span { min-width: 9rem; }
  .legend { gap: 1.6rem; font-size: 13px; }
  .legend i { display: inline-block; width: 1.1rem; height: .7rem; margin-right: .4rem; }
)";

// Finds the tool at a time, as ContourMotion::At does, and keeps the time of the view.
constexpr std::string_view kModelScript = R"(
"use strict";
function edgeLength(e) {
  return e.length > 4 ? Math.abs(e[8]) * e[6] : Math.hypot(e[2] - e[0], e[3] - e[1]);
}
function pointOn(e, way) {
  const length = edgeLength(e), part = length > 0 ? way / length : 0;
  if (e.length === 4) return [e[0] + (e[2] - e[0]) * part, e[1] + (e[3] - e[1]) * part];
  const angle = e[7] + e[8] * part;
  return [e[4] + e[6] * Math.cos(angle), e[5] + e[6] * Math.sin(angle)];
}
function wayAt(leg, time) {
  if (leg.edges.length === 0 || leg.duration <= 0) return 0;
  const part = Math.min(Math.max(time - leg.begin, 0), leg.duration) / leg.duration;
  if (!leg.ways) return leg.length * part;
  const u = part * (leg.ways.length - 1);
  const i = Math.min(Math.floor(u), leg.ways.length - 2);
  return leg.ways[i] + (leg.ways[i + 1] - leg.ways[i]) * (u - i);
}
function legAt(legs, time) {
  let low = 0, high = legs.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (legs[middle].begin > time) high = middle; else low = middle + 1;
  }
  return Math.max(low - 1, 0);
}
function placeOn(leg, way) {
  if (leg.edges.length === 0) return leg.at;
  let left = way;
  for (const edge of leg.edges) {
    const length = edgeLength(edge);
    if (left <= length) return pointOn(edge, left);
    left -= length;
  }
  return leg.edges[leg.edges.length - 1].slice(2, 4);
}
function stateAt(data, time) {
  const index = legAt(data.legs, time), leg = data.legs[index];
  const way = wayAt(leg, time), step = 0.001;
  const from = Math.max(time - step, leg.begin);
  const to = Math.min(time + step, leg.begin + leg.duration);
  const speed = to > from ? (wayAt(leg, to) - wayAt(leg, from)) / (to - from) : 0;
  return {leg: index, kind: leg.kind, way, place: placeOn(leg, way), speed};
}
class Player {
  constructor(duration) {
    this.duration = duration;
    this.time = 0;
    this.feed = 1;
    this.running = false;
    this.before = null;
  }
  play() {
    if (this.time >= this.duration) this.time = 0;
    this.running = true;
    this.before = null;
  }
  pause() { this.running = false; }
  stop() { this.running = false; this.time = 0; }
  seek(time) { this.time = Math.min(Math.max(time, 0), this.duration); }
  /// now: s of any clock.
  step(now) {
    if (!this.running) return this.time;
    if (this.before !== null) this.seek(this.time + (now - this.before) * this.feed);
    this.before = now;
    if (this.time >= this.duration) this.running = false;
    return this.time;
  }
}
)";

constexpr std::string_view kViewScript = R"(
"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const player = new Player(data.duration);
const get = id => document.getElementById(id);
const canvas = get("canvas"), screen = canvas.getContext("2d");
const made = document.createElement("canvas"), ink = made.getContext("2d");
const ground = "#10141a", copper = "#b07a3c", coming = "#6fa8dc", cut = "#2b3440";
const names = {idle: "between", down: "down", work: "at work", drill: "drilling"};
let scale = 1, madeLeg = 0, madeWay = 0;
function toPixels(c) {
  const [x0, y0, x1, y1] = data.extent;
  scale = Math.min(canvas.width / (x1 - x0), canvas.height / (y1 - y0));
  c.setTransform(scale, 0, 0, -scale, (canvas.width - scale * (x1 + x0)) / 2,
                 (canvas.height + scale * (y1 + y0)) / 2);
}
function trace(c, e, from, to) {
  if (e.length === 4) { c.lineTo(...pointOn(e, to)); return; }
  const per = e[8] / edgeLength(e);
  c.arc(e[4], e[5], e[6], e[7] + from * per, e[7] + to * per, e[8] < 0);
}
function drawEdges(c, edges, from, to) {
  let before = 0, begun = false;
  c.beginPath();
  for (const e of edges) {
    const length = edgeLength(e), a = Math.max(from - before, 0);
    const b = Math.min(to - before, length);
    if (b > a) {
      if (!begun) c.moveTo(...pointOn(e, a));
      begun = true;
      trace(c, e, a, b);
    }
    before += length;
  }
  c.stroke();
}
function begin() {
  made.width = canvas.width;
  made.height = canvas.height;
  ink.fillStyle = ground;
  ink.fillRect(0, 0, made.width, made.height);
  toPixels(ink);
  ink.lineCap = ink.lineJoin = "round";
  ink.fillStyle = copper;
  ink.beginPath();
  for (const loop of data.copper) {
    ink.moveTo(loop[0][0], loop[0][1]);
    for (const e of loop) trace(ink, e, 0, edgeLength(e));
    ink.closePath();
  }
  ink.fill("evenodd");
  // What is to come; the tool covers it.
  ink.lineWidth = 1.5 / scale;
  ink.strokeStyle = coming;
  for (const leg of data.legs) {
    if (leg.kind === "work") drawEdges(ink, leg.edges, 0, Infinity);
    if (leg.kind !== "drill") continue;
    ink.beginPath();
    ink.arc(leg.at[0], leg.at[1], leg.diameter / 2, 0, 2 * Math.PI);
    ink.stroke();
  }
  madeLeg = madeWay = 0;
}
function sweep(leg, to) {
  if (leg.kind === "drill" && madeWay === 0) {
    ink.fillStyle = "#000000";
    ink.beginPath();
    ink.arc(leg.at[0], leg.at[1], leg.diameter / 2, 0, 2 * Math.PI);
    ink.fill();
  }
  if (leg.kind !== "work" || to <= madeWay) return;
  ink.strokeStyle = cut;
  ink.lineWidth = data.tool;
  drawEdges(ink, leg.edges, madeWay, to);
}
function draw() {
  const now = stateAt(data, player.time);
  if (now.leg < madeLeg || (now.leg === madeLeg && now.way < madeWay)) begin();
  for (; madeLeg < now.leg; ++madeLeg, madeWay = 0)
    sweep(data.legs[madeLeg], Infinity);
  sweep(data.legs[now.leg], now.way);
  madeWay = Math.max(now.way, madeWay);
  screen.setTransform(1, 0, 0, 1, 0, 0);
  screen.drawImage(made, 0, 0);
  toPixels(screen);
  screen.lineWidth = 1 / scale;
  screen.strokeStyle = coming;
  const here = data.legs[now.leg];
  if (here.kind === "idle") {
    screen.setLineDash([6 / scale, 4 / scale]);
    drawEdges(screen, here.edges, now.way, Infinity);
    screen.setLineDash([]);
  }
  screen.fillStyle = "#ffb454";
  screen.beginPath();
  screen.arc(now.place[0], now.place[1], Math.max(data.tool / 2, 4 / scale), 0,
             2 * Math.PI);
  screen.fill();
  get("progress").value = player.time;
  get("toggle").textContent = player.running ? "Pause" : "Play";
  get("text").replaceChildren(...[
    player.time.toFixed(2) + " of " + data.duration.toFixed(2) + " s",
    names[now.kind] + ", " + now.speed.toFixed(1) + " mm/s",
    "x " + now.place[0].toFixed(3) + ", y " + now.place[1].toFixed(3) + " mm",
  ].map(text => Object.assign(document.createElement("span"), {textContent: text})));
}
function resize() {
  canvas.width = canvas.clientWidth * devicePixelRatio;
  canvas.height = canvas.clientHeight * devicePixelRatio;
  begin();
  draw();
}
function tick(ms) {
  if (!player.running) return;
  player.step(ms / 1000);
  draw();
  requestAnimationFrame(tick);
}
function toggle() {
  if (player.running) player.pause(); else player.play();
  draw();
  requestAnimationFrame(tick);
}
get("progress").max = data.duration;
get("toggle").onclick = toggle;
get("stop").onclick = () => { player.stop(); draw(); };
get("progress").oninput = event => { player.seek(Number(event.target.value)); draw(); };
get("feed").oninput = event => {
  player.feed = Math.pow(10, Number(event.target.value));
  get("times").textContent = "x " + player.feed.toPrecision(2);
};
addEventListener("keydown", event => {
  if (event.key === " " && event.target.tagName !== "BUTTON") {
    event.preventDefault();
    toggle();
  }
});
addEventListener("resize", resize);
resize();
)";

constexpr std::string_view kControls = R"(<canvas id="canvas"></canvas>
<div class="row"><button id="toggle">Play</button><button id="stop">Stop</button>
<input id="progress" type="range" min="0" step="any" value="0" aria-label="time">
<label>feed <input id="feed" type="range" min="-2" max="3" step="0.01" value="0">
<span id="times">x 1.0</span></label></div>
<div class="row" id="text"></div>
<div class="row legend"><span><i style="background:#b07a3c"></i>material left</span>
<span><i style="background:#6fa8dc;height:2px"></i>to come</span>
<span><i style="background:#2b3440"></i>made</span>
<span><i style="background:#ffb454;border-radius:50%"></i>tool</span>
<span>space: play, pause</span></div>
)";

class PageData {
 public:
  std::string EdgesText(const contour::Edges& edges) {
    std::string text = "[";
    for (const contour::Edge& edge : edges) {
      if (text.size() > 1) text += ",";
      const Vec2 &a = edge.begin_mm, &b = edge.end_mm, &c = edge.center_mm;
      Include(edge);
      text += fmt::format("[{:.6f},{:.6f},{:.6f},{:.6f}", a.x(), a.y(), b.x(), b.y());
      if (edge.is_arc()) {
        text += fmt::format(",{:.6f},{:.6f},{:.6f},{:.9f},{:.9f}", c.x(), c.y(),
                            edge.radius_mm, edge.begin_rad, edge.sweep_rad);
      }
      text += "]";
    }
    return text + "]";
  }

  std::string LegText(const MotionLeg& leg, const ContourWork& work) {
    std::string text = fmt::format(
        R"({{"kind":"{}","begin":{:.9f},"duration":{:.9f},"length":{:.6f},"at":[{:.6f},{:.6f}],"edges":{})",
        NameOf(leg.kind), leg.begin_s, leg.duration_s, leg.length_mm, leg.begin_mm.x(),
        leg.begin_mm.y(), EdgesText(leg.edges));
    if (leg.kind == LegKind::kDrill)
      text += fmt::format(R"(,"diameter":{:.6f})", work.rounds[leg.number].diameter_mm);
    if (leg.law && leg.duration_s > 0) text += ",\"ways\":" + WaysText(leg);
    Include(leg.begin_mm);
    return text + "}";
  }

  /// xmin, ymin, xmax, ymax.
  std::string ExtentText(double margin_mm) const {
    return fmt::format("[{:.6f},{:.6f},{:.6f},{:.6f}]", low_mm_.x() - margin_mm,
                       low_mm_.y() - margin_mm, high_mm_.x() + margin_mm,
                       high_mm_.y() + margin_mm);
  }

 private:
  static std::string WaysText(const MotionLeg& leg) {
    const auto count = static_cast<std::size_t>(
        std::clamp(std::ceil(leg.duration_s / kSampleStepS), 2.0, kMaxSamples));
    const double step_s = leg.duration_s / static_cast<double>(count - 1);
    std::string text;
    for (const double way_mm : course::SampleLaw(*leg.law, step_s, 0, count)) {
      text += fmt::format("{}{:.6f}", text.empty() ? "[" : ",",
                          std::clamp(way_mm, 0.0, leg.length_mm));
    }
    return text + "]";
  }

  void Include(const Vec2& place_mm) {
    low_mm_ = low_mm_.cwiseMin(place_mm);
    high_mm_ = high_mm_.cwiseMax(place_mm);
  }
  void Include(const contour::Edge& edge) {
    const int count = edge.is_arc() ? 64 : 1;
    for (int k = 0; k <= count; ++k)
      Include(contour::PointAt(edge, edge.length_mm * k / count));
  }

  Vec2 low_mm_{1e9, 1e9}, high_mm_{-1e9, -1e9};
};

std::string DataOf(const ContourWork& work, const ContourMotion& motion, double tool_mm) {
  PageData data;
  std::string copper, legs;
  for (const contour::Edges& edges : work.copper)
    copper += (copper.empty() ? "" : ",\n") + data.EdgesText(edges);
  for (const MotionLeg& leg : motion.legs)
    legs += (legs.empty() ? "" : ",\n") + data.LegText(leg, work);
  return fmt::format(
      "{{\"tool\":{:.6f},\"duration\":{:.9f},\"extent\":{},\n\"copper\":[{}],\n"
      "\"legs\":[{}]}}",
      tool_mm, motion.duration_s, data.ExtentText(1 + tool_mm), copper, legs);
}

}  // namespace

std::string PageOf(const ContourWork& work, const ContourMotion& motion,
                   double tool_diameter_mm, const std::string& title) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
      "style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n"
      "<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n{}"
      "<script id=\"data\" type=\"application/json\">{}</script>\n"
      "<script id=\"model\">{}</script>\n<script id=\"view\">{}</script>\n"
      "</body>\n</html>\n",
      client::HtmlOf(title), kPageStyle, kControls,
      DataOf(work, motion, tool_diameter_mm), kModelScript, kViewScript);
}

}  // namespace intaglio::cli
