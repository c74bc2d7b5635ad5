// What JobStore keeps of the machines: whose block is in each, which blocks loaders put
// in, and what people reported as mounted.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <sstream>

#include "services/job_service/job_store.h"
#include "services/job_service/store_guard.h"

namespace intaglio::job_service {
namespace {

// More blocks than a loader has in a year; older identities may come again.
constexpr int kRememberedBlocks = 100'000;

PieceRecord PieceOf(sql::Statement& row) {
  PieceRecord piece;
  piece.cell = row.Text(0);
  piece.job_uid = row.Text(1);
  piece.job_number = row.Integer(2);
  piece.opened = row.Integer(3) != 0;
  std::istringstream stations(row.Text(4));
  for (std::uint32_t station = 0; stations >> station;) piece.stations.push_back(station);
  piece.block = row.Text(5);
  return piece;
}

MountRecord MountOf(sql::Statement& row) {
  MountRecord mount;
  mount.number = static_cast<std::uint64_t>(row.Integer(0));
  mount.cell = row.Text(1);
  const auto number = [&row](int column) { return row.Real(column); };
  MountedParts& parts = mount.parts;
  if (number(2) > 0) parts.block_mm = Vec3(number(2), number(3), number(4));
  parts.glass = row.Text(5);
  if (number(6) > 0) parts.refractive_index = number(6);
  parts.lens_name = row.Text(7);
  if (number(8) > 0) parts.lens = optics::Lens{number(8), number(9)};
  parts.piece = row.Text(10);
  mount.operator_name = row.Text(11);
  mount.mounted_utc = row.Text(12);
  return mount;
}

}  // namespace

void JobStore::KeepPiece(const PieceRecord& piece) {
  Guarded(*database_, [&] {
    const auto insert = database_->Prepare(
        "INSERT INTO pieces (cell, job_uid, job_number, opened, stations, block) "
        "VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT (cell) DO UPDATE SET "
        "job_uid = excluded.job_uid, job_number = excluded.job_number, "
        "opened = excluded.opened, stations = excluded.stations, block = excluded.block");
    insert->Bind(1, piece.cell);
    insert->Bind(2, piece.job_uid);
    insert->Bind(3, piece.job_number);
    insert->Bind(4, piece.opened ? 1 : 0);
    insert->Bind(5, fmt::format("{}", fmt::join(piece.stations, " ")));
    insert->Bind(6, piece.block);
    insert->Execute();
  });
}

std::vector<PieceRecord> JobStore::LoadPieces() {
  return Guarded(*database_, [&] {
    const auto select = database_->Prepare(
        "SELECT cell, job_uid, job_number, opened, stations, block FROM pieces");
    std::vector<PieceRecord> pieces;
    while (select->Step()) pieces.push_back(PieceOf(*select));
    return pieces;
  });
}

void JobStore::KeepLoadedBlock(const LoadedBlock& block) {
  Guarded(*database_, [&] {
    const auto insert = database_->Prepare(
        "INSERT INTO loaded_blocks (cell, block_id, job_uid, loaded_utc) "
        "VALUES (?, ?, ?, ?) ON CONFLICT DO NOTHING");
    insert->Bind(1, block.cell);
    insert->Bind(2, block.block_id);
    insert->Bind(3, block.job_uid);
    insert->Bind(4, NowUtc());
    insert->Execute();
  });
}

std::vector<LoadedBlock> JobStore::LoadLoadedBlocks() {
  return Guarded(*database_, [&] {
    const auto select = database_->Prepare(
        "SELECT cell, block_id, job_uid FROM loaded_blocks "
        "ORDER BY loaded_utc DESC LIMIT ?");
    select->Bind(1, kRememberedBlocks);
    std::vector<LoadedBlock> blocks;
    while (select->Step()) {
      blocks.push_back({select->Text(0), select->Text(1), select->Text(2)});
    }
    return blocks;
  });
}

void JobStore::KeepMount(const MountRecord& mount) {
  Guarded(*database_, [&] {
    const auto insert = database_->Prepare(
        "INSERT INTO mounts (number, cell, block_x_mm, block_y_mm, block_z_mm, glass, "
        "refractive_index, lens, focal_length_mm, numerical_aperture, piece, "
        "operator_name, mounted_utc) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
    const MountedParts& parts = mount.parts;
    const Vec3 block_mm = parts.block_mm.value_or(Vec3::Zero());
    insert->Bind(1, Signed(mount.number));
    insert->Bind(2, mount.cell);
    for (int i = 0; i < 3; ++i) insert->Bind(3 + i, block_mm[i]);
    insert->Bind(6, parts.glass);
    insert->Bind(7, parts.refractive_index.value_or(0));
    insert->Bind(8, parts.lens_name);
    insert->Bind(9, parts.lens ? parts.lens->focal_length_mm : 0);
    insert->Bind(10, parts.lens ? parts.lens->numerical_aperture : 0);
    insert->Bind(11, parts.piece);
    insert->Bind(12, mount.operator_name);
    insert->Bind(13, mount.mounted_utc);
    insert->Execute();
  });
}

std::vector<MountRecord> JobStore::LoadMounts() {
  return Guarded(*database_, [&] {
    const auto select = database_->Prepare(
        "SELECT number, cell, block_x_mm, block_y_mm, block_z_mm, glass, "
        "refractive_index, lens, focal_length_mm, numerical_aperture, piece, "
        "operator_name, mounted_utc FROM mounts WHERE number IN "
        "(SELECT max(number) FROM mounts GROUP BY cell) ORDER BY number");
    std::vector<MountRecord> mounts;
    while (select->Step()) mounts.push_back(MountOf(*select));
    return mounts;
  });
}

}  // namespace intaglio::job_service
