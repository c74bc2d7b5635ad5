#pragma once

// Jobs that are submitted over HTTP, by `intaglio submit FILE --id ID`: the same checks,
// defaults and answers as on the command line, and the same rule of its id
// (services/job/files/submission_id.h). A job over HTTP is made from files that were sent
// for it (upload_folder.h), never from others of the console's computer but the profiles
// of the machines of the shop.

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/console.pb.h"
#include "proto/job.pb.h"
#include "proto/preview.pb.h"
#include "services/console/submit/job_choices.h"
#include "services/console/submit/upload_folder.h"

namespace intaglio::console {

struct SubmissionAnswer {
  int status = 200;  ///< of HTTP
  SubmitAnswer answer;
};

struct PreviewAnswer {
  int status = 200;  ///< of HTTP
  std::optional<JobPreview> preview;
  ConsoleError refusal;  ///< why there is none
};

/// Beside the files of a submission, once its preview was made: one of the pictures, of
/// points or of contours.
inline constexpr char kPreviewFolder[] = ".preview";
inline constexpr std::array kPreviewPictures = {".preview/preview.png",
                                                ".preview/preview.svg"};

/// Waits for the job service: not from a thread that has to answer a stop.
class Submissions {
 public:
  /// `shop_arguments`: the options by which `intaglio` finds the shop; `materials`: its
  /// material base, empty: the user's; `machines`: those whose profiles a job may name.
  Submissions(const UploadFolder& uploads, std::vector<std::string> shop_arguments,
              std::string materials, ShopMachines machines)
      : uploads_(uploads),
        shop_arguments_(std::move(shop_arguments)),
        materials_(std::move(materials)),
        machines_(std::move(machines)) {}

  /// `job_file`: a job file, JSON or text format. 200 taken, also when it was before; 422
  /// refused, with the reason; 503, 504: not known, the same again is safe.
  SubmissionAnswer Submit(const std::string& id, const std::string& job_file) const;

  /// Writes a job and its files into a folder, and returns the job file.
  using Writer =
      std::function<Result<std::filesystem::path>(const std::filesystem::path& folder)>;
  /// The same for a job that this program itself writes, into a folder that no upload
  /// reaches. What was written for this id before is submitted again as it is.
  SubmissionAnswer SubmitWritten(const std::string& id, const Writer& writer) const;

  /// What `intaglio preview FILE` finds out, and its picture. 422, 503, 504 as above.
  PreviewAnswer Preview(const std::string& id, const std::string& job_file) const;

 private:
  Result<std::filesystem::path> Write(const std::string& id,
                                      const std::string& job_file) const;
  Result<std::filesystem::path> WriteOnce(const std::string& id,
                                          const Writer& writer) const;
  SubmissionAnswer SubmitFile(const std::string& id,
                              const Result<std::filesystem::path>& file) const;

  const UploadFolder& uploads_;
  std::vector<std::string> shop_arguments_;
  std::string materials_;
  ShopMachines machines_;
};

/// A job file in JSON begins with '{'; one in text format cannot.
bool IsJson(const std::string& job_file);

/// Every file that the job names was sent whole into `folder`, its machine profile too
/// unless it is the name of a supplied one or the profile of a machine of `shop`; fonts
/// may be families. kInvalidValue, kNotFound with the field.
Status CheckFilesOfSubmission(JobSpec job, const std::filesystem::path& folder,
                              const std::vector<ShopMachine>& shop);

}  // namespace intaglio::console
