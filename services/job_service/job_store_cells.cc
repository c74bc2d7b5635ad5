// What JobStore keeps of the machines: whose block is in each, which blocks loaders put
// in, and what people reported as mounted.

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <sstream>

#include "services/job_service/job_store.h"
#include "services/job_service/store_guard.h"

namespace intaglio::job_service {
namespace {

// More blocks than a loader has in a year; older identities may come again.
constexpr int kRememberedBlocks = 100'000;

PieceRecord PieceOf(SQLite::Statement& row) {
  PieceRecord piece;
  piece.cell = row.getColumn(0).getString();
  piece.job_uid = row.getColumn(1).getString();
  piece.job_number = row.getColumn(2).getUInt();
  piece.opened = row.getColumn(3).getInt() != 0;
  std::istringstream stations(row.getColumn(4).getString());
  for (std::uint32_t station = 0; stations >> station;) piece.stations.push_back(station);
  piece.block = row.getColumn(5).getString();
  return piece;
}

MountRecord MountOf(SQLite::Statement& row) {
  MountRecord mount;
  mount.number = static_cast<std::uint64_t>(row.getColumn(0).getInt64());
  mount.cell = row.getColumn(1).getString();
  const auto number = [&row](int column) { return row.getColumn(column).getDouble(); };
  MountedParts& parts = mount.parts;
  if (number(2) > 0) parts.block_mm = Vec3(number(2), number(3), number(4));
  parts.glass = row.getColumn(5).getString();
  if (number(6) > 0) parts.refractive_index = number(6);
  parts.lens_name = row.getColumn(7).getString();
  if (number(8) > 0) parts.lens = optics::Lens{number(8), number(9)};
  parts.piece = row.getColumn(10).getString();
  mount.operator_name = row.getColumn(11).getString();
  mount.mounted_utc = row.getColumn(12).getString();
  return mount;
}

}  // namespace

void JobStore::KeepPiece(const PieceRecord& piece) {
  Guarded(*database_, [&] {
    SQLite::Statement insert(*database_,
                             "INSERT OR REPLACE INTO pieces (cell, job_uid, job_number, "
                             "opened, stations, block) VALUES (?, ?, ?, ?, ?, ?)");
    insert.bind(1, piece.cell);
    insert.bind(2, piece.job_uid);
    insert.bind(3, piece.job_number);
    insert.bind(4, piece.opened ? 1 : 0);
    insert.bind(5, fmt::format("{}", fmt::join(piece.stations, " ")));
    insert.bind(6, piece.block);
    insert.exec();
  });
}

std::vector<PieceRecord> JobStore::LoadPieces() {
  return Guarded(*database_, [&] {
    SQLite::Statement select(
        *database_,
        "SELECT cell, job_uid, job_number, opened, stations, block FROM pieces");
    std::vector<PieceRecord> pieces;
    while (select.executeStep()) pieces.push_back(PieceOf(select));
    return pieces;
  });
}

void JobStore::KeepLoadedBlock(const LoadedBlock& block) {
  Guarded(*database_, [&] {
    SQLite::Statement insert(
        *database_, fmt::format("INSERT OR IGNORE INTO loaded_blocks (cell, block_id, "
                                "job_uid, loaded_utc) VALUES (?, ?, ?, {})",
                                kNow));
    insert.bind(1, block.cell);
    insert.bind(2, block.block_id);
    insert.bind(3, block.job_uid);
    insert.exec();
  });
}

std::vector<LoadedBlock> JobStore::LoadLoadedBlocks() {
  return Guarded(*database_, [&] {
    SQLite::Statement select(*database_,
                             "SELECT cell, block_id, job_uid FROM loaded_blocks "
                             "ORDER BY rowid DESC LIMIT ?");
    select.bind(1, kRememberedBlocks);
    std::vector<LoadedBlock> blocks;
    while (select.executeStep()) {
      blocks.push_back({select.getColumn(0).getString(), select.getColumn(1).getString(),
                        select.getColumn(2).getString()});
    }
    return blocks;
  });
}

void JobStore::KeepMount(const MountRecord& mount) {
  Guarded(*database_, [&] {
    SQLite::Statement insert(
        *database_,
        "INSERT INTO mounts (number, cell, block_x_mm, block_y_mm, block_z_mm, glass, "
        "refractive_index, lens, focal_length_mm, numerical_aperture, piece, "
        "operator_name, mounted_utc) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    const MountedParts& parts = mount.parts;
    const Vec3 block_mm = parts.block_mm.value_or(Vec3::Zero());
    insert.bind(1, Signed(mount.number));
    insert.bind(2, mount.cell);
    for (int i = 0; i < 3; ++i) insert.bind(3 + i, block_mm[i]);
    insert.bind(6, parts.glass);
    insert.bind(7, parts.refractive_index.value_or(0));
    insert.bind(8, parts.lens_name);
    insert.bind(9, parts.lens ? parts.lens->focal_length_mm : 0);
    insert.bind(10, parts.lens ? parts.lens->numerical_aperture : 0);
    insert.bind(11, parts.piece);
    insert.bind(12, mount.operator_name);
    insert.bind(13, mount.mounted_utc);
    insert.exec();
  });
}

std::vector<MountRecord> JobStore::LoadMounts() {
  return Guarded(*database_, [&] {
    SQLite::Statement select(
        *database_,
        "SELECT number, cell, block_x_mm, block_y_mm, block_z_mm, glass, "
        "refractive_index, lens, focal_length_mm, numerical_aperture, piece, "
        "operator_name, mounted_utc FROM mounts WHERE number IN "
        "(SELECT max(number) FROM mounts GROUP BY cell) ORDER BY number");
    std::vector<MountRecord> mounts;
    while (select.executeStep()) mounts.push_back(MountOf(select));
    return mounts;
  });
}

}  // namespace intaglio::job_service
