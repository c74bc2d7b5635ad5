#include "services/client/refusal_code.h"

#include "services/client/job_view.h"

namespace intaglio::client {
namespace {

constexpr intaglio_CommandAnswerCode kRefusals[] = {
    intaglio_ANSWER_UNKNOWN_JOB,  intaglio_ANSWER_WRONG_EPOCH,
    intaglio_ANSWER_ENDED_JOB,    intaglio_ANSWER_NOT_YET,
    intaglio_ANSWER_SUPERSEDED,   intaglio_ANSWER_STOP_PRESSED,
    intaglio_ANSWER_OUT_OF_RANGE, intaglio_ANSWER_NEEDS_CONSENT,
    intaglio_ANSWER_SAME_BLOCK,   intaglio_ANSWER_NOT_MOUNTED,
    intaglio_ANSWER_NOT_LEFT_OUT, intaglio_ANSWER_UNDECIDED,
    intaglio_ANSWER_TOO_MANY};

}  // namespace

std::string RefusalCode(const Error& error) {
  if (error.code == ErrorCode::kRefused) {
    for (const intaglio_CommandAnswerCode code : kRefusals) {
      if (error.value == NameOf(code)) return error.value;
    }
  }
  return ErrorCodeName(error.code);
}

}  // namespace intaglio::client
