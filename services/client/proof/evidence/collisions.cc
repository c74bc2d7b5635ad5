#include "services/client/proof/evidence/collisions.h"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <span>

#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/whole_file.h"
#include "services/job/files/json_text.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

// At most two bodies and 65 solids, of some hundred bytes.
constexpr std::uint64_t kMaxCollisionBytes = 1 << 20;

std::string BodyName(std::uint8_t body) { return body == 0 ? "lens" : "head"; }

std::string SolidName(std::uint8_t solid) {
  return solid == 0 ? "block" : fmt::format("fixture {}", solid);
}

void Deepen(const formats::GlassCollision& collision, CollisionReport& report) {
  if (collision.overlap_mm <= report.overlap_mm()) return;
  report.set_overlap_mm(collision.overlap_mm);
  report.mutable_focus_mm()->set_x(collision.focus_mm.x());
  report.mutable_focus_mm()->set_y(collision.focus_mm.y());
  report.mutable_focus_mm()->set_z(collision.focus_mm.z());
}

}  // namespace

CollisionRecord CollisionsOf(const std::vector<formats::GlassCollision>& collisions) {
  CollisionRecord record;
  auto& reports = *record.mutable_collisions();
  for (const formats::GlassCollision& collision : collisions) {
    const std::string body = BodyName(collision.body), solid = SolidName(collision.solid);
    auto known = std::ranges::find_if(reports, [&](const CollisionReport& report) {
      return report.body() == body && report.solid() == solid;
    });
    if (known == reports.end()) {
      CollisionReport& report = *reports.Add();
      report.set_tick(collision.tick);
      report.set_body(body);
      report.set_solid(solid);
      known = reports.end() - 1;
    }
    Deepen(collision, *known);
  }
  return record;
}

Status WriteCollisions(const std::vector<formats::GlassCollision>& collisions,
                       const fs::path& folder) {
  const fs::path file = folder / kCollisionsFile;
  if (collisions.empty()) {
    std::error_code ignored;  // it was not there
    fs::remove(file, ignored);
    return {};
  }
  const auto json = INTAGLIO_TRY(JsonTextOf(CollisionsOf(collisions)));
  return io::WriteFileAtomically(file, std::string_view(json));
}

Result<CollisionRecord> ReadCollisions(const fs::path& folder) {
  const fs::path file = folder / kCollisionsFile;
  CollisionRecord record;
  std::error_code error;
  if (!fs::exists(file, error)) return record;
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxCollisionBytes));
  const auto parsed = google::protobuf::util::JsonStringToMessage(text, &record);
  if (parsed.ok()) return record;
  return Fail(ErrorCode::kUnreadable,
              fmt::format("{} does not contain collisions: {}; make the proof again",
                          file.string(), parsed.ToString()),
              file.string());
}

std::string CollisionText(const CollisionReport& collision) {
  const Vector3& at = collision.focus_mm();
  return fmt::format(
      "the {} was {:.1f} mm inside the {} (its focus in air at {:.1f}, {:.1f}, {:.1f} mm "
      "from the block's corner, begun at tick {}): check lens, head and block",
      collision.body(), collision.overlap_mm(), collision.solid(), at.x(), at.y(), at.z(),
      collision.tick());
}

}  // namespace intaglio::client
