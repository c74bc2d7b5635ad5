#include "engrave/mark/mark_file.h"

#include <bit>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/crc32.h"
#include "engrave/io/whole_file.h"

namespace intaglio::mark {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr char kMagic[] = "INTMRKS1";
constexpr std::size_t kMagicSize = 8, kHeadSize = 12;
// A pen takes these without its name, a mark with one place.
constexpr std::size_t kMinPenBytes = 48, kMinMarkBytes = 44, kPlaceBytes = 24;
constexpr std::uint32_t kOpenKind = 0, kClosedKind = 1, kRowKind = 2;

template <typename T>
void Put(std::vector<std::byte>& bytes, T value) {
  static_assert(std::is_arithmetic_v<T>);
  bytes.resize(bytes.size() + sizeof value);
  std::memcpy(bytes.data() + bytes.size() - sizeof value, &value, sizeof value);
}

void PutPen(std::vector<std::byte>& bytes, const Pen& pen) {
  Put(bytes, static_cast<std::uint32_t>(pen.name.size()));
  for (const char letter : pen.name) bytes.push_back(static_cast<std::byte>(letter));
  for (const double value : {pen.speed_mm_s, pen.power_ratio, pen.frequency_hz})
    Put(bytes, value);
  Put(bytes, pen.pass_count);
  Put(bytes, pen.depth_mm);
  Put(bytes, pen.plunge_mm_s);
}

void PutMark(std::vector<std::byte>& bytes, const Mark& mark) {
  Put(bytes, mark.pen);
  const bool row = IsRow(mark);
  Put(bytes, row ? kRowKind : mark.closed ? kClosedKind : kOpenKind);
  Put(bytes, mark.web_mm);
  Put(bytes, static_cast<std::uint32_t>(mark.places.size()));
  for (const Place& place : mark.places) {
    Put(bytes, place.at_mm.x());
    Put(bytes, place.at_mm.y());
    Put(bytes, place.bulge);
    if (row) Put(bytes, static_cast<std::uint32_t>(place.dark ? 1 : 0));
  }
}

class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <typename T>
  T Take() {
    T value{};
    if (!Has(sizeof value)) return value;
    std::memcpy(&value, bytes_.data(), sizeof value);
    bytes_ = bytes_.subspan(sizeof value);
    return value;
  }
  std::string TakeText(std::size_t size) {
    if (!Has(size)) return {};
    std::string text(reinterpret_cast<const char*>(bytes_.data()), size);
    bytes_ = bytes_.subspan(size);
    return text;
  }
  /// At most `max`; with anything else it has failed, and this is 0.
  std::uint32_t TakeUpTo(std::uint32_t max) {
    const auto value = Take<std::uint32_t>();
    return value <= max || Fails() ? value : 0;
  }
  /// There can be `count` things of `size` bytes; else it has failed.
  bool HasRoom(std::uint64_t count, std::size_t size) {
    return Has(0) && (count <= bytes_.size() / size || Fails());
  }
  void Refuse() { good_ = false; }
  bool good() const { return good_; }
  bool at_end() const { return good_ && bytes_.empty(); }

 private:
  bool Fails() {
    good_ = false;
    return false;
  }
  bool Has(std::size_t size) { return good_ && (size <= bytes_.size() || Fails()); }

  std::span<const std::byte> bytes_;
  bool good_ = true;
};

Pen TakePen(Reader& reader) {
  Pen pen;
  pen.name = reader.TakeText(reader.Take<std::uint32_t>());
  pen.speed_mm_s = reader.Take<double>();
  pen.power_ratio = reader.Take<double>();
  pen.frequency_hz = reader.Take<double>();
  pen.pass_count = reader.Take<std::uint32_t>();
  pen.depth_mm = reader.Take<double>();
  pen.plunge_mm_s = reader.Take<double>();
  return pen;
}

Mark TakeMark(Reader& reader) {
  Mark mark;
  mark.pen = reader.Take<std::uint32_t>();
  const std::uint32_t kind = reader.TakeUpTo(kRowKind);
  mark.closed = kind == kClosedKind;
  mark.web_mm = reader.Take<double>();
  const auto count = reader.Take<std::uint32_t>();
  if (!reader.HasRoom(count, kPlaceBytes)) return mark;
  mark.places.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto x = reader.Take<double>(), y = reader.Take<double>();
    mark.places.push_back({Vec2(x, y), reader.Take<double>()});
    if (kind == kRowKind) mark.places.back().dark = reader.TakeUpTo(1) == 1;
  }
  if (kind == kRowKind && !IsRow(mark)) reader.Refuse();
  return mark;
}

tl::unexpected<Error> Unreadable(const std::string& what) {
  return Fail(ErrorCode::kUnreadable, what + ": it cannot be used; make the job again");
}

}  // namespace

std::vector<std::byte> EncodeMarks(const MarkSet& set) {
  std::vector<std::byte> bytes(kHeadSize);
  Put(bytes, static_cast<std::uint32_t>(set.pens.size()));
  Put(bytes, static_cast<std::uint64_t>(set.marks.size()));
  for (const Pen& pen : set.pens) PutPen(bytes, pen);
  for (const Mark& mark : set.marks) PutMark(bytes, mark);
  const std::uint32_t crc = io::Crc32(std::span(bytes).subspan(kHeadSize));
  std::memcpy(bytes.data(), kMagic, kMagicSize);
  std::memcpy(bytes.data() + kMagicSize, &crc, sizeof crc);
  return bytes;
}

Result<MarkSet> DecodeMarks(std::span<const std::byte> bytes) {
  if (bytes.size() < kHeadSize || std::memcmp(bytes.data(), kMagic, kMagicSize) != 0)
    return Unreadable("not a file of marks");
  std::uint32_t crc = 0;
  std::memcpy(&crc, bytes.data() + kMagicSize, sizeof crc);
  if (crc != io::Crc32(bytes.subspan(kHeadSize)))
    return Unreadable("cut or damaged, by its checksum");
  Reader reader(bytes.subspan(kHeadSize));
  MarkSet set;
  const auto pens = reader.Take<std::uint32_t>();
  const auto marks = reader.Take<std::uint64_t>();
  if (reader.HasRoom(pens, kMinPenBytes)) {
    for (std::uint32_t i = 0; i < pens && reader.good(); ++i)
      set.pens.push_back(TakePen(reader));
  }
  if (reader.HasRoom(marks, kMinMarkBytes)) {
    for (std::uint64_t i = 0; i < marks && reader.good(); ++i)
      set.marks.push_back(TakeMark(reader));
  }
  if (!reader.at_end()) return Unreadable("has a length or a flag that is not possible");
  if (const Status good = CheckMarks(set); !good) return Unreadable(good.error().message);
  return set;
}

std::uint32_t MarksCrc(const MarkSet& set) {
  const auto bytes = EncodeMarks(set);
  return io::Crc32(std::span(bytes).subspan(kHeadSize));
}

Status WriteMarkFile(const std::filesystem::path& file, const MarkSet& set) {
  const auto bytes = EncodeMarks(set);
  return io::WriteFileAtomically(
      file, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

Result<MarkSet> ReadMarkFile(const std::filesystem::path& file) {
  const auto bytes = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxMarkFileBytes));
  auto set = DecodeMarks(std::as_bytes(std::span(bytes)));
  if (!set) return tl::unexpected(io::AboutFile(set.error(), file));
  return set;
}

}  // namespace intaglio::mark
