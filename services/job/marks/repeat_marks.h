#pragma once

// The marks of a job repeat by repeat: what is the same in all of them (fonts, items
// without a placeholder) is read and made once, and no repeat is kept.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "engrave/mark/mark.h"
#include "proto/job.pb.h"
#include "services/job/marks/mark_shapes.h"
#include "services/job/marks/mark_table.h"
#include "services/job/models/model_sources.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

/// One thread at a time; another thread takes Another.
class RepeatMarks {
 public:
  /// `files` as JobMarkFilesOf names them. Errors as of MakeJobMarks.
  static Result<RepeatMarks> Open(const JobSpec& job, const MachineSpec& machine,
                                  std::vector<FileBytes> files, const ReadLimits& limits);

  /// The same marks for another thread, with all that was read and made for these.
  RepeatMarks Another() const;

  std::size_t count() const { return job_->table->repeat_count(); }
  const std::vector<mark::Pen>& pens() const { return job_->pens; }
  /// kTooLarge: so many marks of all repeats are more than kMaxMarks.
  Status CheckCount(std::size_t marks) const;

  /// The marks of a repeat, from 0, item by item: the same whenever they are made. Errors
  /// and warnings as of MakeJobMarks; a warning is added once.
  Result<std::vector<mark::Mark>> Make(std::size_t repeat, Warnings& warnings);

 private:
  /// What is read once.
  struct JobOfMarks {
    Marks marks;
    std::vector<FileBytes> files;
    ReadLimits limits;
    std::vector<MarkFile> named;
    std::vector<std::span<const MarkFile>> item_files;
    MarkFile table_file;
    std::optional<MarkTable> table;
    std::vector<mark::Pen> pens;
    std::vector<std::optional<DotRows>> rows;  // of each item

    /// To each item its own files, in the order of JobMarkFilesOf.
    Status DivideFiles();
    Status TooFewFiles(std::size_t needed) const;
  };
  using ConstantMarks = std::shared_ptr<const std::vector<mark::Mark>>;

  explicit RepeatMarks(std::shared_ptr<const JobOfMarks> job);
  Error Named(Error error, int item, std::size_t repeat) const;
  Result<std::vector<mark::Mark>> MarksOf(const MarkItem& item, std::uint32_t pen,
                                          Warnings& warnings);
  void Append(std::vector<mark::Mark> marks, std::size_t repeat,
              std::vector<mark::Mark>& made) const;

  std::shared_ptr<const JobOfMarks> job_;
  std::vector<OpenFonts> fonts_;         // of texts
  std::vector<ConstantMarks> constant_;  // of items that are the same in all repeats
};

}  // namespace intaglio
