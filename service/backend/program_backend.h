// A backend for systems other than Slurm. The backend runs a program, which may be written in any
// language. docs/BACKENDS.md specifies the program's questions and answers; messages.h has the
// JSON. Not thread-safe.
#pragma once

#include <atomic>
#include <string>
#include <string_view>

#include "service/backend/backend.h"
#include "service/backend/messages.h"

namespace sleight::backend {

struct ProgramSettings {
  std::string program{};     ///< absolute path, or a name on PATH
  double answer_s_max = 60;  ///< then the program is killed, and the system counts as away
};

class ProgramBackend final : public Backend {
 public:
  explicit ProgramBackend(ProgramSettings settings);

  Seen launch(const Order& order) override;
  Seen state(const AttemptName& name) override;
  bool signal(const AttemptName& name, keeper::Stop how) override;
  std::map<AttemptName, Seen> list(const std::string& daemon) override;
  std::string log(const AttemptName& name, const std::string& folder,
                  std::size_t bytes_max) override;
  void end_soon() override { is_ending_ = true; }
  std::string title() const override;

 private:
  std::string ask(std::string_view verb, const Question& question) const;

  ProgramSettings settings_;
  std::atomic<bool> is_ending_ = false;
};

}  // namespace sleight::backend
