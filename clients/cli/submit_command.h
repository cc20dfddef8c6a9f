// `sleight submit`: builds a submission from a file or word and options, and prints the result.
//
// The client reads the files and sends their text, never a path. An unchanged request is sent as
// written, so that the service's errors have its line numbers. If options set keys (`--set`, `-n`),
// this program's worlds read the request, and the normalised text is sent.
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

/// Access to this program's worlds, passed by main.
struct RequestTexts {
  /// Returns a request's normalised text with these keys set (request::read_request_with), or the
  /// errors.
  std::function<base::Result<std::string, std::vector<request::Diagnostic>>(
      std::string_view text, std::string_view file, std::span<const request::KeySet> sets,
      std::optional<request::Asked> asked)>
      normalised;
};

/// Returns a submission with all its jobs but no key, or the errors of the --set options or the
/// request. Throws base::Error(usage) if the submission is too large.
base::Result<rpc::Submission, std::vector<request::Diagnostic>> submission_of(
    const SubmitOptions& options, const GivenRequest& given, const RequestTexts& texts);

/// Returns "job 17 (hi)" and the next commands to type, in several lines.
std::string submitted_text(const rpc::Submitted& submitted, const std::string& name);

/// Submits. Returns the exit code: 3 after printing errors of the request.
int submit(const std::string& socket, const SubmitOptions& options, const RequestTexts& texts);

}  // namespace sleight::cli
