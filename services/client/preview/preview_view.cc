// The script projects in parallel: turned about z by the azimuth a, then raised by the
// elevation e, a point (x, y, z) from the block's middle is seen at
//   u = x cos a + y sin a,   v = z cos e + (y cos a - x sin a) sin e,
// u to the right and v up, from the front (-y) for a = e = 0.

#include "services/client/preview/preview_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "services/platform/text_format/base64.h"

namespace intaglio::client {
namespace {

constexpr double kSteps = 65535;

constexpr const char* kScript = R"(
(() => {
  const canvas = document.getElementById('turning');
  const pen = canvas.getContext('2d');
  const size = canvas.dataset.block.split(' ').map(Number);
  const bytes = Uint8Array.from(atob(canvas.dataset.points), c => c.charCodeAt(0));
  const raw = new DataView(bytes.buffer), count = bytes.length / 6;
  const place = new Float32Array(3 * count);
  for (let i = 0; i < 3 * count; ++i)
    place[i] = (raw.getUint16(2 * i, true) / 65535 - 0.5) * size[i % 3];
  const reach = Math.hypot(...size);
  let azimuth = 0.5, elevation = 0.3, zoom = 1, held = null, waits = false;
  const draw = () => {
    waits = false;
    const w = canvas.width, h = canvas.height;
    const ca = Math.cos(azimuth), sa = Math.sin(azimuth);
    const ce = Math.cos(elevation), se = Math.sin(elevation);
    const scale = zoom * Math.min(w, h) / reach;
    const see = (x, y, z) => [w / 2 + scale * (x * ca + y * sa),
                              h / 2 - scale * (z * ce + (y * ca - x * sa) * se)];
    const picture = pen.createImageData(w, h), pixels = picture.data;
    for (let i = 0; i < pixels.length; i += 4) {
      pixels[i] = 11; pixels[i + 1] = 14; pixels[i + 2] = 18; pixels[i + 3] = 255;
    }
    for (let i = 0; i < 3 * count; i += 3) {
      const [u, v] = see(place[i], place[i + 1], place[i + 2]);
      if (u < 0 || v < 0 || u >= w || v >= h) continue;
      const at = 4 * (Math.floor(v) * w + Math.floor(u));
      for (let k = 0; k < 3; ++k) pixels[at + k] = Math.min(255, pixels[at + k] + 90);
    }
    pen.putImageData(picture, 0, 0);
    pen.strokeStyle = '#5c7a99';
    pen.beginPath();
    for (let corner = 0; corner < 8; ++corner) {
      for (let axis = 0; axis < 3; ++axis) {
        if (corner >> axis & 1) continue;
        const at = c => see(...size.map((s, k) => (c >> k & 1 ? s : -s) / 2));
        pen.moveTo(...at(corner));
        pen.lineTo(...at(corner | 1 << axis));
      }
    }
    pen.stroke();
  };
  const redraw = () => { if (!waits) { waits = true; requestAnimationFrame(draw); } };
  const turn = (right, up) => {
    azimuth += right;
    elevation = Math.max(-1.57, Math.min(1.57, elevation + up));
    redraw();
  };
  const enlarge = factor => { zoom = Math.max(0.5, Math.min(20, zoom * factor)); redraw(); };
  canvas.onpointerdown = e => { held = [e.x, e.y]; canvas.setPointerCapture(e.pointerId); };
  canvas.onpointerup = () => { held = null; };
  canvas.onpointermove = e => {
    if (!held) return;
    turn((e.x - held[0]) / 150, (e.y - held[1]) / 150);
    held = [e.x, e.y];
  };
  canvas.addEventListener('wheel', e => {
    e.preventDefault();
    enlarge(Math.exp(-e.deltaY / 500));
  }, { passive: false });
  canvas.onkeydown = e => {
    const keys = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1],
                   ArrowDown: [0, -0.1] };
    if (keys[e.key]) { e.preventDefault(); turn(...keys[e.key]); }
    if (e.key === '+') enlarge(1.2);
    if (e.key === '-') enlarge(1 / 1.2);
  };
  draw();
})();
)";

std::vector<std::uint8_t> BytesOf(const PointList& points_mm, const Vec3& block_size_mm) {
  const std::size_t step = (points_mm.size() + kShownPoints - 1) / kShownPoints;
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < points_mm.size(); i += step) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double share = std::clamp(points_mm[i][axis] / block_size_mm[axis], 0.0, 1.0);
      const auto steps = static_cast<std::uint16_t>(std::lround(kSteps * share));
      bytes.push_back(static_cast<std::uint8_t>(steps & 0xff));
      bytes.push_back(static_cast<std::uint8_t>(steps >> 8));
    }
  }
  return bytes;
}

}  // namespace

std::string TurningView(const PointList& points_mm, const Vec3& block_size_mm) {
  if (points_mm.empty()) return {};
  const std::vector<std::uint8_t> bytes = BytesOf(points_mm, block_size_mm);
  return fmt::format(
      "<canvas id=\"turning\" width=\"1000\" height=\"700\" tabindex=\"0\" role=\"img\" "
      "aria-label=\"planned points in the block; arrow keys turn it, + and - enlarge "
      "it\" "
      "data-block=\"{} {} {}\" data-points=\"{}\"></canvas>\n<script>{}</script>\n",
      block_size_mm.x(), block_size_mm.y(), block_size_mm.z(),
      Base64Of(std::as_bytes(std::span(bytes))), kScript);
}

}  // namespace intaglio::client
