// This machine as a backend (backend.h): keepers beside one another, with no queue before them. The
// daemon itself has a shorter way to them (daemon/local_attempts.h); this one is the model of the
// interface, and what its conformance suite is tried on first.
//
// Launched attempts are in a folder of its own, a file each: which folder, which keeper. How one
// stands is read from its job's folder, where its keeper writes. So every process that has the two
// sees the same.
//
// Not thread-safe.
#pragma once

#include <optional>
#include <string>

#include "service/backend/backend.h"
#include "service/keeper/backend.h"

namespace sleight::backend {

class LocalEngine final : public Backend {
 public:
  /// `register_folder` is made where it is missing.
  LocalEngine(std::string register_folder, keeper::Programs programs);

  Seen launch(const Order& order) override;
  Seen state(const AttemptName& name) override;
  bool signal(const AttemptName& name, keeper::Stop how) override;
  std::map<AttemptName, Seen> list(const std::string& daemon) override;
  std::string log(const AttemptName& name, const std::string& folder,
                  std::size_t bytes_max) override;
  std::string title() const override { return "this machine"; }

 private:
  struct Launched {
    std::string folder{};
    keeper::ProcessIdentity keeper{};
  };
  std::string path_of(const AttemptName& name) const;
  std::optional<Launched> launched(const AttemptName& name) const;

  std::string register_;
  keeper::LocalBackend keepers_;
};

}  // namespace sleight::backend
