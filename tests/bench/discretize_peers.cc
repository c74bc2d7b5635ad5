#include "tests/bench/discretize_peers.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "tests/bench/cura_settings.h"
#ifdef INTAGLIO_HAS_EMBREE
#include <embree3/rtcore.h>
#endif

namespace intaglio::bench {
namespace {

namespace fs = std::filesystem;
constexpr int kRuns = 5;

fs::path Folder() {
  const fs::path folder = fs::temp_directory_path() / "intaglio_discretize_bench";
  fs::create_directories(folder);
  return folder;
}

bool IsInstalled(const char* program) {
  return std::system(fmt::format("command -v {} > /dev/null", program).c_str()) == 0;
}

template <typename T>
void Put(std::ofstream& out, const T& value) {
  out.write(reinterpret_cast<const char*>(&value), sizeof value);
}

void WriteStl(const mesh::TriangleMesh& mesh, const fs::path& file) {
  std::ofstream out(file, std::ios::binary);
  out << std::string(80, ' ');
  Put(out, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const mesh::Triangle& t : mesh.triangles) {
    Put(out, std::array<float, 3>{});
    for (const std::uint32_t corner : t) {
      for (int axis = 0; axis < 3; ++axis) {
        Put(out, static_cast<float>(mesh.vertices[corner][axis]));
      }
    }
    Put(out, std::uint16_t{0});
  }
}

void WritePly(const PointList& points, const fs::path& file) {
  std::ofstream out(file, std::ios::binary);
  out << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const Vec3& p : points) {
    for (int axis = 0; axis < 3; ++axis) Put(out, static_cast<float>(p[axis]));
  }
}

/// The number behind a text of a log, or 0.
double NumberBehind(const std::string& log, const std::string& text) {
  std::smatch match;
  if (!std::regex_search(log, match, std::regex(text + " ([0-9.]+)"))) return 0;
  return std::stod(match[1]);
}

}  // namespace

double BestMs(int runs, const std::function<void()>& work) {
  double best_ms = 1e300;
  for (int i = 0; i < runs; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    const std::chrono::duration<double, std::milli> time =
        std::chrono::steady_clock::now() - begin;
    best_ms = std::min(best_ms, time.count());
  }
  return best_ms;
}

std::optional<PeerRun> CuraSlices(const mesh::TriangleMesh& mesh, double layer_mm) {
  if (!IsInstalled("CuraEngine")) return std::nullopt;
  const fs::path model = Folder() / "model.stl", log = Folder() / "cura.log";
  WriteStl(mesh, model);
  // Its option for one thread waits for ever in 4.13: it is held on one core instead.
  std::string command = fmt::format(
      "timeout 60 taskset -c 0 CuraEngine slice -v -s layer_height={0} "
      "-s layer_height_0={0} -s machine_width=400 -s machine_depth=400 "
      "-s machine_height=400 -s machine_center_is_zero=false "
      "-s machine_extruders_share_nozzle=false",
      layer_mm);
  for (const char* setting : kCuraSettings) {
    command += fmt::format(" -s '{}'", setting);
  }
  command += fmt::format(" -l {} -o {} > {} 2>&1", model.string(),
                         (Folder() / "cura.gcode").string(), log.string());
  std::optional<PeerRun> best;
  for (int i = 0; i < kRuns; ++i) {
    // It stops after its slices because settings for the later steps are missing.
    if (std::system(command.c_str()) == -1) return best;
    std::stringstream text;
    text << std::ifstream(log).rdbuf();
    const double seconds = NumberBehind(text.str(), "slice of mesh took") +
                           NumberBehind(text.str(), "make polygons took");
    if (seconds == 0) return best;
    if (!best || 1000 * seconds < best->ms) best = PeerRun{1000 * seconds, 0};
  }
  return best;
}

std::optional<PeerRun> CloudCompareThinning(const PointList& points_mm,
                                            double spacing_mm) {
  if (!IsInstalled("CloudCompare")) return std::nullopt;
  const fs::path cloud = Folder() / "candidates.ply";
  WritePly(points_mm, cloud);
  const auto run = [&](const std::string& work) {
    const std::string command = fmt::format(
        "QT_QPA_PLATFORM=offscreen timeout 120 taskset -c 0 CloudCompare -SILENT "
        "-AUTO_SAVE OFF -O {} {} > {} 2>&1",
        cloud.string(), work, (Folder() / "cloudcompare.log").string());
    return BestMs(3, [&] {
      if (std::system(command.c_str()) != 0) fmt::print(stderr, "{} failed\n", command);
    });
  };
  const double loading_ms = run("");
  const double all_ms = run(fmt::format("-SS SPATIAL {}", spacing_mm));
  return PeerRun{all_ms - loading_ms, 0};
}

#ifdef INTAGLIO_HAS_EMBREE
namespace {

/// Casts all lanes of a packet at once, until none hits anything.
std::size_t CrossingsOf(RTCScene scene, RTCRayHit16& packet, int* valid) {
  std::size_t count = 0;
  for (bool any = true; any;) {
    any = false;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect16(valid, scene, &context, &packet);
    for (int lane = 0; lane < 16; ++lane) {
      if (valid[lane] == 0) continue;
      if (packet.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) {
        valid[lane] = 0;
        continue;
      }
      ++count;
      any = true;
      packet.ray.tnear[lane] = std::nextafter(packet.ray.tfar[lane], 1e30F);
      packet.ray.tfar[lane] = 1e30F;
      packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    }
  }
  return count;
}

std::size_t CastAll(RTCScene scene, const RayBundle& rays) {
  std::size_t count = 0;
  alignas(64) RTCRayHit16 packet = {};
  alignas(64) int valid[16];
  const Vec3& d = rays.direction;
  for (int j = 0; j < rays.rows; ++j) {
    for (int i = 0; i < rays.columns; i += 16) {
      for (int lane = 0; lane < 16; ++lane) {
        const Vec3 p =
            rays.origin_mm + (i + lane) * rays.across_u_mm + j * rays.across_v_mm;
        packet.ray.org_x[lane] = static_cast<float>(p.x());
        packet.ray.org_y[lane] = static_cast<float>(p.y());
        packet.ray.org_z[lane] = static_cast<float>(p.z());
        packet.ray.dir_x[lane] = static_cast<float>(d.x());
        packet.ray.dir_y[lane] = static_cast<float>(d.y());
        packet.ray.dir_z[lane] = static_cast<float>(d.z());
        packet.ray.tnear[lane] = 0;
        packet.ray.tfar[lane] = 1e30F;
        packet.ray.mask[lane] = ~0U;
        packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
        valid[lane] = i + lane < rays.columns ? -1 : 0;
      }
      count += CrossingsOf(scene, packet, valid);
    }
  }
  return count;
}

}  // namespace

std::optional<PeerRun> EmbreeRays(const mesh::TriangleMesh& mesh, const RayBundle& rays) {
  PeerRun run;
  run.ms = BestMs(kRuns, [&] {
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* corners = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), mesh.vertices.size()));
    for (const Vec3& v : mesh.vertices) {
      for (int axis = 0; axis < 3; ++axis) *corners++ = static_cast<float>(v[axis]);
    }
    auto* triangles = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(std::uint32_t), mesh.triangles.size()));
    for (const mesh::Triangle& t : mesh.triangles) {
      triangles = std::copy(t.begin(), t.end(), triangles);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    run.count = static_cast<double>(CastAll(scene, rays));
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  });
  return run;
}
#else
std::optional<PeerRun> EmbreeRays(const mesh::TriangleMesh&, const RayBundle&) {
  return std::nullopt;
}
#endif

}  // namespace intaglio::bench
