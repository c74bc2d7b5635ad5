#include "services/job/models/mesh_answer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>

namespace intaglio::mesh_reader {
namespace {

constexpr std::array<char, 8> kMagic = {'I', 'M', 'E', 'S', 'H', '2', '\0', '\0'};
constexpr auto kLastCode = static_cast<std::uint64_t>(ErrorCode::kCancelled);
constexpr auto kLastEffect = static_cast<std::uint64_t>(Effect::kMeaningLost);

struct Header {
  std::array<char, 8> magic = kMagic;
  std::uint64_t error = 0, first_size = 0, second_size = 0, finding_bytes = 0;
  double declared_unit_mm = 0;
};
static_assert(sizeof(Header) == 48 && sizeof(Vec3) == 24 && sizeof(mesh::Triangle) == 12);

/// In front of the texts of a finding.
struct FindingHeader {
  std::uint64_t what_size = 0, where_size = 0, remedy_size = 0, count = 0, effect = 0;
  double area_mm2 = 0;
};
static_assert(sizeof(FindingHeader) == 48);

void Append(const void* from, std::size_t size, std::vector<std::byte>& bytes) {
  const std::size_t end = bytes.size();
  bytes.resize(end + size);
  if (size > 0) std::memcpy(bytes.data() + end, from, size);
}

std::vector<std::byte> EncodeFindings(const FileFindings& findings) {
  std::vector<std::byte> bytes;
  for (const FileFinding& finding : findings) {
    const FindingHeader header{finding.what.size(),
                               finding.where.size(),
                               finding.remedy.size(),
                               finding.count,
                               static_cast<std::uint64_t>(finding.effect),
                               finding.area_mm2};
    Append(&header, sizeof header, bytes);
    for (const std::string* text : {&finding.what, &finding.where, &finding.remedy})
      Append(text->data(), text->size(), bytes);
  }
  return bytes;
}

std::optional<FileFindings> ParseFindings(std::span<const std::byte> all) {
  std::span<const std::byte> bytes = all;
  FileFindings findings;
  while (!bytes.empty()) {
    FindingHeader header;
    if (bytes.size() < sizeof header) return std::nullopt;
    std::memcpy(&header, bytes.data(), sizeof header);
    bytes = bytes.subspan(sizeof header);
    if (header.effect > kLastEffect || !std::isfinite(header.area_mm2))
      return std::nullopt;
    FileFinding finding;
    const auto take = [&](std::uint64_t size, std::string& text) {
      if (size > bytes.size()) return false;
      text.assign(reinterpret_cast<const char*>(bytes.data()), size);
      bytes = bytes.subspan(size);
      return true;
    };
    if (!take(header.what_size, finding.what) ||
        !take(header.where_size, finding.where) ||
        !take(header.remedy_size, finding.remedy)) {
      return std::nullopt;
    }
    finding.count = header.count;
    finding.effect = static_cast<Effect>(header.effect);
    finding.area_mm2 = header.area_mm2;
    findings.Add(std::move(finding));
  }
  // Findings of one name are one, and long names are cut: these are of another writer.
  if (!std::ranges::equal(EncodeFindings(findings), all)) return std::nullopt;
  return findings;
}

/// Two arrays of these sizes, which may be any, are all of `room` bytes.
bool Fill(std::uint64_t first_size, std::size_t first_item, std::uint64_t second_size,
          std::size_t second_item, std::size_t room) {
  return first_size <= room / first_item && second_size <= room / second_item &&
         first_size * first_item + second_size * second_item == room;
}

/// Every vertex is a place and every corner a vertex.
bool IsWhole(const mesh::TriangleMesh& made) {
  return std::ranges::all_of(made.vertices,
                             [](const Vec3& vertex) { return vertex.allFinite(); }) &&
         std::ranges::all_of(made.triangles, [&](const mesh::Triangle& triangle) {
           return std::ranges::all_of(triangle, [&](std::uint32_t corner) {
             return corner < made.vertices.size();
           });
         });
}

std::optional<Answer> MeshOf(const Header& header, std::span<const std::byte> inside) {
  if (header.finding_bytes > inside.size() || !std::isfinite(header.declared_unit_mm))
    return std::nullopt;
  auto findings = ParseFindings(inside.last(header.finding_bytes));
  inside = inside.first(inside.size() - header.finding_bytes);
  if (!findings || !Fill(header.first_size, sizeof(Vec3), header.second_size,
                         sizeof(mesh::Triangle), inside.size())) {
    return std::nullopt;
  }
  mesh::ImportedMesh made({}, std::move(*findings));
  made.declared_unit_mm = header.declared_unit_mm;
  made.vertices.resize(header.first_size);
  made.triangles.resize(header.second_size);
  const std::size_t vertex_bytes = header.first_size * sizeof(Vec3);
  if (!made.vertices.empty()) {
    std::memcpy(static_cast<void*>(made.vertices.data()), inside.data(), vertex_bytes);
  }
  if (!made.triangles.empty()) {
    std::memcpy(made.triangles.data(), inside.data() + vertex_bytes,
                inside.size() - vertex_bytes);
  }
  if (!IsWhole(made)) return std::nullopt;
  return Answer(std::move(made));
}

std::optional<Answer> ErrorOf(const Header& header, std::span<const std::byte> inside) {
  if (header.error > kLastCode + 1 || header.finding_bytes != 0 ||
      std::bit_cast<std::uint64_t>(header.declared_unit_mm) != 0 ||
      !Fill(header.first_size, 1, header.second_size, 1, inside.size())) {
    return std::nullopt;
  }
  const std::string text(reinterpret_cast<const char*>(inside.data()), inside.size());
  return Fail(static_cast<ErrorCode>(header.error - 1), text.substr(0, header.first_size),
              text.substr(header.first_size));
}

}  // namespace

std::vector<std::byte> EncodeAnswer(const Answer& answer) {
  Header header;
  std::vector<std::byte> bytes;
  if (!answer) {
    const Error& error = answer.error();
    header.error = static_cast<std::uint64_t>(error.code) + 1;
    header.first_size = error.message.size();
    header.second_size = error.value.size();
    Append(&header, sizeof header, bytes);
    Append(error.message.data(), error.message.size(), bytes);
    Append(error.value.data(), error.value.size(), bytes);
    return bytes;
  }
  const std::vector<std::byte> findings = EncodeFindings(answer->findings);
  const std::size_t vertex_bytes = answer->vertices.size() * sizeof(Vec3);
  const std::size_t triangle_bytes = answer->triangles.size() * sizeof(mesh::Triangle);
  header.first_size = answer->vertices.size();
  header.second_size = answer->triangles.size();
  header.finding_bytes = findings.size();
  header.declared_unit_mm = answer->declared_unit_mm;
  bytes.reserve(sizeof header + vertex_bytes + triangle_bytes + findings.size());
  Append(&header, sizeof header, bytes);
  Append(answer->vertices.data(), vertex_bytes, bytes);
  Append(answer->triangles.data(), triangle_bytes, bytes);
  Append(findings.data(), findings.size(), bytes);
  return bytes;
}

std::optional<Answer> ParseAnswer(std::span<const std::byte> bytes) {
  Header header;
  if (bytes.size() < sizeof header) return std::nullopt;
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != kMagic) return std::nullopt;
  const auto inside = bytes.subspan(sizeof header);
  return header.error == 0 ? MeshOf(header, inside) : ErrorOf(header, inside);
}

}  // namespace intaglio::mesh_reader
