#include "service/daemon/lease_watch.h"

#include <algorithm>

#include "common/base/error.h"
#include "common/base/file_system.h"
#include "common/store/lease_files.h"

namespace sleight::daemon {

bool LeaseWatch::may_live(double now_s) {
  try {
    if (!base::PosixFileSystem().exists(run_folder_)) return false;
    store::PosixLeaseFiles files(run_folder_, store::this_process());
    const auto generations = files.list();
    if (generations.empty()) return false;
    const auto text = files.read(generations.back());
    if (!text) return true;  // the file is being replaced
    const auto lease = store::LeaseText::from_text(*text);
    if (lease && (lease->is_released || files.is_gone(lease->holder))) return false;
    if (generations.back() != generation_ || *text != text_) {
      generation_ = generations.back();
      text_ = *text;
      since_s_ = now_s;
    }
    const double lease_s =
        lease ? std::min(lease->lease_s, store::k_lease_s_max) : store::k_lease_s;
    return now_s - since_s_ < lease_s;
  } catch (const base::Error&) {
    return true;
  }
}

}  // namespace sleight::daemon
