// `sleight submit`: from a file, a word and options to a submission, and what is told of it.
//
// The client reads the files; text travels, never a path. A request that nothing was changed in
// goes as it is written, so that the service's errors have its lines. Where keys are set (`--set`,
// `-n`), this program's worlds read it, and its normalised text goes.
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

/// As the command line gives them.
struct SubmitOptions {
  std::string request_path{};             ///< or, in its place,
  std::string word{};                     ///< that balls spell
  std::optional<request::Asked> asked{};  ///< in place of the request's [stop]
  std::string asked_by{};                 ///< the option, for errors
  std::vector<std::string> sets{};
  std::optional<std::uint32_t> cores{};
  std::uint32_t ranks = 0;
  std::string memory{};  ///< "2 GB"; empty: the default
  std::int32_t priority = 0;
  std::vector<std::string> options{};  ///< "partition=long", for the system that runs it
  std::string name{};                  ///< empty: the file's, or the word
  bool strict = false;
  bool watch = false;
  bool wait = false;
  bool json = false;
};

/// Requests as the worlds of a program have them; its main gives these.
struct RequestTexts {
  /// The normalised text of a request with these sets, as request::read_request_with reads it; or
  /// what is wrong.
  std::function<base::Result<std::string, std::vector<request::Diagnostic>>(
      std::string_view text, std::string_view file, std::span<const request::KeySet> sets,
      std::optional<request::Asked> asked)>
      normalised;
};

/// All jobs of a submission, without its key; or what is wrong with sets or request. Throws
/// base::Error(usage) where it is more than a submission may be.
base::Result<rpc::Submission, std::vector<request::Diagnostic>> submission_of(
    const SubmitOptions& options, const GivenRequest& given, const RequestTexts& texts);

/// "job 17 (hi)" and what to type next, over several lines.
std::string submitted_text(const rpc::Submitted& submitted, const std::string& name);

/// Submits; returns the exit code: 3 after the errors of the request were printed.
int submit(const std::string& socket, const SubmitOptions& options, const RequestTexts& texts);

}  // namespace sleight::cli
