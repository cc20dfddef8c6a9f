// `sleight submit`: builds a submission from a file or word and options, and prints the result.
//
// The client reads the files and sends their text, never a path. An unchanged request is sent as
// written, so that line numbers in the service's errors are right. If options (`--set`, `-n`) set
// keys, this program's worlds read the request, and its normalised text is sent.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "clients/cli/given_request.h"
#include "common/base/result.h"
#include "common/request/diagnostic.h"
#include "common/request/sets.h"
#include "common/rpc/client.h"

namespace sleight::cli {

struct SubmitOptions {
  std::string request_path{};  ///< or a word for balls to spell
  std::string word{};
  std::optional<request::Asked> asked{};  ///< replaces the request's [stop]
  std::string asked_by{};                 ///< the option that sets `asked`, for errors
  std::vector<std::string> sets{};
  std::optional<std::uint32_t> cores{};
  std::uint32_t ranks = 0;
  std::string memory{};  ///< such as "2 GB"; empty: the default
  std::int32_t priority = 0;
  std::vector<std::string> options{};  ///< such as "partition=long", for the backend
  std::string name{};                  ///< empty: from the file or the word
  bool strict = false;
  bool watch = false;
  bool wait = false;
  bool json = false;
};

/// Functions of this program's worlds. The main program passes them.
struct RequestTexts {
  /// Sets these keys in a request and returns its normalised text, or errors
  /// (request::read_request_with).
  std::function<base::Result<std::string, std::vector<request::Diagnostic>>(
      std::string_view text, std::string_view file, std::span<const request::KeySet> sets,
      std::optional<request::Asked> asked)>
      normalised;
};

/// Returns a submission that has all its jobs but no key. Returns errors if the --set options or
/// the request have any. Throws base::Error(usage) if the submission is too large.
base::Result<rpc::Submission, std::vector<request::Diagnostic>> submission_of(
    const SubmitOptions& options, const GivenRequest& given, const RequestTexts& texts);

/// Returns a line such as "job 17 (hi)", then lines with commands to type next.
std::string submitted_text(const rpc::Submitted& submitted, const std::string& name);

/// Submits. Returns the exit code: 3 after printing errors of the request.
int submit(const std::string& socket, const SubmitOptions& options, const RequestTexts& texts);

}  // namespace sleight::cli
