#include "engrave/render/cloud_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "engrave/render/plane.h"

// 1. front: the minimum depth near each pixel. Points are spread so wide that neighbours
//    on one surface touch; the width follows from the points' mean distance on screen.
// 2. light: each point adds a small Gaussian, weaker the farther it lies behind `front`.
// 3. relief of the blurred front: diffuse light from the upper left on its slope, and
//    less light in hollows (depth minus its wide blur, as Luft 2006 unsharp-masks depth).
// 4. tone: 1 - exp(-k (light / typical light)^g), colour from deep blue to white, and a
//    halo of the blurred light.

namespace intaglio::render {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();

struct Spot {
  float x;  ///< Pixels from the window's corner.
  float y;
  float depth_mm;
};

/// The properties of the cloud as it appears in one window.
struct Scene {
  int width = 0;
  int height = 0;
  Rect lit;  ///< The pixels that points lie in.
  std::vector<Spot> spots;
  float near_mm = kNothing;
  float far_mm = -kNothing;
  float spacing_px = 1.0F;  ///< Mean distance of neighbouring points on screen.
  float mm_per_px = 1.0F;

  float range_mm() const { return std::max(far_mm - near_mm, 1e-3F); }
  float sigma_px(const CloudStyle& style) const {
    return std::clamp(0.40F * spacing_px, 0.55F, style.max_sigma_px);
  }
  int wide_px() const { return std::max(8, height / 60); }
  int halo_px() const { return std::max(2, height / 180); }
};

/// How many pixels around its middle a point gives light to.
int LightReach(float sigma_px) { return static_cast<int>(std::ceil(2.2F * sigma_px)); }

/// The part of the window that the steps below compute: nothing is seen outside it. A
/// blur's last two passes look twice its radius beyond the pixel that is wanted.
Rect PartOf(const Scene& scene, const CloudStyle& style) {
  const int around = LightReach(scene.sigma_px(style)) + 1 +
                     std::max(2 * scene.wide_px(), 3 * scene.halo_px());
  const Rect wanted = scene.lit.Inset(-around);
  const int left = std::max(0, wanted.x), top = std::max(0, wanted.y);
  return {left, top, std::min(scene.width, wanted.right()) - left,
          std::min(scene.height, wanted.bottom()) - top};
}

/// Mean spacing: from the covered area per point, counted in cells of 6 pixels.
float SpacingOf(const Scene& scene) {
  constexpr int kCell = 6;
  const int columns = scene.width / kCell + 1;
  std::vector<bool> taken(static_cast<std::size_t>(columns) *
                          static_cast<std::size_t>(scene.height / kCell + 1));
  std::size_t cells = 0;
  for (const Spot& spot : scene.spots) {
    const int cell =
        static_cast<int>(spot.y) / kCell * columns + static_cast<int>(spot.x) / kCell;
    auto bit = taken[static_cast<std::size_t>(cell)];
    cells += bit ? 0 : 1;
    bit = true;
  }
  const double area_px2 = static_cast<double>(cells) * kCell * kCell;
  return static_cast<float>(std::sqrt(
      area_px2 / static_cast<double>(std::max<std::size_t>(1, scene.spots.size()))));
}

Rect LitPart(const std::vector<Spot>& spots) {
  float left = kNothing, right = -kNothing, top = kNothing, bottom = -kNothing;
  for (const Spot& spot : spots) {
    left = std::min(left, spot.x);
    right = std::max(right, spot.x);
    top = std::min(top, spot.y);
    bottom = std::max(bottom, spot.y);
  }
  const int x = static_cast<int>(left), y = static_cast<int>(top);
  return {x, y, static_cast<int>(right) + 1 - x, static_cast<int>(bottom) + 1 - y};
}

Scene SceneOf(const Rect& window, const Projection& projection,
              const PointList& points_mm, const CloudStyle& style) {
  Scene scene;
  scene.width = window.width;
  scene.height = window.height;
  scene.spots.reserve(points_mm.size());
  for (const Vec3& point_mm : points_mm) {
    const Projected seen = projection(point_mm);
    if (projection.px_per_mm(seen.depth_mm) <= 0.0) continue;  // behind the viewer
    const double x = seen.at_px.x() - window.x;
    const double y = seen.at_px.y() - window.y;
    if (!(x >= 0 && y >= 0 && x < window.width && y < window.height)) continue;
    const float depth_mm = style.is_flat ? 0.0F : static_cast<float>(seen.depth_mm);
    scene.spots.push_back({static_cast<float>(x), static_cast<float>(y), depth_mm});
    scene.near_mm = std::min(scene.near_mm, depth_mm);
    scene.far_mm = std::max(scene.far_mm, depth_mm);
  }
  if (scene.spots.empty()) return scene;
  scene.lit = LitPart(scene.spots);
  scene.spacing_px = SpacingOf(scene);
  scene.mm_per_px = static_cast<float>(
      1.0 / projection.px_per_mm(0.5 * (scene.near_mm + scene.far_mm)));
  return scene;
}

Plane FrontOf(const Scene& scene, const Rect& part, float radius_px) {
  Plane front(part, kNothing);
  const int reach = static_cast<int>(std::ceil(radius_px));
  std::vector<std::array<int, 2>> disc;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const auto square = static_cast<float>(dx * dx + dy * dy);
      if (square <= radius_px * radius_px) disc.push_back({dx, dy});
    }
  }
  for (const Spot& spot : scene.spots) {
    const int x = static_cast<int>(spot.x);
    const int y = static_cast<int>(spot.y);
    for (const auto& [dx, dy] : disc) {
      if (!front.Has(x + dx, y + dy)) continue;
      float& depth_mm = front.at(x + dx, y + dy);
      depth_mm = std::min(depth_mm, spot.depth_mm);
    }
  }
  return front;
}

Plane LightOf(const Scene& scene, const Plane& front, float radius_px,
              const CloudStyle& style) {
  constexpr float kBehind = 0.10F;  // what still shines through of the farther sides
  Plane light(front.area(), 0.0F);
  const float sigma_px = scene.sigma_px(style);
  const int reach = LightReach(sigma_px);
  const float depth_scale_mm = 2.5F * (radius_px + 0.5F) * scene.mm_per_px;
  std::vector<float> across(2 * static_cast<std::size_t>(reach) + 1);
  std::vector<float> down(across.size());
  for (const Spot& spot : scene.spots) {
    const int x = static_cast<int>(spot.x);
    const int y = static_cast<int>(spot.y);
    const float behind = (spot.depth_mm - front.at(x, y)) / depth_scale_mm;
    const float nearness = 1.0F - (spot.depth_mm - scene.near_mm) / scene.range_mm();
    const float power = (kBehind + (1.0F - kBehind) * std::exp(-behind * behind)) *
                        (0.55F + 0.45F * nearness);
    for (int k = -reach; k <= reach; ++k) {
      const float dx = (static_cast<float>(x + k) + 0.5F - spot.x) / sigma_px;
      const float dy = (static_cast<float>(y + k) + 0.5F - spot.y) / sigma_px;
      across[k + reach] = std::exp(-0.5F * dx * dx);
      down[k + reach] = power * std::exp(-0.5F * dy * dy);
    }
    for (int j = -reach; j <= reach; ++j) {
      for (int i = -reach; i <= reach; ++i) {
        if (!light.Has(x + i, y + j)) continue;
        light.at(x + i, y + j) += across[i + reach] * down[j + reach];
      }
    }
  }
  return light;
}

/// The blur of the depths that are known; kNothing where none is near.
Plane SmoothDepth(const Plane& front, int radius_px) {
  Plane depth(front.area(), 0.0F);
  Plane share(front.area(), 0.0F);
  for (std::size_t i = 0; i < front.values.size(); ++i) {
    if (front.values[i] == kNothing) continue;
    depth.values[i] = front.values[i];
    share.values[i] = 1.0F;
  }
  depth = Blurred(std::move(depth), radius_px);
  share = Blurred(std::move(share), radius_px);
  for (std::size_t i = 0; i < depth.values.size(); ++i) {
    depth.values[i] =
        share.values[i] > 1e-3F ? depth.values[i] / share.values[i] : kNothing;
  }
  return depth;
}

/// Brightness of the front side by its form, about 0.2 .. 1.5.
Plane ReliefOf(const Scene& scene, const Plane& front, float radius_px) {
  const int fine_px = std::max(1, static_cast<int>(std::lround(0.6F * radius_px)));
  const Plane fine = SmoothDepth(front, fine_px);
  const Plane wide = SmoothDepth(front, scene.wide_px());
  Plane relief(front.area(), 1.0F);
  const Vec3 light = Vec3(-0.50, -0.62, 0.60).normalized();  // x right, y down, z to us
  for (int y = front.top + 1; y + 1 < front.bottom(); ++y) {
    for (int x = front.left + 1; x + 1 < front.right(); ++x) {
      const float here_mm = fine.at(x, y);
      const float dx_mm = fine.at(x + 1, y) - fine.at(x - 1, y);
      const float dy_mm = fine.at(x, y + 1) - fine.at(x, y - 1);
      if (!std::isfinite(dx_mm) || !std::isfinite(dy_mm) || here_mm == kNothing) continue;
      const Vec3 normal =
          Vec3(0.5 * dx_mm / scene.mm_per_px, 0.5 * dy_mm / scene.mm_per_px, 1.0)
              .normalized();
      const auto diffuse = static_cast<float>(std::max(0.0, normal.dot(light)));
      const float hollow = (here_mm - wide.at(x, y)) / (0.10F * scene.range_mm());
      relief.at(x, y) = (0.12F + 1.25F * diffuse * diffuse) *
                        std::clamp(1.0F - 0.55F * hollow, 0.45F, 1.35F);
    }
  }
  return relief;
}

/// The light of a pixel in the midst of the lit ones.
float TypicalLight(const Plane& light) {
  std::vector<float> lit;
  for (const float value : light.values) {
    if (value > 0.05F) lit.push_back(value);
  }
  if (lit.empty()) return 1.0F;
  const auto middle = lit.begin() + static_cast<std::ptrdiff_t>(lit.size() / 2);
  std::nth_element(lit.begin(), middle, lit.end());
  return *middle;
}

/// From faint to bright: deep blue, ice blue, white.
Color Glow(float tone) {
  static const Color kDeep = Srgb(0x1656E8);
  static const Color kIce = Srgb(0x8FD2FF);
  static const Color kWhite = Srgb(0xFFFFFF);
  const float half = std::min(2.0F * tone, 1.0F);
  return tone * Mix(Mix(kDeep, kIce, half), kWhite, std::max(0.0F, 2.0F * tone - 1.0F));
}

}  // namespace

void DrawCloud(Canvas& canvas, const Rect& window, const Projection& projection,
               const PointList& points_mm, const CloudStyle& style) {
  const Scene scene = SceneOf(window, projection, points_mm, style);
  if (scene.spots.empty()) return;
  const float radius_px = std::clamp(1.6F * scene.spacing_px + 0.6F, 1.5F, 8.0F);
  const Plane front = FrontOf(scene, PartOf(scene, style), radius_px);
  const Plane light = LightOf(scene, front, radius_px, style);
  const Plane relief = ReliefOf(scene, front, radius_px);
  const float typical = TypicalLight(light);
  Plane tone(front.area(), 0.0F);
  for (std::size_t i = 0; i < tone.values.size(); ++i) {
    if (light.values[i] <= 0.0F) continue;
    const float power = std::pow(light.values[i] / typical, 0.7F);
    tone.values[i] = 1.0F - std::exp(-1.15F * power * relief.values[i]);
  }
  const Plane halo = Blurred(tone, scene.halo_px());
  static const Color kHalo = Srgb(0x3C8CFF);
  for (int y = tone.top; y < tone.bottom(); ++y) {
    for (int x = tone.left; x < tone.right(); ++x) {
      const Color add = Glow(tone.at(x, y)) + 0.16F * halo.at(x, y) * kHalo;
      if (canvas.Has(window.x + x, window.y + y)) {
        Color& pixel = canvas.at(window.x + x, window.y + y);
        pixel = pixel + add;
      }
    }
  }
}

}  // namespace intaglio::render
